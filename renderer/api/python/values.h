// Converts Python values to the library's types, and pictures to NumPy arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/api/emberline.h"
#include "renderer/api/python/constructed_objects.h"

namespace emberline::python {

namespace py = pybind11;

// Accepts str, bytes or os.PathLike, in the file system's encoding. Throws TypeError, ValueError.
std::string path_of(const py::handle& path);

// Converts "noise_threshold" to "noise-threshold".
std::string setting_name(std::string_view name);
std::string argument_name(std::string_view name);  // the reverse
// Converts a value to the option's text: True to "yes", (320, 200) for "size" to "320x200", lists
// to comma-separated texts. Throws TypeError.
std::string setting_text(const std::string& name, const py::handle& value);
void apply(const py::kwargs& options, api::Settings& settings);

// Converts a dict of edits to JSON; a str is returned unchanged. NumPy numbers and arrays become
// numbers and lists. A dict needs no "emberline_edits".
std::string edits_text(const py::object& edits);

using FloatArray = py::array_t<float, py::array::c_style>;

// Returns a channel ("Z", "N.X", "samples") as rows x columns, or a layer ("RGB", "RGBA", "albedo",
// "N") as rows x columns x channels. The result is a view that keeps the picture alive, or a copy
// if the channels are not evenly spaced. "alpha" is A; "error" is the standard error of R G B, for
// which the picture needs the aov "variance". Throws KeyError.
py::array layer(const std::shared_ptr<api::RenderedPicture>& picture, const std::string& name);
py::list layers(const api::RenderedPicture& picture);
// Returns all channels as rows x columns x channels.
py::array pixels(const std::shared_ptr<api::RenderedPicture>& picture);

// Converts a Picture or array to linear Rec. 709. `what` names the argument in messages. Throws
// TypeError for values wider than float32, ValueError for a shape other than (height, width, 3).
FloatArray rgb_of(const py::handle& picture, const std::string& what);
// Convert a Python number; None becomes nullopt. Throw TypeError and ValueError with messages that
// begin with the argument's name, `what`.
std::optional<int64_t> whole_number(const py::handle& value, const std::string& what);
std::optional<double> real_number(const py::handle& value, const std::string& what);

// Creates a picture from an array with these channel names. The default is Y, RGB or RGBA,
// depending on the number of channels.
api::RenderedPicture picture_of(const py::array& array, const py::object& channels);
// Throws TypeError for values wider than float32.
FloatArray floats_of(const py::handle& array, const std::string& what);
std::string shape_of(const py::array& array);

}  // namespace emberline::python
