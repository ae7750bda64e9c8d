// KHR_materials_pbrSpecularGlossiness (archived) as metallic-roughness.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "renderer/description/scene_description.h"

namespace emberline {

// Sets base colour, alpha, metallic and roughness from the extension's factors. A specular
// texture cannot be folded into factors: such a material becomes a dielectric of medium gloss.
void convert_specular_glossiness(const nlohmann::json& extension, MaterialDescription& material);

}  // namespace emberline
