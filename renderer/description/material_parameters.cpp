#include "renderer/description/material_parameters.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/constants.h"

namespace emberline {
namespace {

using Edit = MaterialEdit;
using Material = MaterialDescription;

struct Range {
  double minimum, maximum;
};
constexpr Range kUnitRange = {0.0, 1.0}, kLight = {0.0, edit_limits::kMaxRadiance},
                kLength = {1.0 / edit_limits::kMaxDistance, edit_limits::kMaxDistance},
                kDegrees = {-edit_limits::kMaxDegrees, edit_limits::kMaxDegrees};
// These ranges extend far beyond the values of real materials.
constexpr Range kIndex = {1.0, 1e4}, kSpecular = {0.0, 1e4}, kNanometres = {0.0, 1e6},
                kDispersion = {0.0, 1e3}, kNormalScale = {-1e3, 1e3};

constexpr MaterialParameter row(std::string_view name, std::optional<float> Edit::*edited,
                                float Material::*value, Range range, float unit = 1.0f) {
  return {name, range.minimum, range.maximum, edited, value, nullptr, nullptr, unit};
}
constexpr MaterialParameter row(std::string_view name, std::optional<Rgb> Edit::*edited,
                                Rgb Material::*value, Range range) {
  return {name, range.minimum, range.maximum, nullptr, nullptr, edited, value};
}

constexpr MaterialParameter kParameters[] = {
    row("base_color", &Edit::base_color, &Material::base_color, kUnitRange),
    row("roughness", &Edit::roughness, &Material::roughness, kUnitRange),
    row("metallic", &Edit::metallic, &Material::metallic, kUnitRange),
    row("emission", &Edit::emission, &Material::emission, kLight),
    row("transmission", &Edit::transmission, &Material::transmission, kUnitRange),
    row("normal_scale", &Edit::normal_scale, &Material::normal_scale, kNormalScale),
    row("ior", &Edit::ior, &Material::ior, kIndex),
    row("specular", &Edit::specular, &Material::specular, kUnitRange),
    row("specular_color", &Edit::specular_color, &Material::specular_color, kSpecular),
    row("attenuation_color", &Edit::attenuation_color, &Material::attenuation_color, kUnitRange),
    row("attenuation_distance", &Edit::attenuation_distance, &Material::attenuation_distance,
        kLength),
    row("dispersion", &Edit::dispersion, &Material::dispersion, kDispersion),
    row("diffuse_transmission", &Edit::diffuse_transmission, &Material::diffuse_transmission,
        kUnitRange),
    row("diffuse_transmission_color", &Edit::diffuse_transmission_color,
        &Material::diffuse_transmission_color, kUnitRange),
    row("anisotropy", &Edit::anisotropy, &Material::anisotropy, kUnitRange),
    row("anisotropy_rotation", &Edit::anisotropy_rotation_degrees, &Material::anisotropy_rotation,
        kDegrees, kPi / 180.0f),
    row("iridescence", &Edit::iridescence, &Material::iridescence, kUnitRange),
    row("iridescence_ior", &Edit::iridescence_ior, &Material::iridescence_ior, kIndex),
    row("iridescence_thickness", &Edit::iridescence_thickness,
        &Material::iridescence_thickness_maximum, kNanometres),
    row("sheen_color", &Edit::sheen_color, &Material::sheen_color, kUnitRange),
    row("sheen_roughness", &Edit::sheen_roughness, &Material::sheen_roughness, kUnitRange),
    row("clearcoat", &Edit::clearcoat, &Material::clearcoat, kUnitRange),
    row("clearcoat_roughness", &Edit::clearcoat_roughness, &Material::clearcoat_roughness,
        kUnitRange),
};

}  // namespace

std::span<const MaterialParameter> material_parameters() { return kParameters; }

const MaterialParameter& material_parameter(std::string_view name) {
  const auto* found = std::ranges::find(kParameters, name, &MaterialParameter::name);
  assert(found != std::end(kParameters));
  return *found;
}

}  // namespace emberline
