#include "renderer/window/panels/material_rows.h"

#include <algorithm>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

using Material = MaterialDescription;
using Edit = MaterialEdit;

constexpr float kMostEmission = 1000.0f;

bool has_interior(const Material& own, const Edit&) { return !own.thin_walled; }

constexpr MaterialRow kBase[] = {
    {"base_color", "Base Colour", "Colour of the surface, multiplied by the texture"},
    {"roughness", "Roughness", "0 is a mirror, 1 is matt. Multiplies the texture."},
    {"metallic", "Metalness", "0 is a dielectric, 1 is a metal. Multiplies the texture."},
    {"transmission", "Transmission",
     "Share of the light that passes the surface. Multiplies the texture."},
    {.parameter = "normal_scale",
     .label = "Normal Strength",
     .help = "Strength of the normal map",
     .most = 4.0f,
     .offered = [](const Material& own, const Edit&) { return own.normal_texture.image >= 0; }},
    {"emission", "Emission", "Radiance that the surface emits, multiplied by the texture", 0.0f,
     kMostEmission},
};
constexpr MaterialRow kReflection[] = {
    {.parameter = "ior",
     .label = "IOR",
     .help = "Index of refraction: 1.33 water, 1.5 glass, 2.42 diamond",
     .least = 1.0f,
     .most = 3.0f,
     .offered = [](const Material& own, const Edit&) { return own.ior != 0.0f; }},
    {"specular", "Strength", "Strength of the dielectric reflection. 0 leaves a matt base."},
    {"specular_color", "Colour",
     "Colour of the dielectric reflection at normal incidence. May exceed 1.", 0.0f, 25.0f},
};
constexpr MaterialRow kInterior[] = {
    {.parameter = "attenuation_color",
     .label = "Colour",
     .help = "Colour of white light after it has travelled the distance below",
     .offered = has_interior},
    {.parameter = "attenuation_distance",
     .label = "Distance",
     .help = "Distance in metres after which white light has the colour above",
     .least = 1e-4f,
     .most = 100.0f,
     .format = "%.4g m",
     .logarithmic = true,
     .offered = has_interior},
    {.parameter = "dispersion",
     .label = "Dispersion",
     .help = "20 divided by the Abbe number: 0.33 crown glass, 0.36 diamond, 2 rutile",
     .most = 2.0f,
     .offered = [](const Material& own,
                   const Edit&) { return !own.thin_walled && own.ior > 0.0f; }},
};
constexpr MaterialRow kDiffuseTransmission[] = {
    {"diffuse_transmission", "Amount",
     "Share of the diffuse light that passes to the other side. Multiplies the texture."},
    {"diffuse_transmission_color", "Colour",
     "Colour of the light that passes to the other side, multiplied by the texture"},
};
bool has_direction(const Material& own, const Edit& edit) {
  return has_tangent_space(own) || edit.anisotropy.has_value();
}
constexpr MaterialRow kAnisotropy[] = {
    {.parameter = "anisotropy",
     .label = "Strength",
     .help = "How much highlights stretch. Multiplies the texture.",
     .offered = has_direction},
    {.parameter = "anisotropy_rotation",
     .label = "Rotation",
     .help = "Direction of the highlights, counter-clockwise from the mesh's tangent",
     .least = -180.0f,
     .most = 180.0f,
     .format = "%.1f°",
     .offered = has_direction},
};
constexpr MaterialRow kIridescence[] = {
    {"iridescence", "Amount", "Strength of the film's colours. Multiplies the texture."},
    {"iridescence_ior", "IOR", "Index of refraction of the film", 1.0f, 3.0f},
    {"iridescence_thickness", "Thickness",
     "Thickness of the film in nanometres. Where there is a texture, its largest value.", 0.0f,
     2000.0f, "%.0f nm"},
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
     [](const Material& own) { return own.clearcoat > 0.0f; }},
    {"Sheen", "Fine fibres, as of velvet", kSheen,
     [](const Material& own) { return !is_black(own.sheen_color); }},
    {"Anisotropy", "Stretched highlights, as of brushed metal", kAnisotropy,
     [](const Material& own) { return own.anisotropy > 0.0f; }},
    {"Iridescence", "A thin film, as of soap bubbles", kIridescence,
     [](const Material& own) { return own.iridescence > 0.0f; }},
    {"Diffuse Transmission", "Light that shines through, as through leaves or paper",
     kDiffuseTransmission, [](const Material& own) { return own.diffuse_transmission > 0.0f; }},
    {"Interior", "How the volume inside changes light", kInterior,
     [](const Material& own) { return !own.thin_walled; }},
    {"Reflection", "Reflection of materials that are not metals", kReflection,
     [](const Material& own) {
       return own.ior != 1.5f || own.specular != 1.0f || own.specular_color != Rgb(1.0f);
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

bool is_offered(const MaterialRow& row, const MaterialDescription& own, const MaterialEdit& edit) {
  return !row.offered || row.offered(own, edit);
}

std::vector<const MaterialGroup*> offered_groups(const MaterialDescription& own,
                                                 const MaterialEdit& edit) {
  std::vector<const MaterialGroup*> groups;
  for (const bool present : {true, false}) {
    for (const MaterialGroup& group : kGroups) {
      const bool offered = std::ranges::any_of(
          group.rows, [&](const MaterialRow& row) { return is_offered(row, own, edit); });
      if (offered && group.present(own) == present) groups.push_back(&group);
    }
  }
  return groups;
}

}  // namespace emberline
