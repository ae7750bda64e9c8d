// Objects shared by the module's files, and the functions that add their contents.
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

// Leaks scenes in a forked process, which lacks the threads and locks that the destructor needs.
struct LeaveInForks {
  void operator()(const api::Scene* scene) const {
    if (!is_forked()) delete scene;
  }
};

struct Scene {
  Scene(api::Scene made, const api::Settings& with)
      : scene(new api::Scene(std::move(made))), loaded(with), settings(with) {}

  std::unique_ptr<api::Scene, LeaveInForks> scene;
  api::Settings loaded;    // used for loading
  api::Settings settings;  // as loaded, with the current pose; the default of render()
  int renders = 0;         // in progress; accessed with the GIL
  bool edited = false;
};

// Passed to a progress callback, which may keep it.
struct Progress {
  uint64_t samples;
  std::optional<double> error_estimate;
  py::object rgba;
};

// Locks a scene for use by one editor or any number of renders.
class Use {
 public:
  Use(Scene& scene, bool edits) : scene_(scene), edits_(edits) {
    if (scene.edited || (edits && scene.renders > 0)) {
      throw api::UsageError(scene.edited ? "the scene is being edited by another thread"
                                         : "the scene cannot be edited while it is rendered");
    }
    edits ? void(scene.edited = true) : void(++scene.renders);
  }
  ~Use() { edits_ ? void(scene_.edited = false) : void(--scene_.renders); }
  Use(const Use&) = delete;
  Use& operator=(const Use&) = delete;

 private:
  Scene& scene_;
  const bool edits_;
};

}  // namespace emberline::python

EMBERLINE_CHECK_IS_MADE(emberline::python::Scene);
EMBERLINE_CHECK_IS_MADE(emberline::python::Progress);
EMBERLINE_CHECK_IS_MADE(emberline::api::StoredFrame);
EMBERLINE_CHECK_IS_MADE(emberline::api::StudyTable);

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
