// Decodes the images that materials use, in parallel.
#pragma once

#include <exception>
#include <map>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "io/image/input.h"
#include "io/image/texture_store.h"

namespace emberline {

// A texture's image indices, preferred first: KHR_texture_basisu, EXT_texture_webp, its own.
std::vector<int> texture_sources(const nlohmann::json& texture);

// A decoded glTF image, or its error.
struct GltfImage {
  DecodedImage decoded;
  std::string fault;         // set if another image is used instead: why this one failed
  std::exception_ptr error;  // InputError
};

// Decodes the glTF images used by the materials of scene.meshes in all variants (TextureRef::image
// holds glTF indices on entry), fills scene.images and renumbers the references. Materials that no
// mesh uses lose their textures. Counts repairs and warns about them. If KHR_texture_basisu or
// EXT_texture_webp is optional and its image does not decode, uses the texture's next image, with a
// warning. Throws InputError for an image that is missing or does not decode; with options.lenient
// it becomes white, or a flat normal in a normal map. Images in `cached`, by glTF index, are not
// decoded again; new ones are added to it, with texels kept in `store`.
void load_images(const GltfDocument& document, const GltfOptions& options,
                 std::map<int, GltfImage>& cached, TextureStore& store, SceneDescription& scene);

}  // namespace emberline
