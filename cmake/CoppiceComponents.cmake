# coppice_all_components: the compiled components that exist. coppice_components: those that this build has.
set(coppice_all_components embree exr gltf kernels pca store vulkan)
set(coppice_components)
foreach(component IN LISTS coppice_all_components)
  string(TOUPPER ${component} option)
  if(COPPICE_${option})
    list(APPEND coppice_components ${component})
  endif()
endforeach()
