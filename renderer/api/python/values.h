// What Python says, as the library's interface takes it, and pictures as NumPy has them.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/api/emberline.h"
#include "renderer/api/python/made_objects.h"

namespace emberline::python {

namespace py = pybind11;

// str, bytes or os.PathLike, in the file system's encoding. Throws TypeError, ValueError.
std::string path_of(const py::handle& path);

// "noise_threshold" is "noise-threshold".
std::string setting_name(std::string_view name);
std::string argument_name(std::string_view name);  // and back
// As the command's option has it: True is "yes", (320, 200) of "size" is "320x200", a list has
// commas. Throws TypeError.
std::string setting_text(const std::string& name, const py::handle& value);
void apply(const py::kwargs& options, api::Settings& settings);

// Edits as JSON, of a dict or of a str, which is taken as it is. NumPy's numbers and arrays are
// numbers and lists. A dict needs no "emberline_edits".
std::string edits_text(const py::object& edits);

using FloatArray = py::array_t<float, py::array::c_style>;

// Of a channel ("Z", "N.X", "samples") rows x columns; of a layer ("RGB", "RGBA", "albedo", "N")
// rows x columns x channels. A view into the picture, which it keeps alive, unless the channels lie
// scattered. "alpha" is A, "error" the standard error of R G B (aov "variance"). Throws KeyError.
py::array layer(const std::shared_ptr<api::RenderedPicture>& picture, const std::string& name);
py::list layers(const api::RenderedPicture& picture);
// All channels.
py::array pixels(const std::shared_ptr<api::RenderedPicture>& picture);

// Linear Rec. 709 of a Picture or an array, called `what`, as the library takes it. Throws
// TypeError for values that float32 does not hold, ValueError for another shape than (height,
// width, 3).
FloatArray rgb_of(const py::handle& picture, const std::string& what);
// None is nothing. Throws TypeError and ValueError, each of which names the argument.
std::optional<int64_t> whole_number(const py::handle& value, const std::string& what);
std::optional<double> real_number(const py::handle& value, const std::string& what);

// What an array holds as a picture, its channels called so; without, by their number.
api::RenderedPicture picture_of(const py::array& array, const py::object& channels);
// Throws TypeError for values that float32 does not hold.
FloatArray floats_of(const py::handle& array, const std::string& what);
std::string shape_of(const py::array& array);

}  // namespace emberline::python
