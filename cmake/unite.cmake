# Sources of one folder are compiled together: what they include is read, and what they instantiate is compiled, once a folder and not
# once a source, which halves the build. So the names that a source keeps to itself (in its unnamed namespace) are the only ones of its
# folder. Sources with compile options of their own stay alone, and those below that say why. -D PALPATE_UNITE=OFF compiles each by itself.
option(PALPATE_UNITE "Compile the sources of each folder together" ON)

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
