# With -DCMAKE_UNITY_BUILD=ON many files are compiled as one, which builds everything in less
# than half the time; after a change more than the changed file is compiled again.
set(CMAKE_UNITY_BUILD_BATCH_SIZE 16)

# gcc warns of types in unnamed namespaces where the file that has them is included by another.
if(CMAKE_UNITY_BUILD)
  target_compile_options(pliant_compile_options INTERFACE
    $<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>>)
endif()

# Says which sources of ${target} go together. That follows from their names alone, so that a new
# file does not bring others together that give different things the same name.
function(pliant_group_sources target)
  if(NOT CMAKE_UNITY_BUILD)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(LENGTH sources count)
  set(groups 1)
  while(count GREATER 16)
    math(EXPR groups "2 * ${groups}")
    math(EXPR count "(${count} + 1) / 2")
  endwhile()
  foreach(source IN LISTS sources)
    get_filename_component(name ${source} NAME)
    string(MD5 hash ${name})
    string(SUBSTRING ${hash} 0 6 hash)
    math(EXPR group "0x${hash} % ${groups}")
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${target}_${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()
