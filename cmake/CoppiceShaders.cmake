# coppice_embed_shaders(TARGET a.comp ...): compiles GLSL to SPIR-V and gives TARGET, for each shader NAME.comp,
# the header "shaders/NAME.h" with the words `coppice::shaders::NAME[]`. The build folder keeps
# shaders/NAME.spv: the same code with the names of its variables, for tools that reflect it.
find_program(GLSLC glslc REQUIRED)

function(coppice_compile_shader source name folder)
  set(words ${folder}/${name}.words)
  set(flags --target-env=vulkan1.3 -fshader-stage=compute -O -Werror -I ${PROJECT_SOURCE_DIR}/include)
  add_custom_command(
    OUTPUT ${words} ${folder}/${name}.spv
    COMMAND ${GLSLC} ${flags} -mfmt=num -MD -MF ${words}.d -MT ${words} -o ${words} ${source}
    COMMAND ${GLSLC} ${flags} -g -o ${folder}/${name}.spv ${source}
    DEPENDS ${source} DEPFILE ${words}.d
    COMMENT "Compiling shader ${name}" VERBATIM)
  set(header
"// Generated from ${name}.comp.
#pragma once
#include <cstdint>
namespace coppice::shaders {
inline constexpr std::uint32_t ${name}[] = {
#include \"${name}.words\"
};
}
")
  file(CONFIGURE OUTPUT ${folder}/${name}.h CONTENT "${header}" @ONLY)
endfunction()

function(coppice_embed_shaders target)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/shaders)
  file(MAKE_DIRECTORY ${folder})
  foreach(source ${ARGN})
    cmake_path(ABSOLUTE_PATH source)
    cmake_path(GET source STEM name)
    coppice_compile_shader(${source} ${name} ${folder})
    target_sources(${target} PRIVATE ${folder}/${name}.words)
  endforeach()
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
  set_target_properties(${target} PROPERTIES COPPICE_SHADER_DIRECTORY ${folder})
endfunction()
