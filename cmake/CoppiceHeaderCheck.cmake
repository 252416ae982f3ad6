# Every public header compiles alone, and twice in one translation unit. Two translation units that include all of
# them link with every component, whole: a function that is defined twice stops the build. No -march=native here.

set(check_directory ${CMAKE_CURRENT_BINARY_DIR}/headers)

# The installed headers, as paths below include/.
function(coppice_public_headers result)
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/include
       ${PROJECT_SOURCE_DIR}/include/coppice/*.hpp ${PROJECT_SOURCE_DIR}/include/coppice/*.h)
  foreach(component IN LISTS coppice_all_components)
    if(NOT component IN_LIST coppice_components)
      list(FILTER headers EXCLUDE REGEX "^coppice/${component}/")
    endif()
  endforeach()
  set(${result} ${headers} PARENT_SCOPE)
endfunction()

# One source a header, that includes it twice.
function(coppice_check_headers_alone headers components)
  set(sources)
  foreach(header IN LISTS headers)
    string(MAKE_C_IDENTIFIER ${header} name)
    set(source ${check_directory}/${name}.cpp)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include <${header}>\n#include <${header}>\n")
    list(APPEND sources ${source})
  endforeach()
  add_library(coppice_headers_alone OBJECT ${sources})
  target_link_libraries(coppice_headers_alone PRIVATE coppice::core ${components})
  target_compile_options(coppice_headers_alone PRIVATE -O0)
  coppice_warnings(coppice_headers_alone)
endfunction()

function(coppice_check_headers_twice headers components)
  list(TRANSFORM headers REPLACE "(.+)" "#include <\\1>\n" OUTPUT_VARIABLE includes)
  list(JOIN includes "" includes)
  file(CONFIGURE OUTPUT ${check_directory}/first.cpp
       CONTENT "${includes}int second();\nint main() { return second(); }\n")
  file(CONFIGURE OUTPUT ${check_directory}/second.cpp
       CONTENT "${includes}int second();\nint second() { return 0; }\n")
  add_executable(coppice_headers_twice ${check_directory}/first.cpp ${check_directory}/second.cpp)
  target_link_libraries(coppice_headers_twice PRIVATE coppice::core)
  foreach(component IN LISTS components)
    target_link_libraries(coppice_headers_twice PRIVATE $<LINK_LIBRARY:WHOLE_ARCHIVE,${component}>)
  endforeach()
  target_compile_options(coppice_headers_twice PRIVATE -O0)
  coppice_warnings(coppice_headers_twice)
  add_test(NAME "headers: all link twice" COMMAND coppice_headers_twice)
endfunction()

coppice_public_headers(headers)
list(TRANSFORM coppice_components PREPEND coppice:: OUTPUT_VARIABLE components)
coppice_check_headers_alone("${headers}" "${components}")
coppice_check_headers_twice("${headers}" "${components}")
