// Comparisons of pictures.
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

template <typename Value>
struct Field {
  const char* name;
  Value api::Comparison::*value;
  const char* meaning;
};
constexpr std::array kErrors = {
    Field<double>{"mse", &api::Comparison::mse, "Mean squared error."},
    Field<double>{"rmse", &api::Comparison::rmse, "Square root of mse."},
    Field<double>{"relmse", &api::Comparison::relmse, "Mean of (x - r)^2 / (r^2 + epsilon)."},
    Field<double>{"relmse_epsilon", &api::Comparison::relmse_epsilon, "The epsilon of relmse."},
    Field<double>{"relmse_trimmed", &api::Comparison::relmse_trimmed,
                  "relmse without the worst 0.1 % of the pixels."},
    Field<double>{"signed_bias", &api::Comparison::signed_bias, "sum(x - r) / sum(r)"},
    Field<double>{"psnr", &api::Comparison::psnr,
                  "Peak signal-to-noise ratio in dB, as displayed."},
    Field<double>{"ssim", &api::Comparison::ssim,
                  "Structural similarity, 1 if equal, as displayed."},
    Field<double>{"flip", &api::Comparison::flip, "Mean FLIP, 0 if equal, as displayed."},
    Field<double>{"max_abs", &api::Comparison::max_abs, "Largest absolute difference."},
};
constexpr std::array kCounts = {
    Field<uint64_t>{"different_pixels", &api::Comparison::different_pixels,
                    "Pixels whose bits differ."},
    Field<uint64_t>{"non_finite", &api::Comparison::non_finite,
                    "Pixels with a NaN or infinity, which the errors exclude."},
};

py::dict as_dict(const api::Comparison& comparison) {
  py::dict all;
  for (const auto& field : kErrors) all[field.name] = comparison.*field.value;
  for (const auto& field : kCounts) all[field.name] = comparison.*field.value;
  return all;
}

// Converts both pictures to the library's format.
std::pair<FloatArray, FloatArray> pair_of(const py::object& image, const py::object& reference) {
  std::pair<FloatArray, FloatArray> pair(rgb_of(image, "image"), rgb_of(reference, "reference"));
  const auto& [a, b] = pair;
  if (a.shape(0) != b.shape(0) || a.shape(1) != b.shape(1)) {
    throw py::value_error("image and reference have different sizes: " + shape_of(a) + " and " +
                          shape_of(b));
  }
  return pair;
}

}  // namespace

void add_comparisons(py::module_& module) {
  py::class_<api::Comparison> type(
      module, "Comparison",
      "The differences between a picture and a reference, as in `emberline compare`.");
  for (const auto& field : kErrors) type.def_readonly(field.name, field.value, field.meaning);
  for (const auto& field : kCounts) type.def_readonly(field.name, field.value, field.meaning);
  type.def("as_dict", &as_dict).def("__repr__", [](const api::Comparison& comparison) {
    return "Comparison(" + std::string(py::repr(as_dict(comparison))) + ")";
  });
  module.def(
      "compare",
      [](const py::object& image, const py::object& reference, double exposure) {
        const auto [a, b] = pair_of(image, reference);
        return run_call_for_result([&, &x = a, &r = b](Call&) {
          return api::compare(x.data(), r.data(), int(x.shape(1)), int(x.shape(0)), exposure);
        });
      },
      "image"_a, "reference"_a, py::kw_only(), "exposure"_a = 0.0,
      "Compares two Pictures, or linear float32 arrays (height, width, 3). The exposure, in stops, "
      "applies to metrics that are measured as displayed.");
  module.def(
      "flip",
      [](const py::object& image, const py::object& reference, double exposure) {
        const auto [a, b] = pair_of(image, reference);
        const std::vector<float> map = run_call_for_result([&, &x = a, &r = b](Call&) {
          return api::flip(x.data(), r.data(), int(x.shape(1)), int(x.shape(0)), exposure);
        });
        return py::array_t<float>({a.shape(0), a.shape(1)}, map.data());
      },
      "image"_a, "reference"_a, py::kw_only(), "exposure"_a = 0.0,
      "FLIP error of each pixel, (height, width), 0 to 1.");
}

}  // namespace emberline::python
