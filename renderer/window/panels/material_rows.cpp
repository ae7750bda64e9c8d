#include "renderer/window/panels/material_rows.h"

#include <algorithm>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

using Material = MaterialDescription;
using Edit = MaterialEdit;

constexpr const char* kTimesTexture = "multiplies the texture";
constexpr float kMostEmission = 1000.0f;

bool has_interior(const Material& own, const Edit&) { return !own.thin_walled; }

constexpr MaterialRow kBase[] = {
    {"base_color", "Base colour"},
    {"roughness", "Roughness", 0.0f, 1.0f, kTimesTexture},
    {"metallic", "Metalness", 0.0f, 1.0f, kTimesTexture},
    {"transmission", "Transmission", 0.0f, 1.0f, kTimesTexture},
    {.parameter = "normal_scale",
     .label = "Normal strength",
     .most = 4.0f,
     .offered = [](const Material& own, const Edit&) { return own.normal_texture.image >= 0; }},
    {"emission", "Emission", 0.0f, kMostEmission},
};
constexpr MaterialRow kReflection[] = {
    {.parameter = "ior",
     .label = "Index",
     .least = 1.0f,
     .most = 3.0f,
     .help = "of refraction: 1.33 water, 1.5 glass, 2.42 diamond",
     .offered = [](const Material& own, const Edit&) { return own.ior != 0.0f; }},
    {"specular", "Strength", 0.0f, 1.0f, "of the dielectric's reflection; 0 leaves a matt base"},
    {"specular_color", "Colour", 0.0f, 25.0f,
     "of the dielectric's reflection, seen at a right angle; may be more than 1"},
};
constexpr MaterialRow kInterior[] = {
    {.parameter = "attenuation_color",
     .label = "Colour",
     .help = "what white light becomes on the way of the distance",
     .offered = has_interior},
    {.parameter = "attenuation_distance",
     .label = "Distance",
     .least = 1e-4f,
     .most = 100.0f,
     .help = "metres after which light has the colour",
     .format = "%.4g m",
     .logarithmic = true,
     .offered = has_interior},
    {.parameter = "dispersion",
     .label = "Dispersion",
     .most = 2.0f,
     .help = "20 / Abbe number: 0.33 crown glass, 0.36 diamond, 2 rutile",
     .offered = [](const Material& own,
                   const Edit&) { return !own.thin_walled && own.ior > 0.0f; }},
};
constexpr MaterialRow kDiffuseTransmission[] = {
    {"diffuse_transmission", "Amount", 0.0f, 1.0f, kTimesTexture},
    {"diffuse_transmission_color", "Colour"},
};
bool has_direction(const Material& own, const Edit& edit) {
  return has_tangent_space(own) || edit.anisotropy.has_value();
}
constexpr MaterialRow kAnisotropy[] = {
    {.parameter = "anisotropy",
     .label = "Strength",
     .help = kTimesTexture,
     .offered = has_direction},
    {.parameter = "anisotropy_rotation",
     .label = "Rotation",
     .least = -180.0f,
     .most = 180.0f,
     .help = "counter-clockwise from the mesh's tangent",
     .format = "%.1f°",
     .offered = has_direction},
};
constexpr MaterialRow kIridescence[] = {
    {"iridescence", "Amount", 0.0f, 1.0f, kTimesTexture},
    {"iridescence_ior", "Index", 1.0f, 3.0f, "of refraction, of the film"},
    {"iridescence_thickness", "Thickness", 0.0f, 2000.0f,
     "nanometres; the most, where a texture says how much", "%.0f nm"},
};
constexpr MaterialRow kSheen[] = {
    {"sheen_color", "Colour", 0.0f, 1.0f, "of the fibres; black: none"},
    {"sheen_roughness", "Roughness", 0.0f, 1.0f, kTimesTexture},
};
constexpr MaterialRow kClearcoat[] = {
    {"clearcoat", "Amount", 0.0f, 1.0f, kTimesTexture},
    {"clearcoat_roughness", "Roughness", 0.0f, 1.0f, kTimesTexture},
};

constexpr MaterialGroup kGroups[] = {
    {"", kBase, [](const Material&) { return true; }},
    {"Clear coat", kClearcoat, [](const Material& own) { return own.clearcoat > 0.0f; }},
    {"Sheen", kSheen, [](const Material& own) { return !is_black(own.sheen_color); }},
    {"Anisotropy", kAnisotropy, [](const Material& own) { return own.anisotropy > 0.0f; }},
    {"Iridescence", kIridescence, [](const Material& own) { return own.iridescence > 0.0f; }},
    {"Diffuse transmission", kDiffuseTransmission,
     [](const Material& own) { return own.diffuse_transmission > 0.0f; }},
    {"Interior", kInterior, [](const Material& own) { return !own.thin_walled; }},
    {"Reflection", kReflection,
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
