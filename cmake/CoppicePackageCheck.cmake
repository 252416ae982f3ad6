# Installs this build into a folder of its own, then builds and runs tests/consumer against what is there.
set(prefix ${CMAKE_CURRENT_BINARY_DIR}/prefix)
set(consumer ${CMAKE_CURRENT_SOURCE_DIR}/consumer)
set(consumer_settings -G ${CMAKE_GENERATOR} -DCMAKE_PREFIX_PATH=${prefix}
    -DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER} "-DCMAKE_CXX_FLAGS=${CMAKE_CXX_FLAGS}" -DCMAKE_BUILD_TYPE=Debug)
list(JOIN coppice_components "," component_names)

add_test(NAME "package: empty prefix" COMMAND ${CMAKE_COMMAND} -E rm -rf ${prefix})
add_test(NAME "package: install" COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${prefix})
set_tests_properties("package: empty prefix" "package: install" PROPERTIES FIXTURES_SETUP coppice_package)
set_tests_properties("package: install" PROPERTIES DEPENDS "package: empty prefix")

add_test(NAME "package: consumer" COMMAND ${CMAKE_CTEST_COMMAND}
  --build-and-test ${consumer} ${CMAKE_CURRENT_BINARY_DIR}/consumer --build-generator ${CMAKE_GENERATOR}
  --build-options ${consumer_settings} -DCOMPONENTS=${component_names} --test-command consumer)

# coppice_refused(NAME COMPONENT MESSAGE): asking for COMPONENT must end with MESSAGE.
function(coppice_refused name component message)
  add_test(NAME "package: ${name}" COMMAND ${CMAKE_COMMAND} -S ${consumer} -B ${CMAKE_CURRENT_BINARY_DIR}/${component}
    --fresh ${consumer_settings} -DCOMPONENTS=${component})
  set_tests_properties("package: ${name}" PROPERTIES PASS_REGULAR_EXPRESSION ${message})
endfunction()

coppice_refused("an unknown component is refused" teapot "Component teapot:[^.]*knows[ \n]+only")
foreach(component IN LISTS coppice_all_components)
  if(NOT component IN_LIST coppice_components)
    string(TOUPPER ${component} option)
    coppice_refused("${component}, which is not built, is refused" ${component} "-DCOPPICE_${option}=ON")
  endif()
endforeach()

get_property(package_tests DIRECTORY PROPERTY TESTS)
list(FILTER package_tests INCLUDE REGEX "^package: ")
set_tests_properties(${package_tests} PROPERTIES LABELS package TIMEOUT 300)
list(REMOVE_ITEM package_tests "package: empty prefix" "package: install")
set_tests_properties(${package_tests} PROPERTIES FIXTURES_REQUIRED coppice_package)
