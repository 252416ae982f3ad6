# `cmake --install` gives headers, components and a package: find_package(coppice COMPONENTS embree exr …).
include(CMakePackageConfigHelpers)
set(package_directory ${CMAKE_INSTALL_LIBDIR}/cmake/coppice)

set(headers_left_out)
foreach(component IN LISTS coppice_all_components)
  if(NOT component IN_LIST coppice_components)
    list(APPEND headers_left_out PATTERN "coppice/${component}" EXCLUDE)
  endif()
endforeach()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/coppice DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN *.hpp PATTERN *.h ${headers_left_out})

# One export a component, so that the package asks only for the libraries of the components that are wanted.
foreach(component IN ITEMS core LISTS coppice_components)
  install(TARGETS coppice_${component} EXPORT coppice_${component})
  install(EXPORT coppice_${component} NAMESPACE coppice:: DESTINATION ${package_directory}
          FILE coppice_${component}.cmake)
endforeach()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/coppiceConfig.cmake.in coppiceConfig.cmake
                              INSTALL_DESTINATION ${package_directory})
write_basic_package_version_file(coppiceConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/coppiceConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/coppiceConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/CoppiceDependencies.cmake
        DESTINATION ${package_directory})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
