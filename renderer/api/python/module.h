// What the files of the module share: its objects, and what each of them adds.
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

// A forked process has its parent's scenes without the threads and locks that they need to end.
struct LeaveInForks {
  void operator()(const api::Scene* scene) const {
    if (!is_forked()) delete scene;
  }
};

struct Scene {
  Scene(api::Scene made, const api::Settings& with)
      : scene(new api::Scene(std::move(made))), loaded(with), settings(with) {}

  std::unique_ptr<api::Scene, LeaveInForks> scene;
  api::Settings loaded;    // with these,
  api::Settings settings;  // and with those of its pose: what render() takes
  int renders = 0;         // under way; read and written with the GIL
  bool edited = false;
};

// What a progress callback is given, its own for ever.
struct Progress {
  uint64_t samples;
  std::optional<double> error_estimate;
  py::object rgba;
};

// Who uses a scene: one that edits it, or any number that render.
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

// Their types; the library knows which values are valid. Throws TypeError, UsageError.
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
