// The lights of a frame in groups: which of them can be edited separately, how much each
// contributes to the image (renderer/film/light_group_sums.h), and whether other settings can be
// shown from these sums alone.
//
// A group is the target of one LightEdit: a punctual light, everything that one material emits, or
// the environment. Black lights have no group. Beyond kMaxLightGroups, the last group is "all
// others" and cannot be edited separately. It also contains unlit materials, which show their base
// colour and which no LightEdit affects.
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
  std::string name;  // of the light or material; "environment"; "others". May repeat
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;     // the target of its LightEdit; empty for the environment
  bool editable = true;  // false for "all others"
};

// Immutable, thread-safe.
class LightGroups {
 public:
  // For the scene built from `original` with `baseline`; make a new one after every edit of the
  // scene. `original` is a description after apply(), complete or an outline:
  // EditableScene::original(). Throws like apply().
  explicit LightGroups(const SceneDescription& original, const SceneEdits& baseline = {});

  std::span<const LightGroup> list() const { return list_; }
  int size() const { return int(list_.size()); }

  // The group of a point light (LightSample::index), a material
  // (SurfaceInteraction::material_index) or the environment. Valid only for those that emit light.
  uint32_t of_point(uint32_t index) const { return of_point_[index]; }
  uint32_t of_material(uint32_t material_index) const { return of_material_[material_index]; }
  uint32_t of_environment() const { return of_environment_; }

  // The weights that mix a frame rendered with the baseline into one with `edits` (with different
  // noise), or nullopt if new rays are needed. They are needed if anything but the intensity,
  // colour or switch of lights or the environment's strength has changed, and if a channel that is
  // black in the baseline must shine: see neutral_baseline(). A light raised far above its baseline
  // shows the noise of the few samples that it got there; a light that is flush with another
  // surface still hides that surface when it is off. Throws like apply().
  std::optional<LightMix> mix(const SceneEdits& edits) const;

 private:
  static constexpr uint8_t kNone = 0xff, kOthers = 0xfe;

  uint8_t add(EditedLight kind, EditTarget target, const Rgb& radiance);
  void assign_others();

  SceneDescription original_;  // only its lists
  SceneEdits baseline_;
  SceneDescription built_;  // `original_` with the baseline's edits
  std::vector<LightGroup> list_;
  // By the description's index; of_point_ by the index among the lights that shine.
  std::vector<uint8_t> of_light_, of_point_, of_material_;
  uint8_t of_environment_ = kNone;
};

// Edits to render with, so that every light that `edits` switch off, or set to 0 in a channel, can
// come back without new rays: it is on, with the intensity and colour of `edits` where they are not
// 0. mix(edits) then shows `edits`. Some rays go to lights that are not visible.
SceneEdits neutral_baseline(const SceneEdits& edits);

}  // namespace emberline
