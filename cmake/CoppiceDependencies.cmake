# Finds what coppice::core and each of coppice_components need. The installed package configuration includes
# this file too, so that a project that links Coppice looks for exactly the same libraries.
include(CMakeFindDependencyMacro)

# Ours: a missing library stops the configuration. In the package: it makes find_package(coppice) fail.
macro(coppice_find_dependency)
  if(CMAKE_FIND_PACKAGE_NAME STREQUAL "coppice")
    find_dependency(${ARGV})
  else()
    find_package(${ARGV} REQUIRED)
  endif()
endmacro()

coppice_find_dependency(glm)
coppice_find_dependency(hwy)
coppice_find_dependency(nanoflann)

if("embree" IN_LIST coppice_components)
  find_package(embree 4 QUIET)
  if(NOT embree_FOUND)
    coppice_find_dependency(embree 3.13)
  endif()
  coppice_find_dependency(TBB)
endif()
if("exr" IN_LIST coppice_components)
  coppice_find_dependency(OpenEXR)
endif()
if("gltf" IN_LIST coppice_components)
  coppice_find_dependency(TinyGLTF)
endif()
if("vulkan" IN_LIST coppice_components)
  coppice_find_dependency(Vulkan)
endif()
