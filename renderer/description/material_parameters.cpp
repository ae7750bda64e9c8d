#include "renderer/description/material_parameters.h"

#include <algorithm>
#include <cassert>

#include "renderer/core/constants.h"

namespace emberline {
namespace {

using Edit = MaterialEdit;
using Material = MaterialDescription;

struct Range {
  double least, most;
};
constexpr Range kShare = {0.0, 1.0}, kLight = {0.0, edit_limits::kBrightest},
                kLength = {1.0 / edit_limits::kFarthest, edit_limits::kFarthest},
                kDegrees = {-edit_limits::kMostTurns, edit_limits::kMostTurns};
// Far beyond real materials.
constexpr Range kIndex = {1.0, 1e4}, kSpecular = {0.0, 1e4}, kNanometres = {0.0, 1e6},
                kDispersion = {0.0, 1e3}, kNormalScale = {-1e3, 1e3};

constexpr MaterialParameter row(std::string_view name, std::optional<float> Edit::*edited,
                                float Material::*value, Range range, float unit = 1.0f) {
  return {name, range.least, range.most, edited, value, nullptr, nullptr, unit};
}
constexpr MaterialParameter row(std::string_view name, std::optional<Rgb> Edit::*edited,
                                Rgb Material::*value, Range range) {
  return {name, range.least, range.most, nullptr, nullptr, edited, value};
}

constexpr MaterialParameter kParameters[] = {
    row("base_color", &Edit::base_color, &Material::base_color, kShare),
    row("roughness", &Edit::roughness, &Material::roughness, kShare),
    row("metallic", &Edit::metallic, &Material::metallic, kShare),
    row("emission", &Edit::emission, &Material::emission, kLight),
    row("transmission", &Edit::transmission, &Material::transmission, kShare),
    row("normal_scale", &Edit::normal_scale, &Material::normal_scale, kNormalScale),
    row("ior", &Edit::ior, &Material::ior, kIndex),
    row("specular", &Edit::specular, &Material::specular, kShare),
    row("specular_color", &Edit::specular_color, &Material::specular_color, kSpecular),
    row("attenuation_color", &Edit::attenuation_color, &Material::attenuation_color, kShare),
    row("attenuation_distance", &Edit::attenuation_distance, &Material::attenuation_distance,
        kLength),
    row("dispersion", &Edit::dispersion, &Material::dispersion, kDispersion),
    row("diffuse_transmission", &Edit::diffuse_transmission, &Material::diffuse_transmission,
        kShare),
    row("diffuse_transmission_color", &Edit::diffuse_transmission_color,
        &Material::diffuse_transmission_color, kShare),
    row("anisotropy", &Edit::anisotropy, &Material::anisotropy, kShare),
    row("anisotropy_rotation", &Edit::anisotropy_rotation_degrees, &Material::anisotropy_rotation,
        kDegrees, kPi / 180.0f),
    row("iridescence", &Edit::iridescence, &Material::iridescence, kShare),
    row("iridescence_ior", &Edit::iridescence_ior, &Material::iridescence_ior, kIndex),
    row("iridescence_thickness", &Edit::iridescence_thickness,
        &Material::iridescence_thickness_maximum, kNanometres),
    row("sheen_color", &Edit::sheen_color, &Material::sheen_color, kShare),
    row("sheen_roughness", &Edit::sheen_roughness, &Material::sheen_roughness, kShare),
    row("clearcoat", &Edit::clearcoat, &Material::clearcoat, kShare),
    row("clearcoat_roughness", &Edit::clearcoat_roughness, &Material::clearcoat_roughness, kShare),
};

}  // namespace

std::span<const MaterialParameter> material_parameters() { return kParameters; }

const MaterialParameter& material_parameter(std::string_view name) {
  const auto* found = std::ranges::find(kParameters, name, &MaterialParameter::name);
  assert(found != std::end(kParameters));
  return *found;
}

}  // namespace emberline
