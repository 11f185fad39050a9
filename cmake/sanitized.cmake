# A sanitizer's build is made beside the usual one in every ./check, so it reads the large headers
# once. The usual one does not, and so finds what a file forgets to include.
foreach(directory IN ITEMS renderers harness harness/report harness/history tests)
  get_property(targets DIRECTORY ${directory} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(NOT type MATCHES "STATIC_LIBRARY|EXECUTABLE")
      continue()
    endif()
    target_precompile_headers(
      ${target} PRIVATE ${CMAKE_CURRENT_LIST_DIR}/sanitized.h
                        $<$<STREQUAL:${directory},tests>:<gtest/gtest.h$<ANGLE-R>>)
    if(type STREQUAL EXECUTABLE)
      target_sources(${target} PRIVATE ${CMAKE_SOURCE_DIR}/tests/sanitizers/keep_libraries.cpp)
    endif()
    # Sources with options of their own do not fit a header that was compiled without them.
    get_target_property(sources ${target} SOURCES)
    foreach(source IN LISTS sources)
      get_source_file_property(options ${source} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
      if(options)
        set_source_files_properties(${source} TARGET_DIRECTORY ${target}
                                    PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
      endif()
    endforeach()
  endforeach()
endforeach()
