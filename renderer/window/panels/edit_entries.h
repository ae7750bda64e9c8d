// One light's or material's entry in the edits of a scene: what a list of lights and a material
// editor read and change. Plain functions on plain data.
#pragma once

#include <string>
#include <vector>

#include "renderer/description/scene_edits.h"

namespace emberline {

// Something that shines, as a list of lights names it.
struct ListedLight {
  EditedLight kind = EditedLight::kPunctual;
  int index = -1;    // of the light or the material
  std::string name;  // for people; never empty
  std::string type;  // "point", "spot", "sun", "surface", "environment"
};

// All lights that the file has, and materials that shine by the edits alone.
std::vector<ListedLight> list_lights(const SceneDescription& outline, const SceneEdits& edits);

// The name that people see: the file's own, or "material 3".
std::string shown_name(const std::string& name, const char* what, int index);

// The entry that means this light or material; one that changes nothing where there is none. Its
// target is then complete: name and index.
LightEdit light_edit(const SceneEdits& edits, const SceneDescription& outline, EditedLight kind,
                     int index);
MaterialEdit material_edit(const SceneEdits& edits, const SceneDescription& outline, int material);

// The entry that changes nothing of its material.
MaterialEdit untouched(const EditTarget& material);
// Whether the entry replaces any factor of its material.
bool changes_something(const MaterialEdit& edit);

// Replaces the entry of the same light or material. An entry that changes nothing is left out, so
// that reset edits equal no edits.
void put(SceneEdits& edits, const SceneDescription& outline, const LightEdit& edit);
void put(SceneEdits& edits, const SceneDescription& outline, const MaterialEdit& edit);

}  // namespace emberline
