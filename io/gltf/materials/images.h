// The images that materials use, decoded in parallel.
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

// The glTF images that a texture object names, the one to be used first: KHR_texture_basisu's,
// EXT_texture_webp's, its own.
std::vector<int> texture_sources(const nlohmann::json& texture);

// A glTF image, decoded; or why it is not.
struct GltfImage {
  DecodedImage decoded;
  std::string fault;         // of the image whose place this one has taken
  std::exception_ptr error;  // InputError
};

// Decodes the glTF images that the materials of scene.meshes, in all variants, name
// (TextureRef::image holds glTF indices on entry), fills scene.images and renumbers the references.
// Images of materials that no mesh wears are not read, those materials lose their textures. Counts
// and warns of repairs. Where KHR_texture_basisu or EXT_texture_webp is optional, the texture's
// next image takes the place of one that does not decode, with a warning. Throws InputError for an
// image that is missing or does not decode, unless options.lenient: then it becomes white, or a
// flat normal where a normal map is wanted. `known`, by glTF index, are not decoded again; those
// that are come to them, with their texels where `store` puts them.
void load_images(const GltfDocument& document, const GltfOptions& options,
                 std::map<int, GltfImage>& known, TextureStore& store, SceneDescription& scene);

}  // namespace emberline
