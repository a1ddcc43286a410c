# cmake -DOUTPUT=FILE -DNAME=MACRO -DLIST=FILE -P hash_sources.cmake
# Writes a header with one hash over the sources that LIST names, one a line, in sorted order.
file(STRINGS ${LIST} sources)
list(SORT sources)
set(all "")
foreach(source IN LISTS sources)
  file(SHA256 ${source} hash)
  get_filename_component(name ${source} NAME)
  string(APPEND all "${name} ${hash}\n")
endforeach()
string(SHA256 hash "${all}")
file(WRITE ${OUTPUT} "// Made by cmake/hash_sources.cmake.\n#pragma once\n#define ${NAME} \"${hash}\"\n")
