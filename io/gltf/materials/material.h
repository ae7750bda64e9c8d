// Materials and their texture references.
#pragma once

#include <array>

#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Returns one MaterialDescription per glTF material, in which TextureRef::image holds glTF image
// indices. Ignored and approximated features go to `coverage`. A material that cannot be read is
// noted as broken. Unless options.lenient is set, this includes a material with a texture that has
// no image in a supported format.
std::vector<MaterialDescription> read_materials(const GltfDocument& document,
                                                const GltfOptions& options,
                                                CoverageReport& coverage);

// Returns pointers to all texture slots of `material`, which may be const. Every slot must be
// listed here: an unlisted slot would keep its glTF image index, and its UV set would not be read.
template <class Material>
auto texture_slots(Material& material) {
  return std::array{&material.base_color_texture,
                    &material.metallic_roughness_texture,
                    &material.normal_texture,
                    &material.emission_texture,
                    &material.specular_texture,
                    &material.specular_color_texture,
                    &material.glossiness_texture,
                    &material.transmission_texture,
                    &material.diffuse_transmission_texture,
                    &material.diffuse_transmission_color_texture,
                    &material.anisotropy_texture,
                    &material.iridescence_texture,
                    &material.iridescence_thickness_texture,
                    &material.sheen_color_texture,
                    &material.sheen_roughness_texture,
                    &material.clearcoat_texture,
                    &material.clearcoat_roughness_texture,
                    &material.clearcoat_normal_texture};
}

}  // namespace emberline
