// The module's exceptions and settings. Settings are named like the command's options.
#include <string>
#include <vector>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

struct ErrorTypes {
  py::handle error, usage, input, render;
};
ErrorTypes g_errors;  // owned by the module, which is never unloaded

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

std::vector<std::string> names_with_values(const api::Settings& settings) {
  std::vector<std::string> names;
  for (const auto& row : api::Settings::help()) {
    if (!settings.get(row.name).empty()) names.push_back(row.name);
  }
  return names;
}

std::string settings_repr(const api::Settings& settings) {
  const api::Settings defaults;
  std::string all;
  for (const std::string& name : names_with_values(settings)) {
    const std::string value = settings.get(name);
    if (value == defaults.get(name)) continue;
    all +=
        (all.empty() ? "" : ", ") + argument_name(name) + "=" + std::string(py::repr(text(value)));
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
  if (name && all.empty()) api::Settings().get(*name);  // throws and lists the valid names
  return all;
}

}  // namespace

void add_errors(py::module_& module) {
  g_errors.error =
      add_error(module, "Error", PyExc_Exception,
                "Any error; its one-line message names the problem, the place and what to do.");
  g_errors.usage = add_error(module, "UsageError", g_errors.error, "A setting is wrong.");
  g_errors.input =
      add_error(module, "InputError", g_errors.error,
                "A file or edits cannot be used. The message names the file and the place in it.");
  g_errors.render = add_error(module, "RenderError", g_errors.error,
                              "There is not enough memory, or a file cannot be written.");
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
      "The settings of a frame, named like the command's options: Settings(spp=16, "
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
          "path"_a, "Reads the settings from a file that the command has saved.")
      .def("__getitem__", get, "name"_a, "The setting's value as text; None if it is not set.")
      .def("__setitem__", set, "name"_a, "value"_a)
      .def("keys", &names_with_values, "The names of the settings that have a value.")
      .def("__iter__",
           [](const api::Settings& s) { return py::iter(py::cast(names_with_values(s))); })
      .def("__copy__", [](const api::Settings& settings) { return api::Settings(settings); })
      .def(
          "__deepcopy__",
          [](const api::Settings& s, const py::object&) { return api::Settings(s); }, "memo"_a)
      .def("__repr__", &settings_repr)
      .def_static("help", &help, "name"_a = py::none(), "Describes one setting, or all of them.");
}

}  // namespace emberline::python
