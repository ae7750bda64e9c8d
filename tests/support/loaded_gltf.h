// Loads glTF files that tests build.
#pragma once

#include <string>

#include "io/gltf/gltf_file.h"
#include "renderer/core/errors.h"
#include "support/gltf_builder.h"

namespace emberline::test {

inline SceneDescription load(const GltfBuilder& gltf) {
  const TempFolder folder;
  return load_gltf(gltf.write_glb(folder / "a.glb"), {});
}

inline std::string message_of(const GltfBuilder& gltf) {
  try {
    load(gltf);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace emberline::test
