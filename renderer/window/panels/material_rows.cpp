#include "renderer/window/panels/material_rows.h"

#include <algorithm>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

using Material = MaterialDescription;
using Edit = MaterialEdit;

constexpr float kMaxEmission = 1000.0f;

bool has_interior(const Material& original, const Edit&) { return !original.thin_walled; }

constexpr MaterialRow kBase[] = {
    {"base_color", "Base Colour", "Colour of the surface, multiplied by the texture"},
    {"roughness", "Roughness", "0 is a mirror, 1 is matt. Multiplies the texture."},
    {"metallic", "Metalness", "0 is a dielectric, 1 is a metal. Multiplies the texture."},
    {"transmission", "Transmission",
     "Fraction of light that passes through the surface. Multiplies the texture."},
    {.parameter = "normal_scale",
     .label = "Normal Strength",
     .help = "Strength of the normal map",
     .maximum = 4.0f,
     .applies = [](const Material& original,
                   const Edit&) { return original.normal_texture.image >= 0; }},
    {"emission", "Emission", "Radiance that the surface emits, multiplied by the texture", 0.0f,
     kMaxEmission},
};
constexpr MaterialRow kReflection[] = {
    {.parameter = "ior",
     .label = "IOR",
     .help = "Index of refraction: 1.33 water, 1.5 glass, 2.42 diamond",
     .minimum = 1.0f,
     .maximum = 3.0f,
     .applies = [](const Material& original, const Edit&) { return original.ior != 0.0f; }},
    {"specular", "Strength", "Strength of the dielectric reflection. 0 leaves a matt base."},
    {"specular_color", "Colour",
     "Colour of the dielectric reflection at normal incidence. May exceed 1.", 0.0f, 25.0f},
};
constexpr MaterialRow kInterior[] = {
    {.parameter = "attenuation_color",
     .label = "Colour",
     .help = "Colour of white light after it has travelled the distance below",
     .applies = has_interior},
    {.parameter = "attenuation_distance",
     .label = "Distance",
     .help = "Distance in metres after which white light has the colour above",
     .minimum = 1e-4f,
     .maximum = 100.0f,
     .format = "%.4g m",
     .logarithmic = true,
     .applies = has_interior},
    {.parameter = "dispersion",
     .label = "Dispersion",
     .help = "20 divided by the Abbe number: 0.33 crown glass, 0.36 diamond, 2 rutile",
     .maximum = 2.0f,
     .applies = [](const Material& original,
                   const Edit&) { return !original.thin_walled && original.ior > 0.0f; }},
};
constexpr MaterialRow kDiffuseTransmission[] = {
    {"diffuse_transmission", "Amount",
     "Fraction of diffuse light that passes to the other side. Multiplies the texture."},
    {"diffuse_transmission_color", "Colour",
     "Colour of the light that passes to the other side, multiplied by the texture"},
};
bool has_direction(const Material& original, const Edit& edit) {
  return has_tangent_space(original) || edit.anisotropy.has_value();
}
constexpr MaterialRow kAnisotropy[] = {
    {.parameter = "anisotropy",
     .label = "Strength",
     .help = "How much the highlights are stretched. Multiplies the texture.",
     .applies = has_direction},
    {.parameter = "anisotropy_rotation",
     .label = "Rotation",
     .help = "Direction of the highlights, counter-clockwise from the mesh's tangent",
     .minimum = -180.0f,
     .maximum = 180.0f,
     .format = "%.1f°",
     .applies = has_direction},
};
constexpr MaterialRow kIridescence[] = {
    {"iridescence", "Amount", "Strength of the film's colours. Multiplies the texture."},
    {"iridescence_ior", "IOR", "Index of refraction of the film", 1.0f, 3.0f},
    {"iridescence_thickness", "Thickness",
     "Thickness of the film in nanometres. With a texture, the maximum thickness.", 0.0f, 2000.0f,
     "%.0f nm"},
};
constexpr MaterialRow kSheen[] = {
    {"sheen_color", "Colour", "Colour of the fibres. Black turns sheen off."},
    {"sheen_roughness", "Roughness", "How far the fibres scatter light. Multiplies the texture."},
};
constexpr MaterialRow kClearcoat[] = {
    {"clearcoat", "Amount", "Strength of the clear layer. Multiplies the texture."},
    {"clearcoat_roughness", "Roughness", "Roughness of the clear layer. Multiplies the texture."},
};

constexpr MaterialGroup kGroups[] = {
    {"", "Properties of every material", kBase, [](const Material&) { return true; }},
    {"Clear Coat", "A clear layer over the material", kClearcoat,
     [](const Material& original) { return original.clearcoat > 0.0f; }},
    {"Sheen", "Fine fibres, as on velvet", kSheen,
     [](const Material& original) { return !is_black(original.sheen_color); }},
    {"Anisotropy", "Stretched highlights, as on brushed metal", kAnisotropy,
     [](const Material& original) { return original.anisotropy > 0.0f; }},
    {"Iridescence", "A thin film, as on soap bubbles", kIridescence,
     [](const Material& original) { return original.iridescence > 0.0f; }},
    {"Diffuse Transmission", "Light that shines through, as through leaves or paper",
     kDiffuseTransmission,
     [](const Material& original) { return original.diffuse_transmission > 0.0f; }},
    {"Interior", "How the volume inside changes light", kInterior,
     [](const Material& original) { return !original.thin_walled; }},
    {"Reflection", "Reflection of materials that are not metals", kReflection,
     [](const Material& original) {
       return original.ior != 1.5f || original.specular != 1.0f ||
              original.specular_color != Rgb(1.0f);
     }},
};

}  // namespace

bool MaterialGroup::edited(const MaterialEdit& edit) const {
  return std::ranges::any_of(rows, [&](const MaterialRow& row) {
    const MaterialParameter& p = material_parameter(row.parameter);
    return p.color ? (edit.*p.edited_color).has_value() : (edit.*p.edited_number).has_value();
  });
}

std::span<const MaterialGroup> material_groups() { return kGroups; }

bool is_applicable(const MaterialRow& row, const MaterialDescription& original,
                   const MaterialEdit& edit) {
  return !row.applies || row.applies(original, edit);
}

std::vector<const MaterialGroup*> applicable_groups(const MaterialDescription& original,
                                                    const MaterialEdit& edit) {
  std::vector<const MaterialGroup*> groups;
  for (const bool present : {true, false}) {
    for (const MaterialGroup& group : kGroups) {
      const bool applies = std::ranges::any_of(
          group.rows, [&](const MaterialRow& row) { return is_applicable(row, original, edit); });
      if (applies && group.present(original) == present) groups.push_back(&group);
    }
  }
  return groups;
}

}  // namespace emberline
