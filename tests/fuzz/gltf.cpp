// Fuzzes a scene, .gltf or .glb (json_mutator.cpp keeps the container of a .glb valid). The only
// file to which the scene can refer is itself.
#include "io/gltf/gltf_file.h"

#include "fuzz/fuzz.h"
#include "support/scene_validation.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = fuzz::write_input(data, size, "scene.gltf");
  GltfOptions options;
  options.lenient = options.variants = size % 2 == 1;
  if (size % 3 == 0) options.time = 0.5;
  fuzz::allow_errors([&] {
    LoadProgress progress({}, {}, fuzz::small_limits(path));
    fuzz::require_none(test::find_scene_violation(load_gltf(path, options, progress)));
  });
  return 0;
}
