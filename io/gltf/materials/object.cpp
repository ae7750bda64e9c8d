#include "io/gltf/materials/object.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "io/gltf/document/extensions.h"
#include "io/gltf/document/tiny_gltf_renamed.h"
#include "io/gltf/materials/images.h"
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

// Computes the matrix of KHR_texture_transform: uv' = translation * rotation * scale * uv. The
// rotation is as in the extension's README (counter-clockwise in a space with v downwards).
std::array<float, 6> transform_matrix(const json& extension) {
  const std::vector<double> offset = extension.value("offset", std::vector<double>{0.0, 0.0});
  const std::vector<double> scale = extension.value("scale", std::vector<double>{1.0, 1.0});
  const double angle = extension.value("rotation", 0.0);
  const double c = std::cos(angle), s = std::sin(angle);
  return {float(c * scale[0]),  float(s * scale[1]), float(offset[0]),
          float(-s * scale[0]), float(c * scale[1]), float(offset[1])};
}

}  // namespace

void GltfMaterialObject::fail(const std::string& name, const std::string& message) const {
  const InputError fault(place(name), message);
  if (!optional_) throw InputError(fault);
  file_.document.faults->note_defaulted(pointer_ + "/" + name, fault);
}

void GltfMaterialObject::reject_value(const std::string& name, const std::string& message,
                                      const std::string& fallback) const {
  if (!file_.options.lenient) return fail(name, message);
  log_warning(place(name) + ": " + message + "; " + fallback);
}

void GltfMaterialObject::report_ignored(const std::string& what) const {
  emberline::report_ignored(file_.document.file, what, file_.coverage);
}

void GltfMaterialObject::clamp(const char* name, std::span<float> values, double max_value) const {
  const json* found = find_member(object_, name);
  if (!found) return;
  bool fits = true;
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = (found->is_array() ? found->at(i) : *found).get<double>();
    values[i] = float(std::clamp(value, 0.0, max_value));
    fits = fits && value >= 0.0 && value <= max_value;
  }
  if (fits) return;
  ClampedFactors::List& list =
      std::isinf(max_value) ? file_.clamped.colors : file_.clamped.unit_factors;
  if (list.named.size() == list.kMaxNamed) {
    ++list.more;
    return;
  }
  const size_t index = std::stoul(pointer_.substr(pointer_.find('/', 1) + 1));
  const std::string& material = file_.document.model->materials[index].name;
  list.named.push_back(fmt::format("{}/{}{} is {}", pointer_, name,
                                   material.empty() ? "" : " of '" + shortened(material) + "'",
                                   shortened(found->dump())));
}

void GltfMaterialObject::unit_factor(const char* name, float& value) const {
  clamp(name, {&value, 1}, 1.0);
}

void GltfMaterialObject::unit_factors(const char* name, Rgb& value) const {
  clamp(name, {&value[0], 3}, 1.0);
}

void GltfMaterialObject::unit_factors(const char* name, Rgb& value, float& alpha) const {
  float all[] = {value[0], value[1], value[2], alpha};
  clamp(name, all, 1.0);
  for (int c = 0; c < 3; ++c) value[c] = all[c];
  alpha = all[3];
}

void GltfMaterialObject::non_negative(const char* name, Rgb& value) const {
  clamp(name, {&value[0], 3}, std::numeric_limits<double>::infinity());
}

void GltfMaterialObject::number(const char* name, float& value, const ValidNumbers& valid) const {
  const json* found = find_member(object_, name);
  if (!found) return;
  const auto read = float(found->get<double>());
  if (std::isfinite(read) && valid.accepts(read)) {
    value = read;
    return;
  }
  reject_value(name, fmt::format("expected {}, found {}", valid.expected, shortened(found->dump())),
               fmt::format("the default, {}, is used", value));
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
  reject_value(
      name + std::string("/index"),
      fmt::format("index {} is out of range: the file has {} textures", index.dump(), count),
      "no texture is used");
  return nullptr;
}

TextureRef GltfMaterialObject::texture_ref(const json& info, const char* name) const {
  TextureRef ref;
  const GltfDocument& document = file_.document;
  const size_t index = info.at("index").get<size_t>();
  const std::vector<int> sources = texture_sources(document.json->at("textures")[index]);
  if (sources.empty() && file_.options.lenient) {
    report_ignored("a texture without a PNG, JPEG, WebP or KTX 2 image");
    return ref;
  }
  if (sources.empty()) {
    throw InputError(document.place("/textures/" + std::to_string(index)),
                     "the texture of " + pointer_ + "/" + name +
                         " has no image in a supported format (PNG, JPEG, WebP, KTX 2)");
  }
  ref.image = sources[0];
  ref.uv_set = info.value("texCoord", 0);
  const int number = file_.document.model->textures[index].sampler;
  if (number >= 0) {
    const tinygltf::Sampler& sampler = file_.document.model->samplers[size_t(number)];
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
  GltfMaterialObject member(file_, *found, pointer_ + "/" + name);
  member.optional_ = optional_;
  return member;
}

std::optional<GltfMaterialObject> GltfMaterialObject::extension(const char* name) const {
  const json* found = find_extension(object_, name);
  if (!found) return std::nullopt;
  GltfMaterialObject extension(file_, *found, pointer_ + "/extensions/" + name);
  extension.optional_ = !file_.document.requires_extension(name);
  return extension;
}

}  // namespace emberline
