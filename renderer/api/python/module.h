// Objects that the module's files share, and the functions that add each file's contents to the
// module.
#pragma once

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/api/emberline.h"
#include "renderer/api/python/calls.h"
#include "renderer/api/python/values.h"

namespace emberline::python {

using namespace pybind11::literals;  // "name"_a

// Leaks a scene in a forked process, because the destructor needs threads and locks that do not
// exist there.
struct LeakInForks {
  void operator()(const api::Scene* scene) const {
    if (!is_forked()) delete scene;
  }
};

struct Scene {
  Scene(api::Scene loaded_scene, const api::Settings& load_settings)
      : scene(new api::Scene(std::move(loaded_scene))),
        loaded(load_settings),
        settings(load_settings) {}

  std::unique_ptr<api::Scene, LeakInForks> scene;
  api::Settings loaded;    // settings used for loading
  api::Settings settings;  // `loaded` with the current pose; render() uses them as defaults
  int renders = 0;         // number of renders in progress; protected by the GIL
  bool is_being_edited = false;
};

// The argument of a progress callback. The callback may keep the object.
struct Progress {
  uint64_t samples;
  std::optional<double> error_estimate;
  py::object rgba;
};

// Locks a scene for one edit or any number of renders.
class SceneLock {
 public:
  SceneLock(Scene& scene, bool edits) : scene_(scene), edits_(edits) {
    if (scene.is_being_edited || (edits && scene.renders > 0)) {
      throw api::UsageError(scene.is_being_edited
                                ? "the scene is being edited by another thread"
                                : "the scene cannot be edited while it is rendered");
    }
    edits ? void(scene.is_being_edited = true) : void(++scene.renders);
  }
  ~SceneLock() { edits_ ? void(scene_.is_being_edited = false) : void(--scene_.renders); }
  SceneLock(const SceneLock&) = delete;
  SceneLock& operator=(const SceneLock&) = delete;

 private:
  Scene& scene_;
  const bool edits_;
};

}  // namespace emberline::python

EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::python::Scene);
EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::python::Progress);
EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::api::StoredFrame);
EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::api::StudyTable);

namespace emberline::python {

// Checks types; the library checks values. Throws TypeError, UsageError.
api::Resources resources_of(const py::object& threads, const py::object& memory_limit,
                            const py::object& load_timeout);
py::list texts(const std::vector<std::string>& names);
py::dict mattes_dict(const std::vector<api::MatteNames>& mattes);

void add_errors(py::module_& module);
void add_settings(py::module_& module);
void add_scene(py::module_& module);
void add_pictures(py::module_& module);
void add_frames(py::module_& module);
void add_comparisons(py::module_& module);
void add_heatmaps(py::module_& module);
void add_studies(py::module_& module);

}  // namespace emberline::python
