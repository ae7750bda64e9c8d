// The entries of single lights and materials in a scene's edits, which the light and material
// panels read and change. Plain functions on plain data.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// A light source in the list of lights.
struct ListedLight {
  EditedLight kind = EditedLight::kPunctual;
  int index = -1;    // of the light or material
  std::string name;  // readable; never empty
  std::string type;  // "Point", "Spot", "Sun" or "Surface"; empty for the environment
};

// Lists all light sources, including materials that emit only because of edits.
std::vector<ListedLight> list_lights(const SceneDescription& outline, const SceneEdits& edits);

// Returns the item's own name or, for example, "Material 3".
std::string display_name(const std::string& name, const char* what, int index);

// Returns the entry for this light or material, or an empty one. Its target is complete: name and
// index.
LightEdit light_edit(const SceneEdits& edits, const SceneDescription& outline, EditedLight kind,
                     int index);
MaterialEdit material_edit(const SceneEdits& edits, const SceneDescription& outline, int material);

// Returns an entry without changes.
MaterialEdit unedited(const EditTarget& material);
// Whether the entry replaces any factor of its material.
bool has_changes(const MaterialEdit& edit);

// Replaces the entry for the same light or material. An entry without changes is removed, so that
// reset edits equal no edits.
void store_entry(SceneEdits& edits, const SceneDescription& outline, const LightEdit& edit);
void store_entry(SceneEdits& edits, const SceneDescription& outline, const MaterialEdit& edit);

}  // namespace emberline
