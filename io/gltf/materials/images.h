// Decodes in parallel the images that materials use.
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

// Returns a texture's image indices in order of preference: KHR_texture_basisu, EXT_texture_webp,
// source.
std::vector<int> texture_sources(const nlohmann::json& texture);

// A decoded glTF image, or its error.
struct GltfImage {
  DecodedImage decoded;
  std::string fault;         // if another image is used instead, why this image failed
  std::exception_ptr error;  // an InputError, or null
};

// Decodes the images that the materials of scene.meshes use in any variant, and fills scene.images.
// TextureRef::image must be a glTF index on entry and becomes an index into scene.images. Materials
// that no mesh uses lose their textures. Counts repairs and warns about them.
//
// If the extension KHR_texture_basisu or EXT_texture_webp is optional and its image cannot be
// decoded, uses the texture's next image, with a warning. Throws InputError for an image that is
// missing or cannot be decoded. With options.lenient, replaces such an image by a neutral texel
// instead: white, or a neutral direction for normal and anisotropy textures.
//
// Images in `cached` (by glTF index) are not decoded again. New images are added to `cached`, and
// their texels are added to `store`.
void load_images(const GltfDocument& document, const GltfOptions& options,
                 std::map<int, GltfImage>& cached, TextureStore& store, SceneDescription& scene);

}  // namespace emberline
