#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/json/edits_file.h"
#include "renderer/app/node_tree.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/shortened.h"
#include "renderer/core/utf8.h"
#include "renderer/description/edits_template.h"
#include "renderer/description/framing.h"
#include "renderer/engine/scene_file.h"
#include "renderer/engine/setting_rules.h"
#include "renderer/engine/setting_table.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/channel_list.h"
#include "renderer/output/frame_info.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/scene.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

Json describe_images(const SceneDescription& scene) {
  static constexpr const char* kTypes[] = {"uint8", "uint16", "half", "float"};
  Json list = Json::array();
  for (const auto& image : scene.images) {
    if (!image) continue;
    list.push_back({{"name", image->name},
                    {"width", image->width},
                    {"height", image->height},
                    {"channels", image->channels},
                    {"type", kTypes[size_t(image->type)]}});
  }
  return list;
}

Json describe_lights(const SceneDescription& scene) {
  static constexpr const char* kTypes[] = {"point", "spot", "directional"};
  Json list = Json::array();
  for (const PunctualLightDescription& light : scene.lights) {
    list.push_back({{"name", light.name},
                    {"type", kTypes[size_t(light.type)]},
                    {"intensity", {light.intensity.x, light.intensity.y, light.intensity.z}}});
    if (light.range < std::numeric_limits<float>::infinity()) list.back()["range"] = light.range;
  }
  return list;
}

Json describe_cameras(const SceneDescription& scene) {
  Json list = Json::array();
  for (const CameraDescription& camera : scene.cameras) {
    Json entry = {{"name", camera.name},
                  {"type", camera.orthographic ? "orthographic" : "perspective"}};
    if (!camera.node.empty()) entry["node"] = camera.node;
    if (camera.fault) {
      entry["type"] = "unusable";
      entry["fault"] = camera.fault->what();
    } else if (camera.orthographic) {
      entry["y_mag"] = camera.y_mag;
    } else {
      entry["fov_y_degrees"] = camera.fov_y * 180.0 / kPiD;
    }
    list.push_back(entry);
  }
  return list;
}

Json describe_animations(const SceneDescription& scene) {
  Json list = Json::array();
  for (const AnimationDescription& animation : scene.animations) {
    Json entry = {{"name", animation.name},         {"duration_s", animation.duration},
                  {"nodes", animation.nodes},       {"morphs", animation.morphs},
                  {"pointers", animation.pointers}, {"without_effect", animation.without_effect}};
    if (!animation.fault.empty()) entry["fault"] = animation.fault;
    list.push_back(entry);
  }
  return list;
}

Json describe_materials(const SceneDescription& scene) {
  Json list = Json::array();
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const MaterialDescription& material = scene.materials[i];
    list.push_back({{"index", i}, {"name", material.name}, {"emissive", emits(material)}});
  }
  return list;
}

Json describe_nodes(const SceneDescription& scene) {
  Json list = Json::array();
  for (size_t i = 0; i < scene.nodes.size(); ++i) {
    const NodeDescription& node = scene.nodes[i];
    list.push_back({{"index", i},
                    {"name", node.name},
                    {"parent", node.parent < 0 ? Json() : Json(node.parent)},
                    {"mesh", node.has_mesh},
                    {"camera", node.has_camera},
                    {"light", node.has_light},
                    {"in_scene", node.in_scene}});
  }
  return list;
}

Json describe_environment(const SceneDescription& scene) {
  if (!scene.environment) return nullptr;
  return {{"file", scene.environment->file},
          {"strength", scene.environment->strength},
          {"rotation_degrees", scene.environment->rotation_degrees}};
}

// Estimates the memory for the lists of nodes and materials. The JSON of a node or material is
// larger than its description. For text output, no JSON of the nodes is made.
uint64_t list_bytes(const SceneDescription& scene, bool as_json) {
  constexpr uint64_t kJsonBytes = 1024, kTreeBytes = 96;
  return bytes_of(scene.materials.size(), kJsonBytes) +
         bytes_of(scene.nodes.size(), as_json ? kJsonBytes : kTreeBytes);
}

Json describe(const SceneDescription& scene) {
  uint64_t stored = 0, placed = 0;
  for (const MeshDescription& mesh : scene.meshes) stored += mesh.triangles.size();
  for (const InstanceDescription& instance : scene.instances) {
    placed += scene.meshes[size_t(instance.mesh)].triangles.size();
  }
  const WorldBounds bounds = world_bounds(scene);
  Json json;
  json["file"] = scene.file;
  json["generator"] = scene.generator;
  json["meshes"] = scene.meshes.size();
  json["instances"] = scene.instances.size();
  json["triangles"] = {{"stored", stored}, {"placed", placed}};
  json["bounds"] = nullptr;
  if (!bounds.isEmpty()) {
    json["bounds"] = {{"min", {bounds.min.x, bounds.min.y, bounds.min.z}},
                      {"max", {bounds.max.x, bounds.max.y, bounds.max.z}}};
  }
  json["materials"] = scene.materials.size();
  json["variants"] = Json::array();
  for (const VariantDescription& v : scene.variants) json["variants"].push_back({{"name", v.name}});
  json["images"] = describe_images(scene);
  json["lights"] = describe_lights(scene);
  json["cameras"] = describe_cameras(scene);
  json["environment"] = describe_environment(scene);
  json["animations"] = describe_animations(scene);
  json["not_played"] = scene.coverage.not_played.empty() ? 0 : scene.animations.size();
  json["material_list"] = describe_materials(scene);
  json["gltf"] = {{"used", scene.coverage.used},
                  {"approximated", scene.coverage.approximated},
                  {"ignored", scene.coverage.ignored}};
  const LoadRepairs& r = scene.repairs;
  json["repairs"] = {{"degenerate_triangles", r.degenerate_triangles},
                     {"non_finite_triangles", r.non_finite_triangles},
                     {"non_finite_attributes", r.non_finite_attributes},
                     {"non_finite_texels", r.non_finite_texels},
                     {"singular_instances", r.singular_instances},
                     {"replaced_images", r.replaced_images}};
  return json;
}

std::string printable_text(const Json& text) { return printable(text.get<std::string>()); }
std::string printable_name(const Json& entry) {
  return printable(shortened(entry["name"].get_ref<const std::string&>()));
}

// A list shows at most this many entries, so that a long list does not hide the other lists.
constexpr size_t kMaxLines = 100;

// Appends line(index, entry) for the first kMaxLines entries.
template <class Line>
void append_lines(std::string& text, const Json& list, const Line& line) {
  for (size_t i = 0; i < std::min(list.size(), kMaxLines); ++i) text += line(i, list[i]) + "\n";
  if (list.size() > kMaxLines) text += fmt::format("  and {} more\n", list.size() - kMaxLines);
}

void append_list(std::string& text, const char* title, const Json& names) {
  if (names.empty()) return;
  text += title + std::string("\n");
  for (const Json& name : names) text += "  " + printable_text(name) + "\n";
}

std::string image_line(size_t, const Json& image) {
  return fmt::format("image {} x {} x {} {}  {}", image["width"].get<int>(),
                     image["height"].get<int>(), image["channels"].get<int>(),
                     printable_text(image["type"]), printable_text(image["name"]));
}

std::string variant_line(size_t index, const Json& variant) {
  return fmt::format("variant {} '{}'", index, printable_name(variant));
}

std::string camera_line(size_t index, const Json& camera) {
  std::string text = fmt::format("camera {} '{}' {}", index, printable_name(camera),
                                 printable_text(camera["type"]));
  const bool is_same_name = !camera.contains("node") || camera["node"] == camera["name"];
  if (!is_same_name) text += ", node '" + printable_text(camera["node"]) + "'";
  if (camera.contains("fault")) text += "\n  " + printable_text(camera["fault"]);
  return text;
}

std::string light_line(size_t index, const Json& light) {
  std::string text =
      fmt::format("light {} '{}' {}", index, printable_name(light), printable_text(light["type"]));
  if (light.contains("range"))
    text += fmt::format(", range {:.6g} m", light["range"].get<double>());
  return text;
}

std::string animation_line(size_t index, const Json& animation) {
  static constexpr std::pair<const char*, const char*> kCounts[] = {
      {"nodes", "nodes"},
      {"morphs", "morphed meshes"},
      {"pointers", "other values"},
      {"without_effect", "channels without effect"}};
  std::string text = fmt::format("animation {} '{}' {:.6g} s", index, printable_name(animation),
                                 animation["duration_s"].get<double>());
  for (const auto& [member, what] : kCounts) {
    const auto count = animation[member].get<size_t>();
    if (count > 0) text += fmt::format(", {} {}", count, what);
  }
  if (animation.contains("fault")) text += "; unusable: " + printable_text(animation["fault"]);
  return text;
}

std::string material_line(size_t index, const Json& material) {
  return fmt::format("material {} '{}'{}", index, printable_name(material),
                     material["emissive"].get<bool>() ? ", emissive" : "");
}

std::string format_head(const Json& j, size_t nodes) {
  std::string text = printable_text(j["file"]);
  const std::string generator = printable_text(j["generator"]);
  if (!generator.empty()) text += "  (" + generator + ")";
  text +=
      fmt::format("\nmeshes {}, instances {}, triangles {} ({} placed), materials {}, nodes {}\n",
                  j["meshes"].get<size_t>(), j["instances"].get<size_t>(),
                  j["triangles"]["stored"].get<uint64_t>(),
                  j["triangles"]["placed"].get<uint64_t>(), j["materials"].get<size_t>(), nodes);
  if (j["bounds"].is_null()) return text;
  const auto at = [&](const char* end, size_t i) { return j["bounds"][end][i].get<double>(); };
  return text + fmt::format("bounds {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", at("min", 0),
                            at("min", 1), at("min", 2), at("max", 0), at("max", 1), at("max", 2));
}

std::string format_info(const Json& j, size_t nodes, const std::string& not_played,
                        const std::string& tree) {
  std::string text = format_head(j, nodes);
  append_lines(text, j["images"], image_line);
  append_lines(text, j["variants"], variant_line);
  append_lines(text, j["cameras"], camera_line);
  append_lines(text, j["lights"], light_line);
  append_lines(text, j["material_list"], material_line);
  append_lines(text, j["animations"], animation_line);
  if (!not_played.empty()) text += "not played: " + spell_setting_names(not_played) + "\n";
  if (!tree.empty()) text += "nodes\n" + tree;
  for (const auto& [name, count] : j["repairs"].items()) {
    if (count.get<uint64_t>() > 0)
      text += fmt::format("repaired: {} {}\n", count.get<uint64_t>(), name);
  }
  append_list(text, "honoured", j["gltf"]["used"]);
  append_list(text, "approximated", j["gltf"]["approximated"]);
  append_list(text, "ignored", j["gltf"]["ignored"]);
  append_list(text, "scene features", j["features"]);
  return text;
}

SceneDescription read_scene(const InfoOptions& options, LoadProgress& progress) {
  for (const char* name : {"sun", "env-strength", "env-rotation"}) {
    check_rules(options.settings, name);
  }
  FrameSettings settings = options.settings;
  settings.scene = options.scene;
  return SceneFile(settings, progress, {.nodes = true}).pose(settings, {}, progress);
}

// Throws UsageError if options for reading a scene are given, because they have no meaning for a
// frame.
void reject_scene_options(const InfoOptions& options) {
  const auto reject = [&](const std::string& option) {
    throw UsageError("`{}` needs a scene, but {} is a frame", option, options.scene);
  };
  if (options.edits) reject("edits");
  const FrameSettings defaults;
  for (const Setting& setting : setting_table()) {
    if (setting.text(options.settings) != setting.text(defaults)) reject(setting.name);
  }
}

}  // namespace

int run_info(const InfoOptions& options) {
  if (options.channels) {
    print_result(channel_list(options.json));
    return kExitDone;
  }
  if (options.scene.empty()) throw UsageError("info needs a scene or a frame: emberline info FILE");
  const WorkerThreads workers(0);
  LoadProgress progress({}, {}, limits_of(options.limits, options.scene));
  if (is_exr_file(options.scene)) {
    reject_scene_options(options);
    print_result(frame_info(options.scene, progress, options.json));
    return kExitDone;
  }
  SceneDescription scene = read_scene(options, progress);
  if (options.edits) {
    apply({}, scene);
    print_result(format_edits(edits_template(scene)));
    return kExitDone;
  }
  const MemoryReservation memory(progress.budget(), MemoryPart::kGeometry,
                                 list_bytes(scene, options.json), options.scene);
  Json json = describe(scene);
  if (options.json) json["nodes"] = describe_nodes(scene);
  const size_t nodes = scene.nodes.size();
  const std::string not_played = scene.coverage.not_played;
  const std::string tree = options.json ? "" : node_tree(scene.nodes);
  SceneBuildOptions build_options;
  build_options.bvh = false;
  json["features"] = build_scene(std::move(scene), build_options, progress)->features();
  print_result(options.json ? json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"
                            : format_info(json, nodes, not_played, tree));
  return kExitDone;
}

}  // namespace emberline
