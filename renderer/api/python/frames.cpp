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
    throw py::type_error("progress: not callable");
  }
}

// Runs `work(call, watch, stop)`, which renders, with a Python progress callback.
template <typename Work>
std::shared_ptr<api::RenderedPicture> watched(const py::object& progress, const Work& work) {
  std::stop_source stop;
  return result_of([&](Call& call) {
    std::function<void(const api::Progress&)> watch;
    if (!progress.is_none()) {
      watch = [&](const api::Progress& now) {
        call.in_python([&] {
          const py::object answer = progress(progress_of(now));
          py::detail::make_caster<bool> going_on;  // accepts only Python's and NumPy's bool
          if (going_on.load(answer, false) && !static_cast<bool>(going_on)) stop.request_stop();
        });
      };
    }
    return std::make_shared<api::RenderedPicture>(work(call, watch, stop.get_token()));
  });
}

api::RenderFiles files_of(const py::object& checkpoint, bool resume, double interval, bool keep) {
  if (checkpoint.is_none()) {
    if (resume || keep) throw py::type_error("resume, keep_checkpoint: they need a checkpoint");
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
      throw api::UsageError(name + ": is decided when the scene is loaded; give it to Scene()");
    }
  }
  api::Settings all = settings ? *settings : scene.settings;
  apply(options, all);
  check_progress(progress);
  const api::RenderFiles files = files_of(checkpoint, resume, checkpoint_interval, keep_checkpoint);
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  const Use use(scene, false);
  return watched(progress, [&](Call& call, const auto& watch, const std::stop_token& stop) {
    return api::render(files, *scene.scene, all, resources, stop, watch, call.given_up());
  });
}

std::shared_ptr<Scene> load_stored(const std::string& file) {
  return result_of([&](Call& call) {
    const api::StoredFrame stored = api::stored_frame(file);
    return std::make_shared<Scene>(api::Scene(stored.scene, stored.settings, {}, call.given_up()),
                                   stored.settings);
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
  if (!scene) scene = load_stored(file);
  const Use use(*scene, false);
  return watched(progress, [&](Call& call, const auto& watch, const std::stop_token& stop) {
    return api::extend(file, *scene->scene, more, resources, stop, watch, call.given_up());
  });
}

std::shared_ptr<api::RenderedPicture> merge(const py::iterable& checkpoints, bool allow_holes,
                                            bool strict, bool parts, const py::object& threads,
                                            const py::object& memory_limit) {
  std::vector<std::string> files;
  for (const py::handle checkpoint : checkpoints) files.push_back(path_of(checkpoint));
  const api::Resources resources = resources_of(threads, memory_limit, py::none());
  return result_of([&](Call& call) {
    return std::make_shared<api::RenderedPicture>(
        api::merge(files, {allow_holes, strict, parts}, resources, call.given_up()));
  });
}

py::dict matte_names(Scene& scene, const api::Settings* settings, const py::kwargs& options) {
  api::Settings all = settings ? *settings : scene.settings;
  apply(options, all);
  const Use use(scene, false);
  return mattes_dict(result_of([&](Call&) { return api::matte_names(*scene.scene, all); }));
}

void add_frame_types(py::module_& module) {
  py::class_<Progress>(module, "Progress", "How far a render has come.")
      .def_readonly("samples", &Progress::samples)
      .def_readonly("error_estimate", &Progress::error_estimate, "Of the picture of now, or None.")
      .def_readonly("rgba", &Progress::rgba,
                    "The picture of now, float32 (height, width, 4), linear; None with driver "
                    "\"bucket\".");
  py::class_<api::StoredFrame>(module, "StoredFrame",
                               "What a checkpoint is of: see stored_frame().")
      .def_property_readonly(
          "scene", [](const api::StoredFrame& stored) { return text(stored.scene); },
          "The file, where it was.")
      .def_property_readonly(
          "settings", [](const api::StoredFrame& stored) { return stored.settings; },
          "A copy: of the frame, and of how its scene was loaded.")
      .def_property_readonly(
          "mattes", [](const api::StoredFrame& stored) { return mattes_dict(stored.mattes); },
          "As matte_names() has them.");
}

}  // namespace

void add_frames(py::module_& module) {
  add_frame_types(module);
  module.def(
      "stored_frame",
      [](const py::object& checkpoint) {
        const std::string file = path_of(checkpoint);
        return result_of([&](Call&) { return api::stored_frame(file); });
      },
      "checkpoint"_a, "What a checkpoint, or a part for merge(), is of.");
  module.def(
      "render", &render, "scene"_a, "settings"_a = nullptr, py::kw_only(), "threads"_a = 0,
      "progress"_a = py::none(), "checkpoint"_a = py::none(), "resume"_a = false,
      "checkpoint_interval"_a = 300.0, "keep_checkpoint"_a = false,
      "Renders with these settings, or those that the scene was loaded with, and options on "
      "top: render(scene, spp=64, driver=\"adaptive\"). progress(Progress) is called now and then "
      "on this thread; where it returns False, the render ends with what there is. Other "
      "threads of Python run meanwhile; Ctrl-C stops it. A checkpoint, a file, is saved every "
      "checkpoint_interval seconds and when the render is stopped or fails; resume=True goes on "
      "with it, to "
      "the same bits, and so does the command. It goes when the frame is done unless "
      "keep_checkpoint, for extend(), or part or sample_range, for merge().");
  module.def(
      "extend", &extend, "checkpoint"_a, "scene"_a = nullptr, py::kw_only(), "threads"_a = 0,
      "progress"_a = py::none(),
      "More of a finished frame whose checkpoint was kept: extend(\"shot.checkpoint\", spp=256). "
      "Takes spp, noise_threshold, max_spp and time_limit, of which nothing may be less than it "
      "was. Where every pixel gets as many samples, the picture has the bits of a frame that was "
      "rendered so at once; an adaptive frame goes on from where it is. The checkpoint is the "
      "larger frame's afterwards. Without a scene, it is loaded from where it was.");
  module.def(
      "merge", &merge, "checkpoints"_a, py::kw_only(), "allow_holes"_a = false, "strict"_a = false,
      "parts"_a = false, "threads"_a = 0, "memory_limit"_a = py::none(),
      "The frame whose parts (part, sample_range, or a seed each) these checkpoints have, as if it "
      "had been rendered at once. allow_holes: parts may be missing, and are black; strict: all "
      "are of one kind of machine; parts: a channel \"part\" says which of them each pixel is of, "
      "1 the first. Ctrl-C stops it.");
  module.def(
      "matte_names", &matte_names, "scene"_a, "settings"_a = nullptr,
      "What cryptomatte's channels show: {\"CryptoObject\": {name: id}}. An id is a whole number "
      "of "
      "32 bits; the channels hold it as the bits of a float32: "
      "picture[\"CryptoObject00\"].view(\"uint32\")[..., 0] is that of the largest share of each "
      "pixel, [..., 1] of the float32 array that share. Takes the settings, or those of the scene, "
      "and options on top.");
}

}  // namespace emberline::python
