// The shortest program: a scene, an environment, an image.
// Usage: first_light SCENE.glb ENVIRONMENT.hdr OUT.exr
#include <coppice/core/error.hpp>
#include <coppice/embree/threads.hpp>
#include <coppice/embree/tracer.hpp>
#include <coppice/exr/read.hpp>
#include <coppice/exr/write.hpp>
#include <coppice/gltf/load.hpp>
#include <coppice/relight/cut_relighting.hpp>
#include <iostream>

int main(int argc, char** argv) try {
  if (argc != 4)
    throw coppice::InputError("first_light", "takes three files", "SCENE.glb ENVIRONMENT.hdr OUT.exr");
  const coppice::Scene scene = coppice::load_gltf(argv[1]);
  const coppice::Environment sky = coppice::read_environment(argv[2]);
  const coppice::EmbreeTracer tracer(scene);
  const coppice::Threads threads;
  coppice::CutRelighting relighting(scene, tracer, scene.camera.value_or(coppice::Camera{}), sky, {},
                                    threads);
  const coppice::FrameLighting frame = relighting.light(sky, 256);
  const coppice::Image image = relighting.image(relighting.shade(frame, threads));
  coppice::write_exr(argv[3], image.width, image.height, {{"", image}, {"A", relighting.direct().coverage}});
} catch (const coppice::InputError& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
