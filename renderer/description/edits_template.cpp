#include "renderer/description/edits_template.h"

#include <cmath>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

bool is_valid(float value, const MaterialParameter& p) {
  return double(value) >= p.minimum && double(value) <= p.maximum;
}

// Returns the number that, written in an edit, gives exactly this value. Tries `value` divided by
// the unit and, because the quotient is rounded, its two neighbouring floats.
std::optional<float> edited_number(float value, const MaterialParameter& p) {
  const float quotient = value / p.unit;
  for (const float to : {0.0f, -INFINITY, INFINITY}) {
    const float number = to == 0.0f ? quotient : std::nextafter(quotient, to);
    if (p.unit * number == value && is_valid(number, p)) return number;
  }
  return std::nullopt;
}

bool has_effect(const MaterialParameter& p, const MaterialDescription& material) {
  const bool is_of_interior = p.number == &MaterialDescription::attenuation_distance ||
                              p.number == &MaterialDescription::dispersion ||
                              p.color == &MaterialDescription::attenuation_color;
  return !is_of_interior || !material.thin_walled;
}

MaterialEdit material_edit(const MaterialDescription& material, size_t index) {
  MaterialEdit edit;
  edit.target = {material.name, int(index), {}};
  for (const MaterialParameter& p : material_parameters()) {
    if (!has_effect(p, material)) continue;
    if (!p.color) {
      edit.*p.edited_number = edited_number(material.*p.number, p);
      continue;
    }
    const Rgb& c = material.*p.color;
    if (is_valid(c.x, p) && is_valid(c.y, p) && is_valid(c.z, p)) edit.*p.edited_color = c;
  }
  return edit;
}

}  // namespace

SceneEdits edits_template(const SceneDescription& scene) {
  SceneEdits edits;
  const auto add_light = [&](EditedLight kind, const std::string& name, int index) {
    LightEdit& edit = edits.lights.emplace_back();
    edit.kind = kind;
    edit.target = {name, index, {}};
  };
  for (size_t i = 0; i < scene.lights.size(); ++i) {
    add_light(EditedLight::kPunctual, scene.lights[i].name, int(i));
  }
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const MaterialDescription& material = scene.materials[i];
    if (emits(material)) add_light(EditedLight::kMaterial, material.name, int(i));
    edits.materials.push_back(material_edit(material, i));
  }
  if (scene.environment) {
    edits.environment.strength = scene.environment->strength;
    edits.environment.rotation_degrees = scene.environment->rotation_degrees;
    add_light(EditedLight::kEnvironment, {}, -1);
  }
  return edits;
}

}  // namespace emberline
