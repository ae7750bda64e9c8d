#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/gltf/gltf_file.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"
#include "renderer/core/utf8.h"
#include "renderer/description/framing.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/channel_list.h"
#include "renderer/output/frame_info.h"
#include "renderer/scene/build_scene.h"

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
  json["animations"] = describe_animations(scene);
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

std::string printable_text(const Json& name) { return printable(name.get<std::string>()); }

void append_list(std::string& text, const char* title, const Json& names) {
  if (names.empty()) return;
  text += title + std::string("\n");
  for (const Json& name : names) text += "  " + printable_text(name) + "\n";
}

void append_animations(std::string& text, const Json& animations) {
  static constexpr std::pair<const char*, const char*> kCounts[] = {
      {"nodes", "nodes"},
      {"morphs", "morphed meshes"},
      {"pointers", "other values"},
      {"without_effect", "channels without effect"}};
  size_t index = 0;
  for (const Json& animation : animations) {
    text += fmt::format("animation {} '{}' {:.6g} s", index++, printable_text(animation["name"]),
                        animation["duration_s"].get<double>());
    for (const auto& [member, what] : kCounts) {
      const auto count = animation[member].get<size_t>();
      if (count > 0) text += fmt::format(", {} {}", count, what);
    }
    if (animation.contains("fault")) text += "; unusable: " + printable_text(animation["fault"]);
    text += "\n";
  }
}

std::string format_info(const Json& j) {
  std::string text;
  const auto print = [&text](fmt::string_view format, const auto&... values) {
    fmt::vformat_to(std::back_inserter(text), format, fmt::make_format_args(values...));
  };
  print("{}", printable_text(j["file"]));
  const std::string generator = printable_text(j["generator"]);
  print("{}\n", generator.empty() ? "" : "  (" + generator + ")");
  print("meshes {}, instances {}, triangles {} ({} placed), materials {}\n",
        j["meshes"].get<size_t>(), j["instances"].get<size_t>(),
        j["triangles"]["stored"].get<uint64_t>(), j["triangles"]["placed"].get<uint64_t>(),
        j["materials"].get<size_t>());
  const auto at = [&](const char* end, size_t i) { return j["bounds"][end][i].get<double>(); };
  if (!j["bounds"].is_null()) {
    print("bounds {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", at("min", 0), at("min", 1),
          at("min", 2), at("max", 0), at("max", 1), at("max", 2));
  }
  for (const Json& image : j["images"]) {
    print("image {} x {} x {} {}  {}\n", image["width"].get<int>(), image["height"].get<int>(),
          image["channels"].get<int>(), printable_text(image["type"]),
          printable_text(image["name"]));
  }
  for (const Json& variant : j["variants"])
    print("variant '{}'\n", printable_text(variant["name"]));
  for (const Json& camera : j["cameras"]) {
    print("camera '{}' {}", printable_text(camera["name"]), printable_text(camera["type"]));
    const bool is_same_name = !camera.contains("node") || camera["node"] == camera["name"];
    print("{}\n", is_same_name ? "" : ", node '" + printable_text(camera["node"]) + "'");
    if (camera.contains("fault")) print("  {}\n", printable_text(camera["fault"]));
  }
  for (const Json& light : j["lights"]) {
    print("light '{}' {}", printable_text(light["name"]), printable_text(light["type"]));
    if (light.contains("range")) print(", range {:.6g} m", light["range"].get<double>());
    text += "\n";
  }
  append_animations(text, j["animations"]);
  for (const auto& [name, count] : j["repairs"].items()) {
    if (count.get<uint64_t>() > 0) print("repaired: {} {}\n", count.get<uint64_t>(), name);
  }
  append_list(text, "honoured", j["gltf"]["used"]);
  append_list(text, "approximated", j["gltf"]["approximated"]);
  append_list(text, "ignored", j["gltf"]["ignored"]);
  append_list(text, "scene features", j["features"]);
  return text;
}

}  // namespace

int run_info(const InfoOptions& options) {
  if (options.channels) {
    print_result(channel_list(options.json));
    return kExitDone;
  }
  if (options.scene.empty()) throw UsageError("scene is required");
  const WorkerThreads workers(0);
  LoadProgress progress({}, {}, limits_of(options.limits, options.scene));
  if (is_exr_file(options.scene)) {
    print_result(frame_info(options.scene, progress, options.json));
    return kExitDone;
  }
  SceneDescription scene = load_gltf(options.scene, load_options(options.settings), progress);
  Json json = describe(scene);
  SceneBuildOptions build_options;
  build_options.bvh = false;
  json["features"] = build_scene(std::move(scene), build_options, progress)->features();
  print_result(options.json ? json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"
                            : format_info(json));
  return kExitDone;
}

}  // namespace emberline
