#include "io/gltf_material_object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "io/gltf_extensions.h"
#include "io/gltf_images.h"
#include "io/tiny_gltf_renamed.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

WrapMode wrap_mode(int code, const std::string& place) {
  switch (code) {
    case 10497:
      return WrapMode::kRepeat;
    case 33648:
      return WrapMode::kMirroredRepeat;
    case 33071:
      return WrapMode::kClampToEdge;
    default:
      throw InputError(place, "unknown wrap mode {}", code);
  }
}

// KHR_texture_transform: uv' = translation * rotation * scale * uv, with the rotation as its
// README writes it (counter-clockwise in a space with v downwards).
std::array<float, 6> transform_matrix(const json& extension) {
  const std::vector<double> offset = extension.value("offset", std::vector<double>{0.0, 0.0});
  const std::vector<double> scale = extension.value("scale", std::vector<double>{1.0, 1.0});
  const double angle = extension.value("rotation", 0.0);
  const double c = std::cos(angle), s = std::sin(angle);
  return {float(c * scale[0]),  float(s * scale[1]), float(offset[0]),
          float(-s * scale[0]), float(c * scale[1]), float(offset[1])};
}

float clamped_to_share(double value, const std::string& file) {
  if (value >= 0.0 && value <= 1.0) return float(value);
  log_warning(file + ": material factors outside [0, 1] are clamped");
  return float(std::clamp(value, 0.0, 1.0));
}

}  // namespace

void GltfMaterialObject::refuse(const std::string& place, const std::string& message,
                                const std::string& instead) const {
  if (!file_.options.lenient) throw InputError(place, message);
  log_warning(place + ": " + message + "; " + instead);
}

void GltfMaterialObject::report_ignored(const std::string& what) const {
  emberline::report_ignored(file_.document.file, what, file_.coverage);
}

void GltfMaterialObject::share(const char* name, float& value) const {
  if (const json* found = find_member(object_, name)) {
    value = clamped_to_share(found->get<double>(), file_.document.file);
  }
}

void GltfMaterialObject::shares(const char* name, Rgb& value) const {
  const json* found = find_member(object_, name);
  for (size_t c = 0; found && c < 3; ++c) {
    value[int(c)] = clamped_to_share(found->at(c).get<double>(), file_.document.file);
  }
}

void GltfMaterialObject::shares(const char* name, Rgb& value, float& alpha) const {
  shares(name, value);
  if (const json* found = find_member(object_, name)) {
    alpha = clamped_to_share(found->at(3).get<double>(), file_.document.file);
  }
}

void GltfMaterialObject::non_negative(const char* name, Rgb& value) const {
  const json* found = find_member(object_, name);
  for (size_t c = 0; found && c < 3; ++c) {
    const double component = found->at(c).get<double>();
    if (component < 0.0) {
      log_warning(file_.document.file + ": material colours below 0 are taken for 0");
    }
    value[int(c)] = float(std::max(component, 0.0));
  }
}

void GltfMaterialObject::number(const char* name, float& value, const ValidNumbers& valid) const {
  const json* found = find_member(object_, name);
  if (!found) return;
  const auto read = float(found->get<double>());
  if (std::isfinite(read) && valid.contain(read)) {
    value = read;
    return;
  }
  refuse(place(name),
         fmt::format("expected {}, found {}", valid.expected, shortened(found->dump())),
         fmt::format("the default, {}, takes its place", value));
}

const json* GltfMaterialObject::texture_info(const char* name) const {
  const json* info = find_member(object_, name);
  if (!info) return nullptr;
  const json& index = info->at("index");
  file_.document.faults->require("/textures");
  const size_t count = file_.document.array("textures").size();
  if (index.get<uint64_t>() < count) {
    file_.document.faults->require("/textures/" + index.dump());
    return info;
  }
  refuse(place(name) + "/index",
         fmt::format("index {} is out of range: the file has {} textures", index.dump(), count),
         "the slot has no texture");
  return nullptr;
}

TextureRef GltfMaterialObject::texture_ref(const json& info, const char* name) const {
  TextureRef ref;
  const GltfDocument& document = file_.document;
  const size_t index = info.at("index").get<size_t>();
  const std::vector<int> sources = texture_sources(document.json.at("textures")[index]);
  if (sources.empty() && file_.options.lenient) {
    report_ignored("a texture without a PNG, JPEG, WebP or KTX 2 image");
    return ref;
  }
  if (sources.empty()) {
    throw InputError(document.place("/textures/" + std::to_string(index)),
                     "the texture of " + pointer_ + "/" + name +
                         " has no image in a format that is supported (PNG, JPEG, WebP, KTX 2)");
  }
  ref.image = sources[0];
  ref.uv_set = info.value("texCoord", 0);
  const int number = file_.model.textures[index].sampler;
  if (number >= 0) {
    const tinygltf::Sampler& sampler = file_.model.samplers[size_t(number)];
    const std::string place = document.place("/samplers/" + std::to_string(number));
    ref.wrap_s = wrap_mode(sampler.wrapS, place + "/wrapS");
    ref.wrap_t = wrap_mode(sampler.wrapT, place + "/wrapT");
    ref.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  if (const json* transform = find_extension(info, "KHR_texture_transform")) {
    ref.uv_transform = transform_matrix(*transform);
    ref.uv_set = transform->value("texCoord", ref.uv_set);
  }
  return ref;
}

void GltfMaterialObject::texture(const char* name, TextureRef& slot) const {
  if (const json* info = texture_info(name)) slot = texture_ref(*info, name);
}

void GltfMaterialObject::normal_texture(const char* name, TextureRef& slot, float& scale) const {
  texture(name, slot);
  if (const json* info = find_member(object_, name)) scale = info->value("scale", scale);
}

std::optional<GltfMaterialObject> GltfMaterialObject::member(const char* name) const {
  const json* found = find_member(object_, name);
  if (!found) return std::nullopt;
  return GltfMaterialObject(file_, *found, pointer_ + "/" + name);
}

std::optional<GltfMaterialObject> GltfMaterialObject::extension(const char* name) const {
  const json* found = find_extension(object_, name);
  if (!found) return std::nullopt;
  return GltfMaterialObject(file_, *found, pointer_ + "/extensions/" + name);
}

}  // namespace emberline
