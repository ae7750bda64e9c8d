#include "renderer/output/scene_layers.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/output/light_layers.h"
#include "renderer/scene/light_groups.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

constexpr const char* kLights = "light layers";
constexpr const char* kCamera = "camera";
constexpr const char* kCryptomattes = "cryptomattes";

std::array<float, 16> floats_of(const Mat44d& matrix) {
  std::array<float, 16> values;
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = float(matrix[int(i / 4)][i % 4]);
  }
  return values;
}

std::array<float, 16> floats_of(const Json& list, const std::string& place) {
  std::array<float, 16> values;
  bool valid = list.is_array() && list.size() == values.size();
  for (size_t i = 0; valid && i < values.size(); ++i) {
    valid = list[i].is_number();
    if (valid) values[i] = list[i].get<float>();
    valid = valid && std::isfinite(values[i]);
  }
  if (!valid) throw InputError(place, "the checkpoint's camera is not a matrix");
  return values;
}

Json member(const Json& head, const char* name) {
  return head.is_object() ? head.value(name, Json()) : Json();
}

// Only names are stored, because the ids are computed from them.
std::vector<CryptomatteNames> cryptomattes_of(const Json& lists, const std::string& place) {
  std::vector<CryptomatteNames> all;
  for (const NamedValue<CryptomatteKind>& kind : cryptomatte_table()) {
    const auto list = lists.is_object() ? lists.find(kind.name) : lists.end();
    if (list == lists.end()) continue;
    CryptomatteNames& names = all.emplace_back();
    names.kind = kind.value;
    for (const Json& name : *list) {
      if (!name.is_string()) throw InputError(place, "the checkpoint's mattes are not names");
      const std::string& text = name.get_ref<const std::string&>();
      names.ids.emplace_back(text, cryptomatte_id(text));
    }
  }
  return all;
}

}  // namespace

SceneLayers scene_layers(const SceneParts& parts, const Camera& camera, const Vec3d& origin) {
  SceneLayers layers;
  if (parts.light_groups) layers.lights = light_layer_names(parts.light_groups->list());
  if (parts.cryptomattes) layers.cryptomattes = parts.cryptomattes->names();
  if (!camera.is_panorama()) {
    const Camera::WorldMatrices matrices = camera.world_matrices(origin);
    layers.camera = {floats_of(matrices.to_camera), floats_of(matrices.to_ndc)};
  }
  return layers;
}

void put_scene_layers(const SceneLayers& layers, Json& head) {
  if (!layers.lights.empty()) head[kLights] = layers.lights;
  if (layers.camera) {
    head[kCamera] = {layers.camera->world_to_camera, layers.camera->world_to_ndc};
  }
  for (const CryptomatteNames& names : layers.cryptomattes) {
    Json& list = head[kCryptomattes][std::string(name_of(cryptomatte_table(), names.kind))];
    list = Json::array();
    for (const auto& [name, id] : names.ids) list.push_back(name);
  }
}

SceneLayers scene_layers_of(const Json& head, const std::string& place) {
  constexpr size_t kMaxNameLength = 255, kMaxLayers = 65535;
  SceneLayers layers;
  for (const Json& name : member(head, kLights)) {
    if (!name.is_string() || name.get_ref<const std::string&>().size() > kMaxNameLength ||
        layers.lights.size() > kMaxLayers) {
      throw InputError(place, "the checkpoint's light layers are not names");
    }
    layers.lights.push_back(name.get<std::string>());
  }
  layers.cryptomattes = cryptomattes_of(member(head, kCryptomattes), place);
  const Json camera = member(head, kCamera);
  if (camera.is_null()) return layers;
  if (!camera.is_array() || camera.size() != 2) {
    throw InputError(place, "the checkpoint's camera is not a matrix");
  }
  layers.camera = {floats_of(camera[0], place), floats_of(camera[1], place)};
  return layers;
}

}  // namespace emberline
