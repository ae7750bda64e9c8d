#include "renderer/window/panels/edit_entries.h"

#include <algorithm>

namespace emberline {
namespace {

template <class Named>
bool refers_to(const EditTarget& target, const std::vector<Named>& list, int index) {
  return find_entry(target, list) == size_t(index);
}

bool refers_to(const LightEdit& edit, const SceneDescription& outline, EditedLight kind,
               int index) {
  if (edit.kind != kind || kind == EditedLight::kEnvironment) return edit.kind == kind;
  return kind == EditedLight::kPunctual ? refers_to(edit.target, outline.lights, index)
                                        : refers_to(edit.target, outline.materials, index);
}

template <class Named>
EditTarget target_of(const std::vector<Named>& list, int index) {
  EditTarget target;
  target.index = index;
  if (index >= 0 && size_t(index) < list.size()) target.name = list[size_t(index)].name;
  return target;
}

template <class Edit, class Same>
void replace(std::vector<Edit>& list, const Edit& edit, bool changes, const Same& same) {
  const auto found = std::ranges::find_if(list, same);
  if (found == list.end()) {
    if (changes) list.push_back(edit);
  } else if (changes) {
    *found = edit;
  } else {
    list.erase(found);
  }
}

constexpr const char* kTypeNames[] = {"Point", "Spot", "Sun"};  // indexed by PunctualType

}  // namespace

std::string display_name(const std::string& name, const char* what, int index) {
  return name.empty() ? std::string(what) + " " + std::to_string(index) : name;
}

std::vector<ListedLight> list_lights(const SceneDescription& outline, const SceneEdits& edits) {
  std::vector<ListedLight> lights;
  for (int i = 0; i < int(outline.lights.size()); ++i) {
    const PunctualLightDescription& light = outline.lights[size_t(i)];
    lights.push_back({EditedLight::kPunctual, i, display_name(light.name, "Light", i),
                      kTypeNames[size_t(light.type)]});
  }
  for (int i = 0; i < int(outline.materials.size()); ++i) {
    const MaterialDescription& material = outline.materials[size_t(i)];
    const MaterialEdit edit = material_edit(edits, outline, i);
    if (is_black(edit.emission.value_or(material.emission))) continue;
    lights.push_back(
        {EditedLight::kMaterial, i, display_name(material.name, "Material", i), "Surface"});
  }
  if (outline.environment || edits.environment.image) {
    lights.push_back({EditedLight::kEnvironment, 0, "Environment", ""});
  }
  return lights;
}

LightEdit light_edit(const SceneEdits& edits, const SceneDescription& outline, EditedLight kind,
                     int index) {
  LightEdit edit;
  for (const LightEdit& entry : edits.lights) {
    if (refers_to(entry, outline, kind, index)) edit = entry;
  }
  edit.kind = kind;
  if (kind == EditedLight::kPunctual) edit.target = target_of(outline.lights, index);
  if (kind == EditedLight::kMaterial) edit.target = target_of(outline.materials, index);
  return edit;
}

MaterialEdit material_edit(const SceneEdits& edits, const SceneDescription& outline, int material) {
  MaterialEdit edit;
  for (const MaterialEdit& entry : edits.materials) {
    if (refers_to(entry.target, outline.materials, material)) edit = entry;
  }
  edit.target = target_of(outline.materials, material);
  return edit;
}

MaterialEdit unedited(const EditTarget& material) {
  MaterialEdit edit;
  edit.target = material;
  return edit;
}

bool has_changes(const MaterialEdit& edit) { return edit != unedited(edit.target); }

void store_entry(SceneEdits& edits, const SceneDescription& outline, const LightEdit& edit) {
  const bool changes = edit.intensity != 1.0f || edit.color != Rgb(1.0f) || !edit.on;
  replace(edits.lights, edit, changes, [&](const LightEdit& entry) {
    return refers_to(entry, outline, edit.kind, edit.target.index);
  });
}

void store_entry(SceneEdits& edits, const SceneDescription& outline, const MaterialEdit& edit) {
  replace(edits.materials, edit, has_changes(edit), [&](const MaterialEdit& entry) {
    return refers_to(entry.target, outline.materials, edit.target.index);
  });
}

}  // namespace emberline
