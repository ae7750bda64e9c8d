// The lights of a frame, told apart: which of them an artist can edit alone, what of a picture
// each gave (renderer/film/light_group_sums.h), and whether another setting of them can be shown
// from that alone.
//
// A group is what one LightEdit reaches: a punctual light, all that shines by one material, or the
// environment. Lights that give nothing have none. Of more than kMostLightGroups the last holds
// "all others" and can't be edited alone; it also holds unlit materials, which show their base
// colour and which no LightEdit reaches.
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
  std::string name;  // the light's or material's; "environment"; "others". Not always unique
  EditedLight kind = EditedLight::kPunctual;
  EditTarget target;     // what a LightEdit of it names; of the environment empty
  bool editable = true;  // false: all others
};

// Immutable, thread-safe.
class LightGroups {
 public:
  // Of the scene that is built from `original` with `baseline`: to be made anew with every edit
  // that the scene is given. `original` is a description that has been through apply(), whole or
  // an outline: EditableScene::original(). Throws as apply() does.
  explicit LightGroups(const SceneDescription& original, const SceneEdits& baseline = {});

  std::span<const LightGroup> list() const { return list_; }
  int size() const { return int(list_.size()); }

  // The group that a point light (LightSample::index), a material
  // (SurfaceInteraction::material_index) or the environment belongs to. To be asked of what gives
  // light.
  uint32_t of_point(uint32_t index) const { return of_point_[index]; }
  uint32_t of_material(uint32_t material_index) const { return of_material_[material_index]; }
  uint32_t of_environment() const { return of_environment_; }

  // How a frame rendered with the baseline is to be mixed to be one rendered with `edits` (with
  // other noise): nullopt if new rays are needed. That is so unless nothing has changed but the
  // intensity, colour or switch of lights and the strength of the environment, and wherever the
  // baseline is dark in a channel that is to shine: see neutral_baseline(). A light raised far
  // above its baseline shows the noise of the few samples that it was worth there; one that lies
  // flush in another surface still hides that surface when it is off. Throws as apply() does.
  std::optional<LightMix> mix(const SceneEdits& edits) const;

 private:
  static constexpr uint8_t kNone = 0xff, kOthers = 0xfe;

  uint8_t add(EditedLight kind, EditTarget target, const Rgb& radiance);
  void number_others();

  SceneDescription original_;  // its lists alone
  SceneEdits baseline_;
  SceneDescription built_;  // the same with the baseline's edits
  std::vector<LightGroup> list_;
  // By the description's index; of_point_ by that among the lights that shine.
  std::vector<uint8_t> of_light_, of_point_, of_material_;
  uint8_t of_environment_ = kNone;
};

// Edits to render with instead, so that every light that `edits` turn off, or down to 0 in some
// channel, can come back without new rays: it is on, with its own intensity and colour where they
// are not 0; mix(edits) shows what was asked for. Rays then go to lights that are not seen.
SceneEdits neutral_baseline(const SceneEdits& edits);

}  // namespace emberline
