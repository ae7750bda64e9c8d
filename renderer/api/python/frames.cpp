// Renders, extends and merges frames.
#include <cstring>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

Progress progress_of(const api::Progress& now) {
  py::object rgba = py::none();
  if (now.rgba) {
    py::array_t<float> copy({py::ssize_t(now.height), py::ssize_t(now.width), py::ssize_t(4)});
    std::memcpy(copy.mutable_data(), now.rgba, size_t(copy.nbytes()));
    rgba = std::move(copy);
  }
  return {now.samples, now.error_estimate, std::move(rgba)};
}

void check_progress(const py::object& progress) {
  if (!progress.is_none() && !PyCallable_Check(progress.ptr())) {
    throw py::type_error("progress: expected a function");
  }
}

// Renders by calling work(call, watch, stop). `watch` calls Python's `progress`.
template <typename Work>
std::shared_ptr<api::RenderedPicture> render_with_progress(const py::object& progress,
                                                           const Work& work) {
  std::stop_source stop;
  return run_call_for_result([&](Call& call) {
    std::function<void(const api::Progress&)> watch;
    if (!progress.is_none()) {
      watch = [&](const api::Progress& now) {
        call.run_in_python([&] {
          const py::object answer = progress(progress_of(now));
          py::detail::make_caster<bool> should_continue;  // accepts only Python's and NumPy's bool
          if (should_continue.load(answer, false) && !static_cast<bool>(should_continue))
            stop.request_stop();
        });
      };
    }
    return std::make_shared<api::RenderedPicture>(work(call, watch, stop.get_token()));
  });
}

api::RenderFiles files_of(const py::object& checkpoint, bool resume, double interval, bool keep) {
  if (checkpoint.is_none()) {
    if (resume || keep) throw py::type_error("resume and keep_checkpoint require checkpoint");
    return api::RenderFiles::none();
  }
  api::RenderFiles files = api::RenderFiles::at(path_of(checkpoint));
  files.resume = resume;
  files.interval_s = interval;
  files.keep = keep;
  return files;
}

std::shared_ptr<api::RenderedPicture> render(Scene& scene, const api::Settings* settings,
                                             const py::object& threads, const py::object& progress,
                                             const py::object& checkpoint, bool resume,
                                             double checkpoint_interval, bool keep_checkpoint,
                                             const py::kwargs& options) {
  for (const auto& row : api::Settings::help()) {
    const std::string name = argument_name(row.name);
    if (row.of_scene && options.contains(name)) {
      throw api::UsageError(name +
                            ": it takes effect when the scene is loaded; pass it to Scene()");
    }
  }
  api::Settings all = settings ? *settings : scene.settings;
  apply(options, all);
  check_progress(progress);
  const api::RenderFiles files = files_of(checkpoint, resume, checkpoint_interval, keep_checkpoint);
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  const SceneLock lock(scene, false);
  return render_with_progress(
      progress, [&](Call& call, const auto& watch, const std::stop_token& stop) {
        return api::render(files, *scene.scene, all, resources, stop, watch, call.cancellation());
      });
}

std::shared_ptr<Scene> load_stored_scene(const std::string& file) {
  return run_call_for_result([&](Call& call) {
    const api::StoredFrame stored = api::stored_frame(file);
    return std::make_shared<Scene>(
        api::Scene(stored.scene, stored.settings, {}, call.cancellation()), stored.settings);
  });
}

std::shared_ptr<api::RenderedPicture> extend(const py::object& checkpoint,
                                             std::shared_ptr<Scene> scene,
                                             const py::object& threads, const py::object& progress,
                                             const py::kwargs& options) {
  const std::string file = path_of(checkpoint);
  api::Settings more;
  apply(options, more);
  check_progress(progress);
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  if (!scene) scene = load_stored_scene(file);
  const SceneLock lock(*scene, false);
  return render_with_progress(
      progress, [&](Call& call, const auto& watch, const std::stop_token& stop) {
        return api::extend(file, *scene->scene, more, resources, stop, watch, call.cancellation());
      });
}

std::shared_ptr<api::RenderedPicture> merge(const py::iterable& checkpoints, bool allow_holes,
                                            bool strict, bool parts, const py::object& threads,
                                            const py::object& memory_limit) {
  std::vector<std::string> files;
  for (const py::handle checkpoint : checkpoints) files.push_back(path_of(checkpoint));
  const api::Resources resources = resources_of(threads, memory_limit, py::none());
  return run_call_for_result([&](Call& call) {
    return std::make_shared<api::RenderedPicture>(
        api::merge(files, {allow_holes, strict, parts}, resources, call.cancellation()));
  });
}

py::dict matte_names(Scene& scene, const api::Settings* settings, const py::kwargs& options) {
  api::Settings all = settings ? *settings : scene.settings;
  apply(options, all);
  const SceneLock lock(scene, false);
  return mattes_dict(
      run_call_for_result([&](Call&) { return api::matte_names(*scene.scene, all); }));
}

void add_frame_types(py::module_& module) {
  py::class_<Progress>(module, "Progress", "The progress of a render.")
      .def_readonly("samples", &Progress::samples)
      .def_readonly("error_estimate", &Progress::error_estimate,
                    "Estimated error of the current picture, or None.")
      .def_readonly(
          "rgba", &Progress::rgba,
          "The current picture, linear, float32 (height, width, 4); None with driver \"bucket\".");
  py::class_<api::StoredFrame>(module, "StoredFrame",
                               "The frame in a checkpoint, from stored_frame().")
      .def_property_readonly(
          "scene", [](const api::StoredFrame& stored) { return text(stored.scene); },
          "The path of the scene's file when it was rendered.")
      .def_property_readonly(
          "settings", [](const api::StoredFrame& stored) { return stored.settings; },
          "A copy of the settings of the frame and its scene.")
      .def_property_readonly(
          "mattes", [](const api::StoredFrame& stored) { return mattes_dict(stored.mattes); },
          "Matte names, as from matte_names().");
}

}  // namespace

void add_frames(py::module_& module) {
  add_frame_types(module);
  module.def(
      "stored_frame",
      [](const py::object& checkpoint) {
        const std::string file = path_of(checkpoint);
        return run_call_for_result([&](Call&) { return api::stored_frame(file); });
      },
      "checkpoint"_a, "Describes the frame in a checkpoint, or in a part for merge().");
  module.def("render", &render, "scene"_a, "settings"_a = nullptr, py::kw_only(), "threads"_a = 0,
             "progress"_a = py::none(), "checkpoint"_a = py::none(), "resume"_a = false,
             "checkpoint_interval"_a = 300.0, "keep_checkpoint"_a = false,
             "Renders with `settings`, or with the scene's settings if `settings` is None; options "
             "override both: render(scene, spp=64, driver=\"adaptive\"). progress(Progress) is "
             "called regularly on this thread; if it returns False, the render stops and returns "
             "the unfinished picture. Other Python threads keep running; Ctrl-C stops the render. "
             "The file `checkpoint` is saved every checkpoint_interval seconds, and when the "
             "render is stopped or fails; resume=True, or the command, continues from it and gives "
             "the same bits. It is removed when the frame is finished, except with keep_checkpoint "
             "(for extend()), or with part or sample_range (for merge()).");
  module.def(
      "extend", &extend, "checkpoint"_a, "scene"_a = nullptr, py::kw_only(), "threads"_a = 0,
      "progress"_a = py::none(),
      "Adds samples to a finished frame whose checkpoint was kept: extend(\"shot.checkpoint\", "
      "spp=256). Accepts spp, noise_threshold, max_spp and time_limit. The first three must not "
      "ask for less than the frame already has. A uniform frame gets the same bits as if it had "
      "been rendered at once; an adaptive frame continues from its current state. Afterwards the "
      "checkpoint holds the extended frame. If no scene is given, it is loaded from its previous "
      "path.");
  module.def(
      "merge", &merge, "checkpoints"_a, py::kw_only(), "allow_holes"_a = false, "strict"_a = false,
      "parts"_a = false, "threads"_a = 0, "memory_limit"_a = py::none(),
      "Merges the checkpoints of a frame's parts (part, sample_range, or different seeds) into the "
      "frame, as if it had been rendered at once. allow_holes: parts may be missing, and their "
      "pixels are black; strict: all parts must come from one kind of machine; parts: a channel "
      "\"part\" tells which part each pixel comes from, starting at 1. Ctrl-C stops the merge.");
  module.def("matte_names", &matte_names, "scene"_a, "settings"_a = nullptr,
             "Names and ids in cryptomatte's channels: {\"CryptoObject\": {name: id}}. An id is a "
             "32-bit whole number, and the channels store it as the bits of a float32: "
             "picture[\"CryptoObject00\"].view(\"uint32\")[..., 0] is the id with the largest "
             "share of each pixel, and picture[\"CryptoObject00\"][..., 1] is that share. Uses "
             "`settings`, or the scene's settings if `settings` is None; options override both.");
}

}  // namespace emberline::python
