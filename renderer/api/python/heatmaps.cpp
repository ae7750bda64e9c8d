// Heatmaps of pictures.
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

api::HeatmapLook look_of(const std::string& colors, const py::object& range, bool log, bool plain) {
  api::HeatmapLook look{colors, std::nullopt, log, plain};
  if (!range.is_none()) look.range = py::cast<std::pair<double, double>>(range);
  return look;
}

}  // namespace

void add_heatmaps(py::module_& module) {
  using Pictures = std::shared_ptr<api::RenderedPicture>;
  module.def(
      "heatmap",
      [](const Pictures& picture, const std::string& of, const std::string& colors,
         const py::object& range, bool log, bool plain) {
        const api::HeatmapLook look = look_of(colors, range, log, plain);
        const api::DisplayedPicture drawn =
            run_call_for_result([&](Call&) { return api::heatmap(*picture, of, look); });
        return py::array_t<uint8_t>(
            {py::ssize_t(drawn.height), py::ssize_t(drawn.width), py::ssize_t(3)},
            drawn.values.data());
      },
      "picture"_a, "of"_a = "samples", py::kw_only(), "colors"_a = "grey", "range"_a = py::none(),
      "log"_a = false, "plain"_a = false,
      "Draws a heatmap of the sample counts, or of another quantity from heatmap_kinds(), as sRGB "
      "uint8 (rows, columns, 3). The picture's pixels are at the top left, one to one, with the "
      "legend below unless plain=True; write() saves it as `emberline heatmap` does. The colours "
      "are grey, viridis, inferno, magma or turbo; range=(min, max) sets the values of the first "
      "and last colour.");
  module.def(
      "heatmap_values",
      [](const Pictures& picture, const std::string& of) {
        const std::vector<float> values =
            run_call_for_result([&](Call&) { return api::heatmap_values(*picture, of); });
        return py::array_t<float>({py::ssize_t(picture->height), py::ssize_t(picture->width)},
                                  values.data());
      },
      "picture"_a, "of"_a = "samples",
      "The values that heatmap() draws: a float32 array of shape (height, width), with NaN where a "
      "pixel has no value. \"error\" is the expected RMS error as displayed, 0 to 1; \"time\" is "
      "in seconds.");
  module.def(
      "heatmap_kinds",
      [] {
        py::dict kinds;
        for (const api::HeatmapKind& kind : api::heatmap_kinds()) {
          kinds[text(kind.name)] = text(kind.summary);
        }
        return kinds;
      },
      "The quantities that a heatmap can show: {name: description}.");
}

}  // namespace emberline::python
