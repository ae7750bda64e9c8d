// `import emberline`: Python bindings of the library's interface (renderer/api/emberline.h).
#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

// Makes pickling throw. Python's default for old protocols would create an object of pybind11's
// base class, which aborts the process.
void disable_pickling(py::module_& module) {
  const auto throw_error = [](const py::handle& self, const py::args&) -> py::object {
    throw py::type_error("cannot pickle or copy a " +
                         std::string(py::str(py::type::handle_of(self).attr("__name__"))));
  };
  for (const char* const name :
       {"Settings", "Scene", "Progress", "Picture", "StoredFrame", "StudyTable", "Comparison"}) {
    const py::object type = module.attr(name);
    for (const char* const method : {"__reduce__", "__reduce_ex__"}) {
      type.attr(method) = py::cpp_function(throw_error, py::name(method), py::is_method(type));
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
  add_frames(module);
  add_comparisons(module);
  add_studies(module);
  add_heatmaps(module);
  disable_pickling(module);
  init_calls();
}

}  // namespace emberline::python
