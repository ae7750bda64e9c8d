// Groups the lights of a frame. The film sums each group's part of the image separately
// (renderer/film/light_group_sums.h). This class says which groups can be edited separately, and
// whether other light settings can be shown from these sums alone.
//
// A group is the target of one LightEdit: a punctual light, everything that one material emits, or
// the environment. Black lights have no group. The last group may be "all others", which cannot be
// edited separately. It contains the lights that would exceed kMaxLightGroups groups. It also
// contains unlit materials, which show their base colour and which no LightEdit affects.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"
#include "renderer/film/light_group_values.h"
#include "renderer/film/light_mix.h"

namespace emberline {

struct LightGroup {
  std::string name;  // name of the light or material, "environment" or "others"; may repeat
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;     // the target of its LightEdit; empty for the environment
  bool editable = true;  // false for "all others"
};

// Immutable, thread-safe.
class LightGroups {
 public:
  // Groups the lights of a scene that was built from `original` with the edits `baseline`. If the
  // scene itself is edited again, create a new object. `original` must be a description after
  // apply(), complete or without geometry, such as EditableScene::original(). Throws like apply().
  explicit LightGroups(const SceneDescription& original, const SceneEdits& baseline = {});

  std::span<const LightGroup> list() const { return list_; }
  int size() const { return int(list_.size()); }

  // Return the group of a point light (LightSample::index), a material
  // (SurfaceInteraction::material_index) or the environment. Call these only for lights that emit.
  uint32_t of_point(uint32_t index) const { return of_point_[index]; }
  uint32_t of_material(uint32_t material_index) const { return of_material_[material_index]; }
  uint32_t of_environment() const { return of_environment_; }

  // Returns the weights that turn a frame rendered with the baseline into a frame with `edits`
  // (with different noise), or nullopt if new rays are needed. New rays are needed if anything has
  // changed other than the intensity, colour or on/off state of lights and the environment's
  // strength. New rays are also needed if a light must emit in a channel that is black in the
  // baseline (see neutral_baseline()). A light raised far above its baseline is noisy, because it
  // got few samples. A light that is flush with another surface still hides that surface when it is
  // off. Throws like apply().
  std::optional<LightMix> mix(const SceneEdits& edits) const;

 private:
  static constexpr uint8_t kNone = 0xff, kOthers = 0xfe;

  uint8_t add(EditedLight kind, EditTarget target, const Rgb& radiance);
  void assign_others();

  SceneDescription original_;  // only its SceneLists
  SceneEdits baseline_;
  SceneDescription built_;  // `original_` with the baseline's edits
  std::vector<LightGroup> list_;
  // The group of each light and material, by index in the description. of_point_ has entries only
  // for lights that shine.
  std::vector<uint8_t> of_light_, of_point_, of_material_;
  uint8_t of_environment_ = kNone;
};

// Returns edits to render with, so that lights that `edits` turn off can be turned on later without
// new rays. They are `edits` with these lights switched on, and with zeros in intensities and
// colours replaced; mix(edits) then shows `edits`. The price is that some rays are spent on lights
// that are off.
SceneEdits neutral_baseline(const SceneEdits& edits);

}  // namespace emberline
