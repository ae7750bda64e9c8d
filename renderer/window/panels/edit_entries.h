// Reads and changes the entries for single lights and materials in a scene's edits, for the light
// and material panels. Plain functions on plain data.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// A light source in the list of lights.
struct ListedLight {
  EditedLight kind = EditedLight::kPunctual;
  int index = -1;    // index in the scene's lights or materials
  std::string name;  // shown to the user; never empty
  std::string type;  // "Point", "Spot", "Sun" or "Surface"; empty for the environment
};

// Lists all light sources, including materials that emit only because of edits.
std::vector<ListedLight> list_lights(const SceneDescription& outline, const SceneEdits& edits);

// Returns the item's name or, if it has none, a name such as "Material 3".
std::string display_name(const std::string& name, const char* what, int index);

// Returns the edits' entry for this light or material, or an entry without changes if there is
// none. Its target has both name and index.
LightEdit light_edit(const SceneEdits& edits, const SceneDescription& outline, EditedLight kind,
                     int index);
MaterialEdit material_edit(const SceneEdits& edits, const SceneDescription& outline, int material);

// Returns an entry without changes.
MaterialEdit unedited(const EditTarget& material);
// Returns whether the entry changes any parameter of its material.
bool has_changes(const MaterialEdit& edit);

// Stores `edit` in place of the entry for the same light or material, if any. If `edit` has no
// changes, removes that entry instead, so that fully reset edits compare equal to SceneEdits().
void store_entry(SceneEdits& edits, const SceneDescription& outline, const LightEdit& edit);
void store_entry(SceneEdits& edits, const SceneDescription& outline, const MaterialEdit& edit);

}  // namespace emberline
