# coppice::core is the headers. coppice_component(NAME sources...) makes coppice::NAME, a compiled component.
# coppice_own_build(target) is for targets that only this repository builds: warnings are errors there.

add_library(coppice_core INTERFACE)
add_library(coppice::core ALIAS coppice_core)
set_target_properties(coppice_core PROPERTIES EXPORT_NAME core)
target_compile_features(coppice_core INTERFACE cxx_std_20)
target_include_directories(coppice_core INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
target_link_libraries(coppice_core INTERFACE glm::glm hwy::hwy nanoflann::nanoflann)

function(coppice_warnings target)
  if(PROJECT_IS_TOP_LEVEL)
    target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Werror)
  endif()
endfunction()

function(coppice_component name)
  add_library(coppice_${name} ${ARGN})
  add_library(coppice::${name} ALIAS coppice_${name})
  set_target_properties(coppice_${name} PROPERTIES
    EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON INSTALL_RPATH "$ORIGIN"
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_link_libraries(coppice_${name} PUBLIC coppice::core)
  coppice_warnings(coppice_${name})
endfunction()

function(coppice_own_build target)
  coppice_warnings(${target})
  if(COPPICE_NATIVE)
    target_compile_options(${target} PRIVATE -march=native)
  endif()
endfunction()
