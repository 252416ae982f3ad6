# No code for newer processors under a name that other sources share: looks into the objects of coppice::kernels, and
# into one that breaks the rule. Needs GNU's objdump; Highway's other processors have one instruction set each.
find_package(Python3 COMPONENTS Interpreter)
if(NOT (Python3_FOUND AND CMAKE_OBJDUMP AND CMAKE_SYSTEM_NAME STREQUAL "Linux"
        AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU"))
  return()
endif()

set(objects $<TARGET_OBJECTS:coppice_kernels>)
set(baseline $<FILTER:${objects},INCLUDE,baseline>)
set(check ${CMAKE_COMMAND} -E env OBJDUMP=${CMAKE_OBJDUMP}
    $<TARGET_FILE:Python3::Interpreter> ${PROJECT_SOURCE_DIR}/scripts/check_instructions.py ${baseline})

add_test(NAME "kernels: newer instructions only under names of their own"
  COMMAND ${check} $<FILTER:${objects},INCLUDE,avx> COMMAND_EXPAND_LISTS)

add_library(coppice_shared_name OBJECT kernels/shared_name/shared_name.cpp)
add_test(NAME "kernels: newer instructions under a shared name are found"
  COMMAND ${check} $<TARGET_OBJECTS:coppice_shared_name> COMMAND_EXPAND_LISTS)
set_tests_properties("kernels: newer instructions under a shared name are found" PROPERTIES
  PASS_REGULAR_EXPRESSION "twice_under_a_shared_name[^\n]* is not in a target's namespace")

set_tests_properties("kernels: newer instructions only under names of their own"
  "kernels: newer instructions under a shared name are found" PROPERTIES
  LABELS kernels SKIP_REGULAR_EXPRESSION "SKIPPED:")
