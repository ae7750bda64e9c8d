#include "io/gltf_node_objects.h"

#include <algorithm>
#include <memory>
#include <optional>

#include "io/gltf_accessor.h"
#include "io/gltf_extensions.h"
#include "io/gltf_transform.h"
#include "io/tiny_gltf_renamed.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {

using nlohmann::json;

std::string node_name(const tinygltf::Model& model, size_t node) {
  const std::string& name = model.nodes[node].name;
  return name.empty() ? "node " + std::to_string(node) : name;
}

double field_of_view(double yfov, const std::string& place) {
  if (yfov > 0.0 && yfov < kPiD) return yfov;
  throw InputError(place, "expected an angle between 0 and pi");
}

double magnification(double ymag, const std::string& place) {
  if (ymag != 0.0) return std::abs(ymag);
  throw InputError(place, "must not be 0");
}

Vec2f cone_angles(double inner, double outer, const std::string& place) {
  if (!(outer > 0.0 && inner >= 0.0)) {
    throw InputError(place, "expected 0 <= innerConeAngle < outerConeAngle");
  }
  const auto widest = float(std::min(outer, kPiD / 2.0));
  // Writers of hard-edged spots give both the same angle.
  return {float(std::min(inner, double(widest) * (1.0 - 1e-5))), widest};
}

namespace {

void read_lens(const tinygltf::Camera& source, const std::string& place,
               CameraDescription& camera) {
  if (source.type == "perspective") {
    const tinygltf::PerspectiveCamera& lens = source.perspective;
    camera.fov_y = field_of_view(lens.yfov, place + "/perspective/yfov");
    if (lens.aspectRatio > 0.0) camera.aspect = lens.aspectRatio;
  } else {
    const tinygltf::OrthographicCamera& lens = source.orthographic;
    camera.orthographic = true;
    magnification(lens.xmag, place + "/orthographic/xmag");
    camera.y_mag = magnification(lens.ymag, place + "/orthographic/ymag");
  }
}

}  // namespace

void read_camera(const GltfDocument& document, const tinygltf::Model& model, size_t node,
                 const Mat44d& to_world, SceneDescription& scene) {
  const int index = model.nodes[node].camera;
  // The node's member, where it names no camera at all.
  const std::string pointer = index < 0 ? "/nodes/" + std::to_string(node) + "/camera"
                                        : "/cameras/" + std::to_string(index);
  std::optional<InputError> fault = document.faults->hand_over(pointer);
  if (index < 0 && !fault) return;
  if (is_singular(to_world)) {
    ++scene.repairs.singular_instances;
    return;
  }
  // Of any number of nodes, with a name as long as the file.
  CameraDescription camera;
  camera.name = index < 0 || model.cameras[size_t(index)].name.empty()
                    ? node_name(model, node)
                    : model.cameras[size_t(index)].name;
  const std::string place = document.place(pointer);
  document.progress->budget()->reserve(
      MemoryPart::kGeometry, 2 * sizeof(CameraDescription) + camera.name.capacity(), place);
  camera.to_world = to_world;
  try {
    if (!fault) read_lens(model.cameras[size_t(index)], place, camera);
  } catch (const InputError& error) {
    fault = error;
  }
  if (fault) camera.fault = std::make_shared<InputError>(*fault);
  scene.cameras.push_back(std::move(camera));
}

void read_punctual_light(const GltfDocument& document, const tinygltf::Model& model, size_t node,
                         const Mat44d& to_world, SceneDescription& scene) {
  const json& reference = *find_extension(document.json.at("nodes")[node], "KHR_lights_punctual");
  const size_t index = reference.at("light").get<size_t>();
  document.faults->require("/extensions/KHR_lights_punctual/lights/" + std::to_string(index));
  const tinygltf::Light& source = model.lights[index];
  const json& object = find_extension(document.json, "KHR_lights_punctual")->at("lights")[index];
  const std::string place =
      document.place("/extensions/KHR_lights_punctual/lights/" + std::to_string(index));

  PunctualLightDescription light;
  light.name = source.name.empty() ? node_name(model, node) : source.name;
  document.progress->budget()->reserve(
      MemoryPart::kLights, 2 * sizeof(PunctualLightDescription) + light.name.capacity(), place);
  light.to_world = to_world;
  if (source.type == "spot") {
    light.type = PunctualType::kSpot;
  } else if (source.type == "directional") {
    light.type = PunctualType::kDirectional;
  }
  if (light.type != PunctualType::kPoint && is_singular(to_world)) {
    ++scene.repairs.singular_instances;
    return;
  }
  const double intensity = object.value("intensity", 1.0);
  const auto color = object.value("color", std::vector<double>{1.0, 1.0, 1.0});
  for (int c = 0; c < 3; ++c) {
    light.intensity[c] = float(std::max(color[size_t(c)], 0.0) * intensity);
  }
  if (!is_finite(light.intensity)) {
    throw InputError(place + "/intensity", "the light is too bright to be finite");
  }
  if (light.type == PunctualType::kSpot) {
    const json spot = object.value("spot", json::object());
    const Vec2f angles = cone_angles(spot.value("innerConeAngle", 0.0),
                                     spot.value("outerConeAngle", kPiD / 4.0), place + "/spot");
    light.inner_cone = angles.x;
    light.outer_cone = angles.y;
  }
  if (object.contains("range"))
    report_ignored(document.file, "light range (light falls off without an end)", scene.coverage);
  scene.lights.push_back(std::move(light));
}

std::vector<Mat44d> read_instance_transforms(const GltfDocument& document, const json& extension,
                                             size_t node, MemoryReservation& memory) {
  const std::string pointer =
      "/nodes/" + std::to_string(node) + "/extensions/EXT_mesh_gpu_instancing";
  const std::string place = document.place(pointer);
  const json& attributes = extension.at("attributes");
  const auto count_of = [&](const json& index) {
    return index.is_null() ? 0 : document.accessors[index.get<size_t>()].count;
  };
  size_t count = 0;
  bool counted = false;
  if (!attributes.empty()) {
    // Ten floats, and the matrix of them.
    memory.add(bytes_of(count_of(attributes.begin().value()), 10 * sizeof(float) + sizeof(Mat44d)),
               place);
  }
  const auto read = [&](const char* name, int components) -> std::vector<float> {
    const json* member = find_member(attributes, name);
    if (!member) return {};
    if (member->is_null()) document.faults->require(pointer + "/attributes/" + name);
    std::vector<float> values =
        read_floats(document, member->get<int>(), components, place + "/attributes/" + name);
    const size_t elements = values.size() / size_t(components);
    if (counted && elements != count) {
      throw InputError(place, "the instance attributes differ in their counts");
    }
    count = elements;
    counted = true;
    return values;
  };
  const std::vector<float> translations = read("TRANSLATION", 3);
  const std::vector<float> rotations = read("ROTATION", 4);
  const std::vector<float> scales = read("SCALE", 3);
  if (!counted) {
    // Only attributes without a meaning here, such as _ID.
    if (attributes.empty()) return {};
    const auto first = attributes.begin();
    if (first->is_null()) document.faults->require(pointer + "/attributes/" + first.key());
    count = size_t(document.accessor(first->get<int>()).count);
    if (count > document.most_zeros) throw InputError(place, "more instances than data");
  }
  std::vector<Mat44d> transforms;
  transforms.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    if (i % 65536 == 0) document.progress->check();
    Vec3d translation(0.0), scale(1.0);
    std::array<double, 4> rotation = {0.0, 0.0, 0.0, 1.0};
    for (int c = 0; c < 3; ++c) {
      if (!translations.empty()) translation[c] = translations[i * 3 + size_t(c)];
      if (!scales.empty()) scale[c] = scales[i * 3 + size_t(c)];
    }
    for (size_t c = 0; c < 4 && !rotations.empty(); ++c) rotation[c] = rotations[i * 4 + c];
    transforms.push_back(compose_transform(translation, rotation, scale));
    check_transform(transforms.back(), place);
  }
  return transforms;
}

}  // namespace emberline
