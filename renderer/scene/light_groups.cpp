#include "renderer/scene/light_groups.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace emberline {
namespace {

constexpr float kMaxFloat = std::numeric_limits<float>::max();
constexpr float kMinFloat = std::numeric_limits<float>::min();

// Returns for each material whether a placed mesh uses it.
std::vector<bool> used_materials(const SceneDescription& description) {
  std::vector<bool> used(description.materials.size(), false);
  for (const InstanceDescription& instance : description.instances) {
    const int material = description.meshes[size_t(instance.mesh)].material;
    if (material >= 0) used[size_t(material)] = true;
  }
  return used;
}

// Returns the parts of the description that a LightEdit may change and that apply() needs.
// Materials without a placed mesh become black.
SceneDescription light_parameters_of(const SceneDescription& description,
                                     const std::vector<bool>& used) {
  SceneDescription lights;
  static_cast<SceneLists&>(lights) = description;
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) lights.materials[i].emission = Rgb(0.0f);
  }
  lights.may_be_dark = true;
  return lights;
}

Rgb radiance_of(const EnvironmentDescription& e) { return e.tint * e.strength; }

// Returns whether the two environments have the same light apart from strength and tint.
bool have_same_environment(const std::optional<EnvironmentDescription>& a,
                           const std::optional<EnvironmentDescription>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->image == b->image && a->constant == b->constant &&
         a->rotation_degrees == b->rotation_degrees;
}

// Returns the factor from `before` to `after`, or nullopt if `before` is black or if either value
// is at the limit of float's range, where products are clipped.
std::optional<float> ratio(float before, float after) {
  if (before == after) return 1.0f;
  if (!(before >= kMinFloat && before < kMaxFloat && after < kMaxFloat)) return std::nullopt;
  const double quotient = double(after) / double(before);
  return quotient < double(kMaxFloat) ? std::optional(float(quotient)) : std::nullopt;
}

std::optional<Rgb> ratio(const Rgb& before, const Rgb& after) {
  Rgb result;
  for (int c = 0; c < 3; ++c) {
    const std::optional<float> channel = ratio(before[c], after[c]);
    if (!channel) return std::nullopt;
    result[c] = *channel;
  }
  return result;
}

// Returns the light that the material emits. An unlit material shows its base colour but emits no
// light.
Rgb emission_of(const MaterialDescription& material) {
  return material.unlit ? Rgb(0.0f) : material.emission;
}

}  // namespace

LightGroups::LightGroups(const SceneDescription& original, const SceneEdits& baseline)
    : baseline_(baseline) {
  assert(original.may_be_dark && "not through apply()");
  SceneDescription built = copy_without_geometry(original);
  apply(baseline_, built);
  const std::vector<bool> used = used_materials(built);
  original_ = light_parameters_of(original, used);
  built_ = light_parameters_of(built, used);
  for (size_t i = 0; i < built_.lights.size(); ++i) {
    const PunctualLightDescription& light = built_.lights[i];
    of_light_.push_back(add(EditedLight::kPunctual, {light.name, int(i), {}}, light.intensity));
    if (shines(light)) of_point_.push_back(of_light_.back());
  }
  for (size_t i = 0; i < used.size(); ++i) {
    const MaterialDescription& material = built_.materials[i];
    of_material_.push_back(used[i] && material.unlit
                               ? kOthers
                               : add(EditedLight::kMaterial, {material.name, int(i), {}},
                                     used[i] ? material.emission : Rgb(0.0f)));
  }
  of_material_.push_back(kNone);  // the default material
  if (built_.environment) {
    of_environment_ = add(EditedLight::kEnvironment, {}, radiance_of(*built_.environment));
  }
  assign_others();
}

uint8_t LightGroups::add(EditedLight kind, EditTarget target, const Rgb& radiance) {
  if (is_black(radiance)) return kNone;
  if (list_.size() == kMaxLightGroups - 1) return kOthers;
  const bool is_environment = kind == EditedLight::kEnvironment;
  std::string name = is_environment ? "environment" : target.name;
  list_.push_back({std::move(name), kind, std::move(target), true});
  return uint8_t(list_.size() - 1);
}

// Assigns the last group to all lights marked kOthers.
void LightGroups::assign_others() {
  const auto number = uint8_t(list_.size());
  bool any = false;
  const auto replace = [&](uint8_t& group) {
    if (group != kOthers) return;
    group = number;
    any = true;
  };
  std::ranges::for_each(of_light_, replace);
  std::ranges::for_each(of_point_, replace);
  std::ranges::for_each(of_material_, replace);
  replace(of_environment_);
  if (any) list_.push_back({"others", EditedLight::kPunctual, {}, false});
}

std::optional<LightMix> LightGroups::mix(const SceneEdits& edits) const {
  if (edits.camera != baseline_.camera || edits.animation != baseline_.animation ||
      edits.variant != baseline_.variant || edits.materials != baseline_.materials) {
    return std::nullopt;
  }
  SceneDescription edited = original_;
  apply(edits, edited);
  if (!have_same_environment(built_.environment, edited.environment)) return std::nullopt;

  std::vector<Rgb> weights(list_.size(), Rgb(1.0f));
  const auto set_weight = [&](uint8_t group, const Rgb& before, const Rgb& after) {
    const std::optional<Rgb> weight = ratio(before, after);
    if (!weight) return false;
    if (group == kNone) return true;  // black before and after
    weights[group] = *weight;
    return list_[group].editable || *weight == Rgb(1.0f);
  };
  for (size_t i = 0; i < edited.lights.size(); ++i) {
    if (!set_weight(of_light_[i], built_.lights[i].intensity, edited.lights[i].intensity)) {
      return std::nullopt;
    }
  }
  for (size_t i = 0; i < edited.materials.size(); ++i) {
    const Rgb before = emission_of(built_.materials[i]), after = emission_of(edited.materials[i]);
    if (!set_weight(of_material_[i], before, after)) return std::nullopt;
  }
  if (edited.environment && !set_weight(of_environment_, radiance_of(*built_.environment),
                                        radiance_of(*edited.environment))) {
    return std::nullopt;
  }
  return LightMix(weights);
}

SceneEdits neutral_baseline(const SceneEdits& edits) {
  SceneEdits baseline = edits;
  for (LightEdit& light : baseline.lights) {
    light.on = true;
    if (!(light.intensity > 0.0f)) light.intensity = 1.0f;
    const float brightest = max_component(light.color);
    for (int c = 0; c < 3; ++c) {
      if (!(light.color[c] > 0.0f)) light.color[c] = brightest > 0.0f ? brightest : 1.0f;
    }
  }
  if (baseline.environment.strength == 0.0f) baseline.environment.strength = 1.0f;
  return baseline;
}

}  // namespace emberline
