// The material extensions: what they say, into MaterialDescription.
#pragma once

#include "io/gltf/materials/object.h"

namespace emberline {

inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// All of KHR_materials_* that change how a surface scatters, except the above. Not for an unlit
// material, which must not have them: they are then reported as ignored. Beside
// KHR_materials_pbrSpecularGlossiness, which must stand alone, the index of refraction and the
// specular colour are its own; what lies on top of it is honoured.
void read_material_layers(const GltfMaterialObject& object, MaterialDescription& material);

// KHR_materials_pbrSpecularGlossiness, in place of pbrMetallicRoughness. It is exactly the material
// without metal of KHR_materials_ior's index 0 and KHR_materials_specular's colour, "Conversions".
void read_specular_glossiness(const GltfMaterialObject& object, MaterialDescription& material);

}  // namespace emberline
