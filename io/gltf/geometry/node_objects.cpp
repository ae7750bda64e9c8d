#include "io/gltf/geometry/node_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cfloat>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/gltf/document/accessor.h"
#include "io/gltf/document/extensions.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/geometry/transform.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"

namespace emberline {

using nlohmann::json;

std::string node_name(const GltfDocument& document, size_t node) {
  const std::string& name = document.model->nodes[node].name;
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

namespace {

void note_defaulted_light(const GltfDocument& document, const std::string& pointer,
                          const std::string& message) {
  const InputError fault(document.place(pointer), message);
  if (document.requires_extension("KHR_lights_punctual")) throw InputError(fault);
  document.faults->note_defaulted(pointer, fault);
}

}  // namespace

Vec2f cone_angles(double inner, double outer, const GltfDocument& document,
                  const std::string& pointer) {
  const std::string spot = pointer + "/spot/";
  if (!(outer > 0.0 && outer <= kMaxOuterCone)) {
    note_defaulted_light(document, spot + "outerConeAngle",
                         fmt::format("the number {} is out of range", outer));
    outer = kPiD / 4.0;
  }
  // For a spot with a hard edge, writers set both angles to the same value, which may be rounded.
  if (!(inner >= 0.0 && inner <= outer * (1.0 + 1e-6))) {
    note_defaulted_light(
        document, spot + "innerConeAngle",
        fmt::format("the number {} is not between 0 and the outerConeAngle of {}", inner, outer));
    inner = inner > outer ? outer : 0.0;
  }
  const auto widest = float(std::min(outer, kPiD / 2.0));
  return {float(std::min(inner, double(widest) * (1.0 - 1e-5))), widest};
}

float light_range(double range, const GltfDocument& document, const std::string& pointer) {
  // Invalid animated values are clamped to the schema's minimum, FLT_TRUE_MIN. That value is
  // rejected too.
  if (range > double(FLT_TRUE_MIN)) return float(range);
  note_defaulted_light(document, pointer + "/range", "expected a number above 0");
  return std::numeric_limits<float>::infinity();
}

namespace {

// Returns the frame's aspect ratio, or nothing if xmag is not usable as a hint.
std::optional<double> orthographic_aspect(const GltfDocument& document,
                                          const tinygltf::OrthographicCamera& lens,
                                          const std::string& pointer) {
  if (lens.xmag == 0.0) {
    document.faults->note_defaulted(pointer, InputError(document.place(pointer), "must not be 0"));
  }
  const double aspect = std::abs(lens.xmag / lens.ymag);
  if (document.faults->has(pointer) || !std::isnormal(aspect)) return std::nullopt;
  return aspect;
}

void read_lens(const GltfDocument& document, const tinygltf::Camera& source,
               const std::string& pointer, CameraDescription& camera) {
  const std::string place = document.place(pointer);
  if (source.type == "perspective") {
    const tinygltf::PerspectiveCamera& lens = source.perspective;
    camera.fov_y = field_of_view(lens.yfov, place + "/perspective/yfov");
    if (lens.aspectRatio > 0.0) camera.aspect = lens.aspectRatio;
  } else {
    const tinygltf::OrthographicCamera& lens = source.orthographic;
    camera.orthographic = true;
    camera.y_mag = magnification(lens.ymag, place + "/orthographic/ymag");
    camera.aspect = orthographic_aspect(document, lens, pointer + "/orthographic/xmag");
  }
}

// Whether the clip planes might cut off something. Ignores near planes of up to a decimetre,
// because exporters write one even if the camera has none.
bool may_clip(const json& camera) {
  constexpr double kIgnoredNear = 0.101;
  const json& lens = camera.at(camera.at("type").get_ref<const std::string&>());
  return lens.contains("zfar") || lens.at("znear").get<double>() > kIgnoredNear;
}

}  // namespace

CameraDescription* read_camera(const GltfDocument& document, size_t node, const GltfPose& pose,
                               const Mat44d& to_world, SceneDescription& scene) {
  const int index = document.model->nodes[node].camera;
  // If the node has no valid camera, the fault may be in the "camera" member of the node itself.
  const std::string pointer = index < 0 ? "/nodes/" + std::to_string(node) + "/camera"
                                        : "/cameras/" + std::to_string(index);
  std::optional<InputError> fault = document.faults->take_fault(pointer);
  if (index < 0 && !fault) return nullptr;
  const std::optional<Mat44d> directed = aimed_transform(document, node, pose, to_world);
  if (!directed) {
    ++scene.repairs.singular_instances;
    return nullptr;
  }
  // Any number of nodes may use a camera, and its name may be as long as the file. Therefore the
  // memory is reserved.
  CameraDescription camera;
  camera.name = index < 0 || document.model->cameras[size_t(index)].name.empty()
                    ? node_name(document, node)
                    : document.model->cameras[size_t(index)].name;
  camera.node = document.model->nodes[node].name;
  const std::string place = document.place(pointer);
  document.reserve(MemoryPart::kGeometry,
                   2 * sizeof(CameraDescription) + camera.name.capacity() + camera.node.capacity(),
                   place);
  camera.to_world = *directed;
  try {
    if (!fault) read_lens(document, document.model->cameras[size_t(index)], pointer, camera);
    if (!fault && may_clip(document.json->at("cameras")[size_t(index)])) {
      note_approximated("clip planes of cameras (nothing is clipped)", scene.coverage);
    }
  } catch (const InputError& error) {
    fault = error;
  }
  if (fault) camera.fault = std::make_shared<InputError>(*fault);
  return &scene.cameras.emplace_back(std::move(camera));
}

PunctualLightDescription* read_punctual_light(const GltfDocument& document, size_t node,
                                              const GltfPose& pose, const Mat44d& to_world,
                                              SceneDescription& scene) {
  const json& reference = *find_extension(document.json->at("nodes")[node], "KHR_lights_punctual");
  const size_t index = reference.at("light").get<size_t>();
  const std::string pointer = "/extensions/KHR_lights_punctual/lights/" + std::to_string(index);
  document.faults->require(pointer);
  const tinygltf::Light& source = document.model->lights[index];
  const json& object = find_extension(*document.json, "KHR_lights_punctual")->at("lights")[index];
  const std::string place = document.place(pointer);

  PunctualLightDescription light;
  light.name = source.name.empty() ? node_name(document, node) : source.name;
  document.reserve(MemoryPart::kLights,
                   2 * sizeof(PunctualLightDescription) + light.name.capacity(), place);
  light.to_world = to_world;
  if (source.type == "spot") {
    light.type = PunctualType::kSpot;
  } else if (source.type == "directional") {
    light.type = PunctualType::kDirectional;
  }
  if (light.type != PunctualType::kPoint) {
    const std::optional<Mat44d> directed = aimed_transform(document, node, pose, to_world);
    if (!directed) {
      ++scene.repairs.singular_instances;
      return nullptr;
    }
    light.to_world = *directed;
  }
  const double intensity = object.value("intensity", 1.0);
  const auto color = object.value("color", std::vector<double>{1.0, 1.0, 1.0});
  for (int c = 0; c < 3; ++c) {
    if (color[size_t(c)] < 0.0) {
      document.faults->note_defaulted(
          pointer + "/color/" + std::to_string(c),
          InputError(place + "/color/" + std::to_string(c),
                     "expected a number of at least 0, found {}; 0 is used", color[size_t(c)]));
    }
    light.intensity[c] = float(std::max(color[size_t(c)], 0.0) * intensity);
  }
  if (!is_finite(light.intensity)) {
    throw InputError(place + "/intensity", "the light's intensity is not finite");
  }
  if (light.type == PunctualType::kSpot) {
    const json spot = object.value("spot", json::object());
    const Vec2f angles = cone_angles(spot.value("innerConeAngle", 0.0),
                                     spot.value("outerConeAngle", kPiD / 4.0), document, pointer);
    light.inner_cone = angles.x;
    light.outer_cone = angles.y;
  }
  const json* range = find_member(object, "range");
  if (range && light.type != PunctualType::kDirectional) {
    light.range = light_range(range->get<double>(), document, pointer);
  }
  return &scene.lights.emplace_back(std::move(light));
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
  bool has_count = false;
  if (!attributes.empty()) {
    // Memory per instance: up to ten floats and the resulting matrix.
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
    if (has_count && elements != count) {
      throw InputError(place, "the instance attributes have different counts");
    }
    count = elements;
    has_count = true;
    return values;
  };
  const std::vector<float> translations = read("TRANSLATION", 3);
  const std::vector<float> rotations = read("ROTATION", 4);
  const std::vector<float> scales = read("SCALE", 3);
  if (!has_count) {
    // The node has only attributes that this loader ignores, such as _ID. Their count is still the
    // number of instances.
    if (attributes.empty()) return {};
    const auto first = attributes.begin();
    if (first->is_null()) document.faults->require(pointer + "/attributes/" + first.key());
    count = size_t(document.accessor(first->get<int>()).count);
    if (count > document.max_zeros)
      throw InputError(place, "more instances than the file has data for");
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
