// Pictures: layers, reading and writing.
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

std::shared_ptr<api::RenderedPicture> read(const py::object& path, const py::object& memory_limit,
                                           const py::object& load_timeout) {
  const std::string file = path_of(path);
  const api::Resources resources = resources_of(py::none(), memory_limit, load_timeout);
  return run_call_for_result([&](Call& call) {
    return std::make_shared<api::RenderedPicture>(
        api::read_picture(file, resources, call.cancellation()));
  });
}

void write_bytes(const std::string& file, const py::array& array) {
  const py::array_t<uint8_t, py::array::c_style> values(array);
  const py::ssize_t channels = values.ndim() == 3 ? values.shape(2) : 1;
  constexpr auto kMaxSide = std::numeric_limits<int>::max();
  if (values.ndim() < 2 || values.ndim() > 3 || values.shape(0) > kMaxSide ||
      values.shape(1) > kMaxSide || channels > 4) {
    throw py::value_error(
        "picture: expected an array of shape (height, width) or (height, width, 3 or 4), not " +
        shape_of(values));
  }
  run_call([&](Call&) {
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
  if (is_object_of<api::RenderedPicture>(picture)) {
    if (!channels.is_none())
      throw py::type_error("channels: leave it out, because a Picture has its own names");
    const auto& values = py::cast<const api::RenderedPicture&>(picture);
    return run_call([&](Call&) { api::write_picture(file, values, exposure); });
  }
  if (holds_bytes(picture)) {
    if (exposure != 0 || !channels.is_none()) {
      throw py::type_error(
          "exposure, channels: leave them out, because uint8 is written unchanged");
    }
    return write_bytes(file, py::reinterpret_borrow<py::array>(picture));
  }
  const api::RenderedPicture values = picture_of(floats_of(picture, "picture"), channels);
  run_call([&](Call&) { api::write_picture(file, values, exposure); });
}

std::string describe(const api::RenderedPicture& picture) {
  return "<emberline.Picture " + std::to_string(picture.width) + "x" +
         std::to_string(picture.height) + ": " +
         std::string(py::str(", ").attr("join")(layers(picture)).cast<py::str>()) +
         (picture.complete ? ">" : ", stopped>");
}

bool has_layer(const std::shared_ptr<api::RenderedPicture>& picture, const std::string& name) {
  try {
    layer(picture, name);
    return true;
  } catch (const py::key_error&) {
    return false;
  }
}

}  // namespace

py::dict mattes_dict(const std::vector<api::MatteNames>& mattes) {
  py::dict layers;
  for (const api::MatteNames& of_kind : mattes) {
    py::dict ids;
    for (const auto& [name, id] : of_kind.ids) ids[text(name)] = id;
    layers[text(of_kind.layer)] = ids;
  }
  return layers;
}

void add_pictures(py::module_& module) {
  using Pictures = std::shared_ptr<api::RenderedPicture>;
  py::class_<api::RenderedPicture, Pictures>(
      module, "Picture",
      "A linear frame in the working space. picture[\"RGB\"] is a float32 array of shape (height, "
      "width, 3), and picture[\"samples\"] is one of shape (height, width). Both arrays are views "
      "that stay valid.")
      .def_readonly("width", &api::Picture::width)
      .def_readonly("height", &api::Picture::height)
      .def_readonly("x", &api::Picture::x,
                    "Column of its left edge in the frame; above 0 for a crop.")
      .def_readonly("y", &api::Picture::y)
      .def_readonly("frame_width", &api::Picture::frame_width)
      .def_readonly("frame_height", &api::Picture::frame_height)
      .def_readonly("samples", &api::Picture::samples, "Number of samples taken; 0 for a file.")
      .def_readonly("rays", &api::Picture::rays)
      .def_readonly("non_finite_samples", &api::Picture::non_finite_samples,
                    "Samples that were NaN or infinite and count as black.")
      .def_readonly(
          "error_estimate", &api::Picture::error_estimate,
          "Expected RMS error of the whole frame as displayed, 0 to 1; None unless the driver is "
          "\"adaptive\". picture[\"error\"] holds each pixel's error in linear radiance; "
          "heatmap_values(picture, \"error\") holds each pixel's error as displayed, and the RMS "
          "of those values is close to error_estimate.")
      .def_readonly("complete", &api::Picture::complete,
                    "False if the render was stopped; with driver \"bucket\", also by time_limit.")
      .def_property_readonly("channels",
                             [](const api::RenderedPicture& p) { return texts(p.channels); })
      .def_property_readonly("layers", &layers)
      .def_property_readonly("pixels", &pixels, "All channels, (height, width, channels).")
      .def(
          "__getitem__", &layer, "name"_a,
          "A channel, (height, width), or a layer, (height, width, channels): \"RGB\", \"RGBA\", "
          "\"alpha\", \"samples\", \"error\", and the layers that the settings aov, light_groups "
          "(\"light.key\"), cryptomatte (\"CryptoObject00\") and denoise (\"denoised\", "
          "\"denoised.error\") add. \"error\" is the standard deviation of each pixel's R, G and B "
          "in linear radiance: the square root of the layer \"variance\", which aov must request. "
          "Unlike error_estimate, it is per pixel and before the display transform.")
      .def("__contains__", &has_layer, "name"_a)
      .def("__repr__", [](const api::RenderedPicture& picture) { return describe(picture); });
  module.def("read", &read, "path"_a, py::kw_only(), "memory_limit"_a = py::none(),
             "load_timeout"_a = py::none(),
             "Reads a picture file: an EXR with all its channels, or a PNG, JPEG, HDR, WebP or "
             "TIFF, converted to linear.");
  module.def(
      "write", &write, "path"_a, "picture"_a, py::kw_only(), "exposure"_a = 0.0,
      "channels"_a = py::none(),
      "Writes a Picture or linear float32 array as .exr, or as displayed in .png or .jpg; writes a "
      "uint8 array as .png or .jpg unchanged. A rendered Picture is written as `emberline render` "
      "would write it. In an .exr, the settings half, exr_compression, exr_parts and working_space "
      "apply, and the header records the camera, the settings and the matte names. A .png or .jpg "
      "shows the denoised picture, if there is one.");
}

}  // namespace emberline::python
