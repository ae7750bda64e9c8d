// Loads, poses and edits scenes.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

std::shared_ptr<Scene> load(const py::object& path, const api::Settings* settings,
                            const py::object& threads, const py::object& memory_limit,
                            const py::object& load_timeout, bool animated,
                            const py::kwargs& options) {
  const std::string file = path_of(path);
  api::Settings all = settings ? *settings : api::Settings();
  apply(options, all);
  const api::Resources resources = resources_of(threads, memory_limit, load_timeout);
  return run_call_for_result([&](Call& call) {
    return std::make_shared<Scene>(
        animated ? api::Scene::animated(file, all, resources, call.cancellation())
                 : api::Scene(file, all, resources, call.cancellation()),
        all);
  });
}

void edit(Scene& scene, const py::object& edits, const py::object& environment) {
  const std::string json = edits_text(edits);
  std::optional<FloatArray> rgb;
  if (!environment.is_none()) rgb = rgb_of(environment, "environment");
  const SceneLock lock(scene, true);
  run_call([&](Call&) {
    if (!rgb) return scene.scene->edit(json);
    scene.scene->edit(json, {rgb->data(), int(rgb->shape(1)), int(rgb->shape(0))});
  });
}

void pose(Scene& scene, const py::kwargs& options) {
  api::Settings settings = scene.loaded;
  apply(options, settings);
  const SceneLock lock(scene, true);
  run_call([&](Call& call) { scene.scene->pose(settings, call.cancellation()); });
  scene.settings = std::move(settings);
}

template <std::vector<std::string> (api::Scene::*names)() const>
py::list names_of(Scene& scene) {
  const SceneLock lock(scene, false);
  return texts(((*scene.scene).*names)());
}

py::list nodes(Scene& scene) {
  const SceneLock lock(scene, false);
  py::list list;
  for (const api::Scene::Node& node : scene.scene->nodes()) {
    list.append(
        py::dict("index"_a = list.size(), "name"_a = text(node.name),
                 "parent"_a = node.parent < 0 ? py::object(py::none()) : py::int_(node.parent),
                 "mesh"_a = node.mesh, "camera"_a = node.camera, "light"_a = node.light,
                 "in_scene"_a = node.in_scene));
  }
  return list;
}

py::list animations(Scene& scene) {
  const SceneLock lock(scene, false);
  py::list list;
  for (const api::Scene::Animation& animation : scene.scene->animations()) {
    list.append(py::dict("name"_a = text(animation.name), "duration_s"_a = animation.duration));
  }
  return list;
}

py::object editable(Scene& scene) {
  const SceneLock lock(scene, false);
  return py::module_::import("json").attr("loads")(text(scene.scene->editable()));
}

}  // namespace

api::Resources resources_of(const py::object& threads, const py::object& memory_limit,
                            const py::object& load_timeout) {
  const int64_t count = whole_number(threads, "threads").value_or(0);
  if (!std::in_range<int>(count)) {
    throw api::UsageError("threads: " + std::to_string(count) + " is out of range");
  }
  const std::optional<int64_t> bytes = whole_number(memory_limit, "memory_limit");
  if (bytes && *bytes < 0) {
    throw api::UsageError("memory_limit: " + std::to_string(*bytes) + " is negative");
  }
  return {int(count), bytes ? std::optional(uint64_t(*bytes)) : std::nullopt,
          real_number(load_timeout, "load_timeout")};
}

py::list texts(const std::vector<std::string>& names) {
  py::list list;
  for (const std::string& name : names) list.append(text(name));
  return list;
}

void add_scene(py::module_& module) {
  py::class_<Scene, std::shared_ptr<Scene>>(
      module, "Scene",
      "A loaded glTF scene. Settings about its files (env, backfaces, time ...) take effect here. "
      "By default, render() uses all settings of the scene.")
      .def(py::init(&load), "path"_a, "settings"_a = nullptr, py::kw_only(), "threads"_a = 0,
           "memory_limit"_a = py::none(), "load_timeout"_a = py::none(), "animated"_a = false)
      .def("pose", &pose,
           "pose(time=1.5) moves a scene that was loaded with animated=True to a time of its "
           "animation. Accepts animation, time or frame, fps, shutter and aov (for velocities); "
           "the others keep their loaded values. Edits stay. An error leaves the scene unchanged.")
      .def("edit", &edit, "edits"_a, py::kw_only(), "environment"_a = py::none(),
           "Replaces the scene's edits: a dict or JSON, as in an edits file. {} restores the file. "
           "The environment may be an array or Picture: latitude-longitude, linear, rows from the "
           "top. An error leaves the scene unchanged.")
      .def_property_readonly(
          "settings", [](const Scene& scene) { return scene.settings; },
          "A copy of the settings that the scene was loaded and posed with.")
      .def_property_readonly("lights", &names_of<&api::Scene::light_sources>,
                             "Names of everything that emits light: the file's lights, then its "
                             "emissive materials, then \"environment\" if there is one.")
      .def_property_readonly("materials", &names_of<&api::Scene::materials>,
                             "Names of the file's materials, emissive ones included.")
      .def_property_readonly(
          "nodes", &nodes,
          "All nodes of the file, as in the JSON of `emberline info`: dicts with "
          "index, name, parent (an index or None), mesh, camera, light, and "
          "in_scene. catcher and holdout take their names and indices.")
      .def_property_readonly("animations", &animations,
                             "The file's animations: dicts with name and duration_s, in seconds.")
      .def_property_readonly(
          "editable", &editable,
          "Everything that can be edited: a dict of edits with the file's values for every light, "
          "every material and the environment. edit() with it restores these values.")
      .def_property_readonly("cameras", &names_of<&api::Scene::cameras>)
      .def_property_readonly("approximated", &names_of<&api::Scene::approximated>,
                             "Features of the file that are approximated.")
      .def_property_readonly("ignored", &names_of<&api::Scene::ignored>);
}

}  // namespace emberline::python
