# Sources of one folder are compiled together: what they include is read, and what they instantiate is compiled, once a folder and not
# once a source, which halves the build. So the names that a source keeps to itself (in its unnamed namespace) are the only ones of its
# folder. Sources with compile options of their own stay alone, and those below that say why. -D PALPATE_UNITE=OFF compiles each by itself.
# In experiments/ and in its tests, which are not optimised in full, most of a folder's time goes into what they all instantiate: several
# folders are compiled together there, as palpate_hall says.
option(PALPATE_UNITE "Compile the sources of each folder together" ON)

# Sets `out` to the name under which the sources of `folder` (relative to the project) are compiled: its own, or that of several folders.
function(palpate_hall folder out)
  set(${out} ${folder} PARENT_SCOPE)
  foreach(hall "contests=contests(/[a-z]+)?" "judging=envelope|fit|fit/candidates|gates|judging|live|trials"
               "plans=grading|meshes|plan_reader|scene_reader|scene_writer|spring_training|text"
               "running=campaign|contestants|files|processes|records|registry|rounds|runner")
    string(REGEX MATCH "^([a-z]+)=(.*)$" parts ${hall})
    set(name ${CMAKE_MATCH_1})
    if(folder MATCHES "^((tests/)?experiments)/(${CMAKE_MATCH_2})$")
      set(${out} ${CMAKE_MATCH_1}/${name} PARENT_SCOPE)
    endif()
  endforeach()
endfunction()

# Unites the sources of all targets of `folder` and of the folders below it.
function(palpate_unite folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type MATCHES "^(STATIC_LIBRARY|OBJECT_LIBRARY|EXECUTABLE)$")
      set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
      # A united source is no header: what it keeps to itself is its own still.
      target_compile_options(${target} PRIVATE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage>)
      get_target_property(sources ${target} SOURCES)
      foreach(source IN LISTS sources)
        get_filename_component(path ${source} ABSOLUTE BASE_DIR ${folder})
        cmake_path(IS_PREFIX PROJECT_SOURCE_DIR ${path} NORMALIZE is_ours)
        # Alone: sources with an instruction set of their own, and the simplifiers, whose times are held against
        # others' to a few percent: united, g++ 12 inlines them otherwise.
        if(path MATCHES "_avx2\\.cpp$|/core/simplify/")
          set_property(SOURCE ${path} DIRECTORY ${folder} PROPERTY SKIP_UNITY_BUILD_INCLUSION ON)
        elseif(path MATCHES "\\.cpp$" AND is_ours)
          cmake_path(RELATIVE_PATH path BASE_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE name)
          cmake_path(GET name PARENT_PATH group)
          palpate_hall(${group} group)
          string(REPLACE "/" "_" group "${group}")
          set_property(SOURCE ${path} DIRECTORY ${folder} PROPERTY UNITY_GROUP ${group})
        endif()
      endforeach()
    endif()
  endforeach()
  get_property(children DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(child IN LISTS children)
    palpate_unite(${child})
  endforeach()
endfunction()
