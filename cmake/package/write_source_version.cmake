# cmake -DSOURCE=DIR -DOUTPUT=FILE -P write_source_version.cmake
# Writes which commit an installed program comes from (experiments/records/source_version.h): what git says where DIR is a checkout of
# its own, else what the source archive says of itself.
function(ask_git result)
  execute_process(COMMAND git -C ${SOURCE} ${ARGN} OUTPUT_VARIABLE said ERROR_QUIET RESULT_VARIABLE failed OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(failed)
    set(said "")
  endif()
  set(${result} "${said}" PARENT_SCOPE)
endfunction()

file(READ ${SOURCE}/experiments/records/source_version.yaml version)
string(REGEX MATCH "commit: \"([0-9a-f]*)\"" commit "${version}")
set(commit "${CMAKE_MATCH_1}")
set(dirty "")  # an archive does not tell
ask_git(top rev-parse --show-toplevel)
file(REAL_PATH ${SOURCE} own_top)
if(top STREQUAL own_top)
  ask_git(commit rev-parse HEAD)
  ask_git(changed status --porcelain --untracked-files=no)
  set(dirty "dirty: false\n")
  if(changed)
    set(dirty "dirty: true\n")
  endif()
endif()
file(WRITE ${OUTPUT} "commit: \"${commit}\"\nsource: package\n${dirty}")
