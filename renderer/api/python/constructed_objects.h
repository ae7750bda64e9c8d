// Casters that reject objects whose __init__ has not run. For such an object, pybind11 would return
// uninitialised memory. These objects come from Scene.__new__(Scene), or from a subclass that uses
// `self` before it calls super().__init__().
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <string>
#include <typeinfo>

#include "renderer/api/emberline.h"

namespace emberline::python {

namespace py = pybind11;

// Whether `value` is an instance of the class. isinstance() would also accept objects with a fake
// __class__, such as mocks.
template <typename Class>
bool is_object_of(const py::handle& value) {
  const auto* const type = py::detail::get_type_info(typeid(Class));
  return value && PyType_IsSubtype(Py_TYPE(value.ptr()), type->type);
}

template <typename Class>
void check_is_constructed(const py::handle& value) {
  if (!is_object_of<Class>(value)) return;
  const auto* const type = py::detail::get_type_info(typeid(Class));
  auto* const object = reinterpret_cast<py::detail::instance*>(value.ptr());
  if (object->get_value_and_holder(type).holder_constructed()) return;
  const std::string name =
      py::str(py::handle(reinterpret_cast<PyObject*>(type->type)).attr("__name__"));
  throw py::type_error("this " + name + " is used before its __init__() has run");
}

template <typename Class, typename Base>
struct ConstructedCaster : Base {
  bool load(py::handle object, bool convert) {
    check_is_constructed<Class>(object);
    return Base::load(object, convert);
  }
};

}  // namespace emberline::python

// Use this macro for each class of the module, in the global namespace, before any function takes
// or returns an object of that class.
#define EMBERLINE_CHECK_IS_CONSTRUCTED(Class)                                                      \
  template <>                                                                                      \
  struct pybind11::detail::type_caster<Class>                                                      \
      : emberline::python::ConstructedCaster<Class, pybind11::detail::type_caster_base<Class>> {}; \
  template <>                                                                                      \
  struct pybind11::detail::type_caster<std::shared_ptr<Class>>                                     \
      : emberline::python::ConstructedCaster<                                                      \
            Class, pybind11::detail::copyable_holder_caster<Class, std::shared_ptr<Class>>> {}

EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::api::Settings);
EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::api::RenderedPicture);
EMBERLINE_CHECK_IS_CONSTRUCTED(emberline::api::Comparison);
