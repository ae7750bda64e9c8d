#include "renderer/api/python/values.h"

#include <algorithm>
#include <climits>
#include <vector>

#include "renderer/api/python/calls.h"

namespace emberline::python {
namespace {

std::string type_name(const py::handle& value) {
  return py::str(py::type::handle_of(value).attr("__name__"));
}

// Rejects null characters, which would truncate a C string.
std::string check_no_nul(std::string text, const std::string& what) {
  if (text.find('\0') != std::string::npos) throw py::value_error(what + ": has a null character");
  return text;
}

std::string encode_path(const py::handle& path) {
  return py::bytes(py::module_::import("os").attr("fsencode")(path));
}

std::optional<size_t> find(const api::RenderedPicture& picture, std::string_view channel) {
  const auto found = std::ranges::find(picture.channels, channel);
  if (found == picture.channels.end()) return std::nullopt;
  return size_t(found - picture.channels.begin());
}

// Returns the indices of the channels named LAYER.x.
std::vector<size_t> channels_of(const api::RenderedPicture& picture, const std::string& layer) {
  std::vector<size_t> indices;
  const auto add = [&](const std::string& prefix, std::string_view letters) {
    for (const char letter : letters) {
      if (const auto found = find(picture, prefix + letter)) indices.push_back(*found);
    }
  };
  if (layer == "RGB" || layer == "RGBA") {
    add("", layer);
    if (indices.size() != layer.size()) indices.clear();
    return indices;
  }
  const std::string prefix = layer + ".";
  add(prefix, "RGBA");  // first and in this order, because EXR sorts names
  for (size_t i = 0; i < picture.channels.size(); ++i) {
    const std::string& name = picture.channels[i];
    const bool is_in_layer =
        name.starts_with(prefix) && name.find('.', prefix.size()) == std::string::npos;
    if (is_in_layer && std::ranges::find(indices, i) == indices.end()) indices.push_back(i);
  }
  return indices;
}

// Returns a view if the channels are evenly spaced, and a copy otherwise.
py::array planes(const std::shared_ptr<api::RenderedPicture>& picture,
                 const std::vector<size_t>& indices) {
  api::RenderedPicture& p = *picture;
  const auto count = py::ssize_t(p.channels.size()), size = py::ssize_t(sizeof(float));
  const auto at = [&](size_t i) { return py::ssize_t(indices[i]); };
  const py::ssize_t step = indices.size() > 1 ? at(1) - at(0) : 1;
  bool is_evenly_spaced = true;
  for (size_t i = 1; i < indices.size(); ++i) is_evenly_spaced &= at(i) - at(i - 1) == step;
  const auto channels = py::ssize_t(indices.size());
  if (is_evenly_spaced) {
    return py::array_t<float>({py::ssize_t(p.height), py::ssize_t(p.width), channels},
                              {p.width * count * size, count * size, step * size},
                              p.values.data() + indices[0], py::cast(picture));
  }
  py::array_t<float> copy({py::ssize_t(p.height), py::ssize_t(p.width), channels});
  float* out = copy.mutable_data();
  for (size_t i = 0; i < p.values.size(); i += p.channels.size()) {
    for (const size_t c : indices) *out++ = p.values[i + c];
  }
  return copy;
}

std::string channel_name(const py::handle& name) {
  if (!py::isinstance<py::str>(name)) {
    throw py::type_error("channels: expected a string, not " + type_name(name));
  }
  Py_ssize_t size = 0;
  const char* const bytes = PyUnicode_AsUTF8AndSize(name.ptr(), &size);
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; };
  if (bytes && std::any_of(bytes, bytes + size, is_control)) {
    throw py::value_error("channels: " + std::string(py::repr(name)) + " has control characters");
  }
  if (bytes) return {bytes, size_t(size)};
  PyErr_Clear();  // a lone surrogate, which has no encoding
  throw py::value_error("channels: " + std::string(py::repr(name)) + " is not valid Unicode");
}

py::array standard_error(const std::shared_ptr<api::RenderedPicture>& picture) {
  const std::vector<size_t> variance = channels_of(*picture, "variance");
  if (variance.empty()) throw py::key_error("error: the picture needs the aov \"variance\"");
  const py::array values = planes(picture, variance);
  return py::module_::import("numpy").attr("sqrt")(values);
}

// Applies Python's recursion limit, since a value may contain itself.
class NestedCall {
 public:
  NestedCall() {
    if (Py_EnterRecursiveCall(" in a setting") != 0) throw py::error_already_set();
  }
  ~NestedCall() { Py_LeaveRecursiveCall(); }
  NestedCall(const NestedCall&) = delete;
  NestedCall& operator=(const NestedCall&) = delete;
};

bool is_list(const py::handle& value) {
  if (py::isinstance<py::array>(value)) return py::reinterpret_borrow<py::array>(value).ndim() > 0;
  return py::isinstance<py::tuple>(value) || py::isinstance<py::list>(value);
}

[[noreturn]] void throw_wrong_type(const std::string& what, const std::string& is,
                                   const std::string& expected) {
  throw py::type_error(what + ": expected " + expected + ", not " + is);
}

}  // namespace

std::string path_of(const py::handle& path) { return check_no_nul(encode_path(path), "path"); }

std::string setting_name(std::string_view name) {
  std::string dashed(name);
  std::ranges::replace(dashed, '_', '-');
  return dashed;
}

std::string argument_name(std::string_view name) {
  std::string argument(name);
  std::ranges::replace(argument, '-', '_');
  return argument;
}

std::string setting_text(const std::string& name, const py::handle& value) {
  if (PyBool_Check(value.ptr())) return value.ptr() == Py_True ? "yes" : "no";
  if (py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__")) {
    return check_no_nul(encode_path(value), name);
  }
  const NestedCall nested;
  // Converts a NumPy scalar or a 0-dimensional array.
  const auto dimensions = py::getattr(value, "ndim", py::none());
  if (PyLong_Check(dimensions.ptr()) && dimensions.cast<int>() == 0) {
    return setting_text(name, value.attr("item")());
  }
  if (PyIndex_Check(value.ptr()) && !py::isinstance<py::array>(value))
    return py::str(py::int_(py::reinterpret_borrow<py::object>(value)));
  if (PyFloat_Check(value.ptr())) return py::repr(value);
  if (is_list(value)) {
    std::string list;
    for (const py::handle entry : value) {
      if (is_list(entry)) throw py::type_error(name + ": expected an array with one dimension");
      if (!list.empty()) list += name == "size" ? 'x' : ',';
      list += setting_text(name, entry);
    }
    return list;
  }
  throw_wrong_type(name, type_name(value), "a string, a number, a bool or a list");
}

void apply(const py::kwargs& options, api::Settings& settings) {
  for (const auto& [key, value] : options) {
    const std::string name = setting_name(py::cast<std::string>(key));
    settings.set(name, setting_text(name, value));
  }
}

std::string edits_text(const py::object& edits) {
  if (py::isinstance<py::str>(edits)) return py::cast<std::string>(edits);
  if (!py::isinstance<py::dict>(edits)) {
    throw_wrong_type("edits", type_name(edits), "a dict or JSON");
  }
  py::dict all;
  all["emberline_edits"] = 1;
  all.attr("update")(edits);
  const py::cpp_function to_plain_value([](const py::object& value) -> py::object {
    if (py::hasattr(value, "tolist")) return value.attr("tolist")();
    return py::module_::import("os").attr("fspath")(value);  // may throw TypeError
  });
  const py::object dumps = py::module_::import("json").attr("dumps");
  return py::cast<std::string>(
      dumps(all, py::arg("default") = to_plain_value, py::arg("allow_nan") = false));
}

py::array pixels(const std::shared_ptr<api::RenderedPicture>& picture) {
  std::vector<size_t> all(picture->channels.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  return planes(picture, all);
}

py::array layer(const std::shared_ptr<api::RenderedPicture>& picture, const std::string& name) {
  if (name == "error" && !find(*picture, name)) return standard_error(picture);
  if (const auto channel = find(*picture, name == "alpha" ? "A" : name)) {
    return planes(picture, {*channel})[py::make_tuple(py::ellipsis(), 0)];
  }
  const std::vector<size_t> indices = channels_of(*picture, name);
  if (!indices.empty()) return planes(picture, indices);
  throw py::key_error(name + ": the picture has no such channel or layer; it has " +
                      std::string(py::str(", ").attr("join")(layers(*picture)).cast<py::str>()));
}

py::list layers(const api::RenderedPicture& picture) {
  py::list names;
  for (const std::string& channel : picture.channels) {
    const size_t stop = channel.rfind('.');
    const bool is_rgb = channel == "R" || channel == "G" || channel == "B";
    const py::str name = text(stop != std::string::npos && stop > 0 ? channel.substr(0, stop)
                              : is_rgb && !channels_of(picture, "RGB").empty() ? "RGB"
                                                                               : channel);
    if (!names.contains(name)) names.append(name);
  }
  return names;
}

std::string shape_of(const py::array& array) { return py::str(array.attr("shape")); }

FloatArray floats_of(const py::handle& array, const std::string& what) {
  if (!py::isinstance<py::array>(array)) {
    throw_wrong_type(what, type_name(array), "a NumPy array or a Picture");
  }
  const auto values = py::reinterpret_borrow<py::array>(array);
  const py::dtype type = values.dtype();
  if (type.kind() != 'f' || type.itemsize() > py::ssize_t(sizeof(float))) {
    throw_wrong_type(what,
                     std::string(py::str(py::handle(type))) + "; astype(\"float32\") converts it",
                     "float32");
  }
  for (py::ssize_t i = 0; i < values.ndim(); ++i) {
    if (values.shape(i) > INT_MAX)
      throw py::value_error(what + ": the array is too large: " + shape_of(values));
  }
  return FloatArray(values);
}

FloatArray rgb_of(const py::handle& picture, const std::string& what) {
  if (is_object_of<api::RenderedPicture>(picture)) {
    const auto of = py::cast<std::shared_ptr<api::RenderedPicture>>(picture);
    layer(of, "RGB");  // throws KeyError if missing
    return FloatArray({of->height, of->width, 3}, of->rec709().data());
  }
  const FloatArray values = floats_of(picture, what);
  if (values.ndim() != 3 || values.shape(2) != 3 || values.size() == 0) {
    throw py::value_error(what + ": expected an array of shape (height, width, 3), not " +
                          shape_of(values));
  }
  return values;
}

std::optional<int64_t> whole_number(const py::handle& value, const std::string& what) {
  if (value.is_none()) return std::nullopt;
  if (PyBool_Check(value.ptr()) || !PyIndex_Check(value.ptr())) {
    throw_wrong_type(what, type_name(value), "a whole number");
  }
  const py::int_ number(py::reinterpret_borrow<py::object>(value));
  int overflow = 0;
  const int64_t whole = PyLong_AsLongLongAndOverflow(number.ptr(), &overflow);
  if (overflow != 0) throw py::value_error(what + ": the number needs more than 64 bits");
  return whole;
}

std::optional<double> real_number(const py::handle& value, const std::string& what) {
  if (value.is_none()) return std::nullopt;
  if (PyBool_Check(value.ptr())) throw_wrong_type(what, "bool", "a number");
  const double number = PyFloat_AsDouble(value.ptr());
  if (number == -1.0 && PyErr_Occurred()) {
    PyErr_Clear();
    throw_wrong_type(what, type_name(value), "a number");
  }
  return number;
}

api::RenderedPicture picture_of(const py::array& array, const py::object& channels) {
  const FloatArray values = floats_of(array, "picture");
  if (values.ndim() < 2 || values.ndim() > 3 || values.size() == 0) {
    throw py::value_error(
        "picture: expected an array of shape (height, width) or (height, width, channels), not " +
        shape_of(values));
  }
  const auto count = size_t(values.ndim() == 3 ? values.shape(2) : 1);
  api::RenderedPicture picture;
  picture.height = int(values.shape(0));
  picture.width = int(values.shape(1));
  if (PyAnySet_Check(channels.ptr())) {
    throw_wrong_type("channels", type_name(channels), "names in order");
  }
  if (!channels.is_none()) {
    for (const py::handle name : channels) {
      // A generator may be infinite.
      if (picture.channels.size() > count) break;
      picture.channels.push_back(channel_name(name));
    }
  } else if (count == 1) {
    picture.channels = {"Y"};
  } else if (count == 3 || count == 4) {
    for (size_t c = 0; c < count; ++c) picture.channels.emplace_back(1, "RGBA"[c]);
  }
  if (picture.channels.size() != count) {
    throw py::value_error("channels: expected " + std::to_string(count) +
                          " names, one for each channel");
  }
  picture.values.assign(values.data(), values.data() + values.size());
  picture.complete = true;
  return picture;
}

}  // namespace emberline::python
