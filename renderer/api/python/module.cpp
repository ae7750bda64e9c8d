// `import emberline`: the library's interface (renderer/api/emberline.h) in Python.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "renderer/api/emberline.h"
#include "renderer/api/python/calls.h"
#include "renderer/api/python/values.h"

namespace emberline::python {
namespace {

using namespace pybind11::literals;  // "name"_a

// ---- errors ----------------------------------------------------------------------------------

struct ErrorTypes {
  py::handle error, usage, input, render;
};
ErrorTypes g_errors;  // the module's, which is never unloaded

py::handle add_error(py::module_& module, const char* name, const py::handle& base,
                     const char* doc) {
  const std::string full = std::string("emberline.") + name;
  PyObject* const type = PyErr_NewExceptionWithDoc(full.c_str(), doc, base.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  module.add_object(name, type);
  return type;
}

void raise(const py::handle& type, const char* what) {
  PyErr_SetObject(type.ptr(), text(what).ptr());
}

void add_errors(py::module_& module) {
  g_errors.error = add_error(module, "Error", PyExc_Exception,
                             "What went wrong, in one line: what, where, what to do.");
  g_errors.usage = add_error(module, "UsageError", g_errors.error, "A setting is wrong.");
  g_errors.input =
      add_error(module, "InputError", g_errors.error,
                "A file, or edits, cannot be used. Names the file and the place in it.");
  g_errors.render = add_error(module, "RenderError", g_errors.error,
                              "There is not the memory, or a file cannot be written.");
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const api::UsageError& error) {
      raise(g_errors.usage, error.what());
    } catch (const api::InputError& error) {
      raise(g_errors.input, error.what());
    } catch (const api::RenderError& error) {
      raise(g_errors.render, error.what());
    } catch (const api::Error& error) {
      raise(g_errors.error, error.what());
    }
  });
}

// ---- settings --------------------------------------------------------------------------------

std::vector<std::string> given(const api::Settings& settings) {
  std::vector<std::string> names;
  for (const auto& row : api::Settings::help()) {
    if (!settings.get(row.name).empty()) names.push_back(row.name);
  }
  return names;
}

std::string describe(const api::Settings& settings) {
  const api::Settings defaults;
  std::string all;
  for (const std::string& name : given(settings)) {
    const std::string value = settings.get(name);
    if (value == defaults.get(name)) continue;
    std::string option = name;
    std::ranges::replace(option, '-', '_');
    all += (all.empty() ? "" : ", ") + option + "=" + std::string(py::repr(text(value)));
  }
  return "Settings(" + all + ")";
}

std::string help(const std::optional<std::string>& name) {
  std::string all;
  for (const auto& row : api::Settings::help()) {
    if (name && row.name != setting_name(*name)) continue;
    all += row.name + (row.type.empty() ? "" : " " + row.type) + ": " + row.help + "\n";
    if (!row.values.empty()) all += row.values + (row.values.back() == '\n' ? "" : "\n");
  }
  if (name && all.empty()) api::Settings().get(*name);  // says which there are
  return all;
}

void add_settings(py::module_& module) {
  const auto get = [](const api::Settings& settings, const std::string& name) -> py::object {
    const std::string value = settings.get(setting_name(name));
    return value.empty() ? py::object(py::none()) : py::object(text(value));
  };
  const auto set = [](api::Settings& settings, const std::string& name, const py::object& value) {
    const std::string dashed = setting_name(name);
    settings.set(dashed, setting_text(dashed, value));
  };
  py::class_<api::Settings, std::shared_ptr<api::Settings>>(
      module, "Settings",
      "What decides a frame, by the names of the command's options: Settings(spp=16, "
      "noise_threshold=0.01, size=(320, 200)). Settings.help() lists them.")
      .def(py::init([](const api::Settings* base, const py::kwargs& options) {
             auto settings =
                 base ? std::make_shared<api::Settings>(*base) : std::make_shared<api::Settings>();
             apply(options, *settings);
             return settings;
           }),
           "base"_a = nullptr)
      .def(
          "read",
          [](api::Settings& settings, const py::object& path) { settings.read(path_of(path)); },
          "path"_a, "Takes over the settings in a file that the command has saved.")
      .def("__getitem__", get, "name"_a, "Its text; None where none is given.")
      .def("__setitem__", set, "name"_a, "value"_a)
      .def("keys", &given, "Those that have a value.")
      .def("__iter__", [](const api::Settings& s) { return py::iter(py::cast(given(s))); })
      .def("__copy__", [](const api::Settings& settings) { return api::Settings(settings); })
      .def(
          "__deepcopy__",
          [](const api::Settings& s, const py::object&) { return api::Settings(s); }, "memo"_a)
      .def("__repr__", &describe)
      .def_static("help", &help, "name"_a = py::none(), "What a setting does, or what all do.");
}

// ---- scenes ----------------------------------------------------------------------------------

// Their types; the library knows which values are valid.
api::Resources resources_of(const py::object& threads, const py::object& memory_limit,
                            const py::object& load_timeout) {
  const int64_t count = whole_number(threads, "threads").value_or(0);
  if (!std::in_range<int>(count)) {
    throw api::UsageError("threads: " + std::to_string(count) + " is out of range");
  }
  const std::optional<int64_t> bytes = whole_number(memory_limit, "memory_limit");
  if (bytes && *bytes < 0) {
    throw api::UsageError("memory_limit: " + std::to_string(*bytes) + " is below 0");
  }
  return {int(count), bytes ? std::optional(uint64_t(*bytes)) : std::nullopt,
          real_number(load_timeout, "load_timeout")};
}

// A forked process has its parent's scenes without the threads and locks that they need to end.
struct LeaveInForks {
  void operator()(const api::Scene* scene) const {
    if (!is_forked()) delete scene;
  }
};

using LoadedScene = std::unique_ptr<api::Scene, LeaveInForks>;

struct Scene {
  LoadedScene scene;
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

}  // namespace
}  // namespace emberline::python

EMBERLINE_CHECK_IS_MADE(emberline::python::Scene);
EMBERLINE_CHECK_IS_MADE(emberline::python::Progress);

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
  return result_of([&](Call& call) {
    api::Scene scene = animated ? api::Scene::animated(file, all, resources, call.given_up())
                                : api::Scene(file, all, resources, call.given_up());
    return std::make_shared<Scene>(Scene{LoadedScene(new api::Scene(std::move(scene))), all, all});
  });
}

void edit(Scene& scene, const py::object& edits, const py::object& environment) {
  const std::string json = edits_text(edits);
  std::optional<FloatArray> rgb;
  if (!environment.is_none()) rgb = rgb_of(environment, "environment");
  const Use use(scene, true);
  carry_out([&](Call&) {
    if (!rgb) return scene.scene->edit(json);
    scene.scene->edit(json, {rgb->data(), int(rgb->shape(1)), int(rgb->shape(0))});
  });
}

void pose(Scene& scene, const py::kwargs& options) {
  api::Settings settings = scene.loaded;
  apply(options, settings);
  const Use use(scene, true);
  carry_out([&](Call& call) { scene.scene->pose(settings, call.given_up()); });
  scene.settings = std::move(settings);
}

py::list texts(const std::vector<std::string>& names) {
  py::list list;
  for (const std::string& name : names) list.append(text(name));
  return list;
}

template <std::vector<std::string> (api::Scene::*names)() const>
py::list names_of(Scene& scene) {
  const Use use(scene, false);
  return texts(((*scene.scene).*names)());
}

void add_scene(py::module_& module) {
  py::class_<Scene, std::shared_ptr<Scene>>(
      module, "Scene",
      "A loaded glTF scene. Settings that concern its files (env, backfaces, time ...) count here, "
      "and all are what render() takes where it is given none.")
      .def(py::init(&load), "path"_a, "settings"_a = nullptr, py::kw_only(), "threads"_a = 0,
           "memory_limit"_a = py::none(), "load_timeout"_a = py::none(), "animated"_a = false)
      .def("pose", &pose,
           "pose(time=1.5): puts a scene that was loaded with animated=True where its animation "
           "has it. Takes animation, time or frame, fps, shutter and aov (for velocities), each "
           "as it was loaded unless it is given. The edits stay. What is wrong is raised, and the "
           "scene is then as it was.")
      .def("edit", &edit, "edits"_a, py::kw_only(), "environment"_a = py::none(),
           "All that differs from the file from now on, as a file of edits has it: a dict or "
           "JSON. {} is the file again. The environment may be an array or Picture: "
           "latitude-longitude, linear, rows from the top. What is wrong is raised, and the scene "
           "is then as it was.")
      .def_property_readonly(
          "settings", [](const Scene& scene) { return scene.settings; },
          "A copy of those that it was loaded with, and posed with.")
      .def_property_readonly("lights", &names_of<&api::Scene::lights>)
      .def_property_readonly("materials", &names_of<&api::Scene::materials>)
      .def_property_readonly("cameras", &names_of<&api::Scene::cameras>)
      .def_property_readonly("approximated", &names_of<&api::Scene::approximated>,
                             "What of the file is not honoured to the letter.")
      .def_property_readonly("ignored", &names_of<&api::Scene::ignored>);
}

// ---- pictures --------------------------------------------------------------------------------

Progress progress_of(const api::Progress& now) {
  py::object rgba = py::none();
  if (now.rgba) {
    py::array_t<float> copy({py::ssize_t(now.height), py::ssize_t(now.width), py::ssize_t(4)});
    std::memcpy(copy.mutable_data(), now.rgba, size_t(copy.nbytes()));
    rgba = std::move(copy);
  }
  return {now.samples, now.error_estimate, std::move(rgba)};
}

std::shared_ptr<api::Picture> render(Scene& scene, const api::Settings* settings,
                                     const py::object& threads, const py::object& progress,
                                     const py::kwargs& options) {
  for (const auto& row : api::Settings::help()) {
    std::string name = row.name;
    std::ranges::replace(name, '-', '_');
    if (row.of_scene && options.contains(name)) {
      throw api::UsageError(name + ": is decided when the scene is loaded; give it to Scene()");
    }
  }
  api::Settings all = settings ? *settings : scene.settings;
  apply(options, all);
  if (!progress.is_none() && !PyCallable_Check(progress.ptr())) {
    throw py::type_error("progress: not callable");
  }
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  const Use use(scene, false);
  std::stop_source stop;
  return result_of([&](Call& call) {
    std::function<void(const api::Progress&)> watch;
    if (!progress.is_none()) {
      watch = [&](const api::Progress& now) {
        call.in_python([&] {
          const py::object answer = progress(progress_of(now));
          py::detail::make_caster<bool> going_on;  // of Python's bool and NumPy's alone
          if (going_on.load(answer, false) && !static_cast<bool>(going_on)) stop.request_stop();
        });
      };
    }
    return std::make_shared<api::Picture>(
        api::render(*scene.scene, all, resources, stop.get_token(), watch, call.given_up()));
  });
}

std::shared_ptr<api::Picture> read(const py::object& path, const py::object& memory_limit,
                                   const py::object& load_timeout) {
  const std::string file = path_of(path);
  const api::Resources resources = resources_of(py::none(), memory_limit, load_timeout);
  return result_of([&](Call& call) {
    return std::make_shared<api::Picture>(api::read_picture(file, resources, call.given_up()));
  });
}

void write_bytes(const std::string& file, const py::array& array) {
  const py::array_t<uint8_t, py::array::c_style> values(array);
  const py::ssize_t channels = values.ndim() == 3 ? values.shape(2) : 1;
  constexpr auto kMost = std::numeric_limits<int>::max();
  if (values.ndim() < 2 || values.ndim() > 3 || values.shape(0) > kMost ||
      values.shape(1) > kMost || channels > 4) {
    throw py::value_error("picture: an array of the shape " + shape_of(values) +
                          ", where (height, width) or (height, width, 3 or 4) is needed");
  }
  carry_out([&](Call&) {
    api::write_picture(file, values.data(), int(values.shape(1)), int(values.shape(0)),
                       int(channels));
  });
}

bool holds_bytes(const py::object& picture) {
  if (!py::isinstance<py::array>(picture)) return false;
  const py::dtype type = py::reinterpret_borrow<py::array>(picture).dtype();
  return type.kind() == 'u' && type.itemsize() == 1;
}

void write(const py::object& path, const py::object& picture, double exposure,
           const py::object& channels) {
  const std::string file = path_of(path);
  if (is_object_of<api::Picture>(picture)) {
    if (!channels.is_none()) throw py::type_error("channels: a Picture has names of its own");
    const auto& values = py::cast<const api::Picture&>(picture);
    return carry_out([&](Call&) { api::write_picture(file, values, exposure); });
  }
  if (holds_bytes(picture)) {
    if (exposure != 0 || !channels.is_none()) {
      throw py::type_error("exposure, channels: not of uint8, which is written as it is");
    }
    return write_bytes(file, py::reinterpret_borrow<py::array>(picture));
  }
  const api::Picture values = picture_of(floats_of(picture, "picture"), channels);
  carry_out([&](Call&) { api::write_picture(file, values, exposure); });
}

std::string describe(const api::Picture& picture) {
  return "<emberline.Picture " + std::to_string(picture.width) + "x" +
         std::to_string(picture.height) + ": " +
         std::string(py::str(", ").attr("join")(layers(picture)).cast<py::str>()) +
         (picture.complete ? ">" : ", stopped>");
}

bool has_layer(const std::shared_ptr<api::Picture>& picture, const std::string& name) {
  try {
    layer(picture, name);
    return true;
  } catch (const py::key_error&) {
    return false;
  }
}

void add_pictures(py::module_& module) {
  using Pictures = std::shared_ptr<api::Picture>;
  py::class_<Progress>(module, "Progress", "How far a render has come.")
      .def_readonly("samples", &Progress::samples)
      .def_readonly("error_estimate", &Progress::error_estimate, "Of the picture of now, or None.")
      .def_readonly("rgba", &Progress::rgba,
                    "The picture of now, float32 (height, width, 4), linear; None with driver "
                    "\"bucket\".");
  py::class_<api::Picture, Pictures>(
      module, "Picture",
      "A frame, linear Rec. 709. picture[\"RGB\"] is a float32 array (height, width, 3), "
      "picture[\"samples\"] one of (height, width): views, which stay valid.")
      .def_readonly("width", &api::Picture::width)
      .def_readonly("height", &api::Picture::height)
      .def_readonly("x", &api::Picture::x, "Of its left edge in the frame: not 0 of a crop.")
      .def_readonly("y", &api::Picture::y)
      .def_readonly("frame_width", &api::Picture::frame_width)
      .def_readonly("frame_height", &api::Picture::frame_height)
      .def_readonly("samples", &api::Picture::samples, "Taken; 0 of a file.")
      .def_readonly("rays", &api::Picture::rays)
      .def_readonly("non_finite_samples", &api::Picture::non_finite_samples,
                    "That were NaN or infinite and count as black.")
      .def_readonly(
          "error_estimate", &api::Picture::error_estimate,
          "Expected RMS error as displayed, 0 to 1, or None: driver \"adaptive\" has one.")
      .def_readonly("complete", &api::Picture::complete,
                    "False: it was stopped; with driver \"bucket\" by time_limit, too.")
      .def_property_readonly("channels", [](const api::Picture& p) { return texts(p.channels); })
      .def_property_readonly("layers", &layers)
      .def_property_readonly("pixels", &pixels, "All channels, (height, width, channels).")
      .def("__getitem__", &layer, "name"_a,
           "A channel, (height, width), or a layer, (height, width, channels): \"RGB\", \"RGBA\", "
           "\"alpha\", \"samples\", \"error\", and what aov asked for.")
      .def("__contains__", &has_layer, "name"_a)
      .def("__repr__", [](const api::Picture& picture) { return describe(picture); });
  module.def(
      "render", &render, "scene"_a, "settings"_a = nullptr, py::kw_only(), "threads"_a = 0,
      "progress"_a = py::none(),
      "Renders with these settings, or those that the scene was loaded with, and options on "
      "top: render(scene, spp=64, driver=\"adaptive\"). progress(Progress) is called now and then "
      "on this thread; where it returns False, the render ends with what there is. Other "
      "threads of Python run meanwhile; Ctrl-C stops it.");
  module.def(
      "read", &read, "path"_a, py::kw_only(), "memory_limit"_a = py::none(),
      "load_timeout"_a = py::none(),
      "A picture file: an EXR with all its channels, or a PNG, JPEG, HDR, WebP or TIFF as linear.");
  module.def(
      "write", &write, "path"_a, "picture"_a, py::kw_only(), "exposure"_a = 0.0,
      "channels"_a = py::none(),
      "A Picture or float32 array, linear, as .exr, or displayed as .png or .jpg; a uint8 array "
      "as .png or .jpg as it is.");
}

// ---- comparisons -----------------------------------------------------------------------------

template <typename Value>
struct Field {
  const char* name;
  Value api::Comparison::*value;
  const char* meaning;
};
constexpr std::array kErrors = {
    Field<double>{"mse", &api::Comparison::mse, "Mean squared error."},
    Field<double>{"rmse", &api::Comparison::rmse, "Its square root."},
    Field<double>{"relmse", &api::Comparison::relmse, "Mean of (x - r)^2 / (r^2 + epsilon)."},
    Field<double>{"relmse_epsilon", &api::Comparison::relmse_epsilon, "That epsilon."},
    Field<double>{"relmse_trimmed", &api::Comparison::relmse_trimmed,
                  "Without the worst 0.1 % of pixels."},
    Field<double>{"signed_bias", &api::Comparison::signed_bias, "sum(x - r) / sum(r)"},
    Field<double>{"psnr", &api::Comparison::psnr, "In dB, as displayed."},
    Field<double>{"ssim", &api::Comparison::ssim, "1 if equal, as displayed."},
    Field<double>{"flip", &api::Comparison::flip, "Mean FLIP, 0 if equal, as displayed."},
    Field<double>{"max_abs", &api::Comparison::max_abs, "Largest difference."},
};
constexpr std::array kCounts = {
    Field<uint64_t>{"different_pixels", &api::Comparison::different_pixels, "Not the same bits."},
    Field<uint64_t>{"non_finite", &api::Comparison::non_finite,
                    "Pixels with a NaN or infinity, left out of the errors."},
};

py::dict as_dict(const api::Comparison& comparison) {
  py::dict all;
  for (const auto& field : kErrors) all[field.name] = comparison.*field.value;
  for (const auto& field : kCounts) all[field.name] = comparison.*field.value;
  return all;
}

// Both as the library takes them.
std::pair<FloatArray, FloatArray> pair_of(const py::object& image, const py::object& reference) {
  std::pair<FloatArray, FloatArray> pair(rgb_of(image, "image"), rgb_of(reference, "reference"));
  const auto& [a, b] = pair;
  if (a.shape(0) != b.shape(0) || a.shape(1) != b.shape(1)) {
    throw py::value_error("image and reference are of different sizes: " + shape_of(a) + " and " +
                          shape_of(b));
  }
  return pair;
}

void add_comparisons(py::module_& module) {
  py::class_<api::Comparison> type(
      module, "Comparison",
      "How far a picture is from a reference, as `emberline compare` says it.");
  for (const auto& field : kErrors) type.def_readonly(field.name, field.value, field.meaning);
  for (const auto& field : kCounts) type.def_readonly(field.name, field.value, field.meaning);
  type.def("as_dict", &as_dict).def("__repr__", [](const api::Comparison& comparison) {
    return "Comparison(" + std::string(py::repr(as_dict(comparison))) + ")";
  });
  module.def(
      "compare",
      [](const py::object& image, const py::object& reference, double exposure) {
        const auto [a, b] = pair_of(image, reference);
        return result_of([&, &x = a, &r = b](Call&) {
          return api::compare(x.data(), r.data(), int(x.shape(1)), int(x.shape(0)), exposure);
        });
      },
      "image"_a, "reference"_a, py::kw_only(), "exposure"_a = 0.0,
      "Of Pictures or float32 arrays (height, width, 3), linear. The exposure, in stops, is for "
      "what is "
      "measured as displayed.");
  module.def(
      "flip",
      [](const py::object& image, const py::object& reference, double exposure) {
        const auto [a, b] = pair_of(image, reference);
        const std::vector<float> map = result_of([&, &x = a, &r = b](Call&) {
          return api::flip(x.data(), r.data(), int(x.shape(1)), int(x.shape(0)), exposure);
        });
        return py::array_t<float>({a.shape(0), a.shape(1)}, map.data());
      },
      "image"_a, "reference"_a, py::kw_only(), "exposure"_a = 0.0,
      "FLIP's error of each pixel, (height, width), 0 to 1.");
}

// Python's own way makes an object of pybind11's base class for old protocols, which ends the
// process.
void refuse_pickling(py::module_& module) {
  const auto refuse = [](const py::handle& self, const py::args&) -> py::object {
    throw py::type_error("cannot pickle or copy a " +
                         std::string(py::str(py::type::handle_of(self).attr("__name__"))));
  };
  for (const char* const name : {"Settings", "Scene", "Progress", "Picture", "Comparison"}) {
    const py::object type = module.attr(name);
    for (const char* const method : {"__reduce__", "__reduce_ex__"}) {
      type.attr(method) = py::cpp_function(refuse, py::name(method), py::is_method(type));
    }
  }
}

}  // namespace

PYBIND11_MODULE(_emberline, module) {
  api::spell_settings(api::SettingSpelling::kUnderscores);
  module.attr("__version__") = api::version();
  add_errors(module);
  add_settings(module);
  add_scene(module);
  add_pictures(module);
  add_comparisons(module);
  refuse_pickling(module);
  set_up_calls();
}

}  // namespace emberline::python
