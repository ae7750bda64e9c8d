#include "io/gltf/materials/images.h"

#include <exception>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>

#include "io/gltf/document/uri.h"
#include "io/gltf/materials/material.h"
#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

constexpr const char* kBasisu = "KHR_texture_basisu";
constexpr const char* kWebp = "EXT_texture_webp";

DecodedImage decode(const GltfDocument& document, int index, bool lenient) {
  const json& object = document.json->at("images")[size_t(index)];
  const std::string pointer = "/images/" + std::to_string(index);
  const std::string place = document.place(pointer);
  document.faults->require(pointer);
  std::string name = object.value("name", "");
  MemoryReservation memory(document.progress->budget(), MemoryPart::kFile);
  std::vector<uint8_t> owned;
  ByteSpan encoded;
  if (const json* view = find_member(object, "bufferView")) {
    encoded = document.bytes(view->get<int>());
  } else if (const json* uri_member = find_member(object, "uri")) {
    const std::string& uri = uri_member->get_ref<const std::string&>();
    const std::string uri_place = place + "/uri";
    if (is_data_uri(uri)) {
      owned = decode_data_uri(uri, uri_place);
    } else {
      const InputFile file = document.open_resource(uri, uri_place);
      memory.add(file.size(), uri_place);
      owned = file.read_all(*document.progress);
      name = uri;
    }
    encoded = owned;
  } else {
    throw InputError(place, "the image has neither a uri nor a bufferView");
  }
  const std::string label = name.empty() ? place : place + " (" + shortened(name) + ")";
  DecodedImage decoded = decode_image(encoded, label, lenient, *document.progress);
  // Nothing else refers to the image yet, so it may be changed.
  std::const_pointer_cast<Image>(decoded.image)->name = name.empty() ? "#" + pointer : name;
  return decoded;
}

std::shared_ptr<const Image> make_uniform_image(const std::string& name,
                                                std::array<uint8_t, 3> rgb) {
  auto image = std::make_shared<Image>();
  image->name = name;
  image->width = image->height = 1;
  image->channels = 3;
  for (const uint8_t value : rgb) image->texels.push_back(std::byte(value));
  return image;
}

// Replaces failed images by one texel of the given colour. This is for slots in which white is not
// neutral.
void replace_failed(SceneDescription& scene, const std::vector<const GltfImage*>& images,
                    const char* name, std::array<uint8_t, 3> rgb,
                    std::initializer_list<TextureRef MaterialDescription::*> slots) {
  int replacement = -1;
  for (MaterialDescription& material : scene.materials) {
    for (const auto slot : slots) {
      int& image = (material.*slot).image;
      if (image < 0 || size_t(image) >= images.size() || !images[size_t(image)]->error) continue;
      if (replacement < 0) {
        replacement = int(scene.images.size());
        scene.images.push_back(make_uniform_image(name, rgb));
      }
      image = replacement;
    }
  }
}

// Returns the KTX 2 and WebP images whose glTF extension is optional, each with the other images of
// its texture.
std::map<int, std::vector<int>> fallback_images(const GltfDocument& document) {
  std::map<int, std::vector<int>> fallbacks;
  for (const json& texture : document.array("textures")) {
    const std::vector<int> sources = texture_sources(texture);
    if (sources.size() < 2) continue;
    const char* first = find_extension(texture, kBasisu) ? kBasisu : kWebp;
    if (document.requires_extension(first)) continue;
    fallbacks.try_emplace(sources[0], sources.begin() + 1, sources.end());
  }
  return fallbacks;
}

// Decodes the image. If that fails, decodes the first of `others` that can be decoded, and sets
// `fault` to the image's error. If none can be decoded, throws that error.
DecodedImage decode_with_fallbacks(const GltfDocument& document, int image,
                                   const std::vector<int>& others, bool lenient,
                                   std::string& fault) {
  try {
    return decode(document, image, lenient);
  } catch (const InputError& error) {
    GltfFaults::rethrow_limit_error(error);
    for (const int other : others) {
      try {
        DecodedImage decoded = decode(document, other, lenient);
        fault = error.what();
        return decoded;
      } catch (const InputError& fallback_error) {
        GltfFaults::rethrow_limit_error(fallback_error);
      }
    }
    throw;
  }
}

// Warns about images whose stated transfer function (sRGB or linear) does not fit their use.
// KHR_texture_basisu requires that it fits. As for all images, the use decides (glTF 2.0, section
// 3.9.2).
void warn_about_transfer(const SceneDescription& scene, const std::vector<const GltfImage*>& images,
                         const std::string& file) {
  std::vector<char> warned(images.size(), 0);
  const auto expect = [&](const TextureRef& slot, const char* transfer) {
    if (slot.image < 0 || warned[size_t(slot.image)]) return;
    const DecodedImage& image = images[size_t(slot.image)]->decoded;
    if (image.transfer.empty() || image.transfer == transfer) return;
    warned[size_t(slot.image)] = 1;
    log_warning(file + ": " + shortened(image.image->name) + " is marked as " + image.transfer +
                ", but is used where " + transfer + " is expected; the marking is ignored");
  };
  // These lists leave out slots that read only alpha, which is always linear.
  using Material = MaterialDescription;
  constexpr TextureRef Material::*kColours[] = {
      &Material::base_color_texture, &Material::emission_texture, &Material::specular_color_texture,
      &Material::diffuse_transmission_color_texture, &Material::sheen_color_texture};
  constexpr TextureRef Material::*kData[] = {
      &Material::normal_texture,           &Material::metallic_roughness_texture,
      &Material::transmission_texture,     &Material::anisotropy_texture,
      &Material::iridescence_texture,      &Material::iridescence_thickness_texture,
      &Material::clearcoat_texture,        &Material::clearcoat_roughness_texture,
      &Material::clearcoat_normal_texture,
  };
  for (const MaterialDescription& material : scene.materials) {
    for (const auto slot : kColours) expect(material.*slot, "sRGB");
    for (const auto slot : kData) expect(material.*slot, "linear");
  }
}

// Decodes the wanted images that are not in `cached`, adds them to `cached`, and returns all wanted
// images.
std::vector<const GltfImage*> decode_images(const GltfDocument& document,
                                            const GltfOptions& options,
                                            const std::vector<int>& wanted,
                                            std::map<int, GltfImage>& cached, TextureStore& store) {
  std::vector<int> uncached;
  for (const int image : wanted) {
    if (!cached.contains(image)) uncached.push_back(image);
  }
  document.progress->begin(LoadStage::kImages, uncached.size());
  std::vector<GltfImage> images(uncached.size());
  const std::map<int, std::vector<int>> fallbacks = fallback_images(document);
  const std::vector<std::exception_ptr> errors = document.try_each(uncached.size(), [&](size_t i) {
    const auto found = fallbacks.find(uncached[i]);
    const std::vector<int> others = found == fallbacks.end() ? std::vector<int>() : found->second;
    images[i].decoded =
        decode_with_fallbacks(document, uncached[i], others, options.lenient, images[i].fault);
    // Nothing else refers to the image yet, so it may be changed.
    store.add(std::const_pointer_cast<Image>(images[i].decoded.image), *document.progress);
  });
  store.finish_load();
  for (size_t i = 0; i < uncached.size(); ++i) {
    if (errors[i] && !options.lenient) std::rethrow_exception(errors[i]);
    images[i].error = errors[i];
  }
  for (size_t i = 0; i < uncached.size(); ++i) cached.emplace(uncached[i], std::move(images[i]));
  std::vector<const GltfImage*> result;
  for (const int image : wanted) result.push_back(&cached.at(image));
  return result;
}

}  // namespace

std::vector<int> texture_sources(const json& texture) {
  std::vector<int> sources;
  for (const char* name : {kBasisu, kWebp}) {
    if (const json* extension = find_extension(texture, name)) {
      sources.push_back(extension->at("source").get<int>());
    }
  }
  if (const json* source = find_member(texture, "source")) sources.push_back(source->get<int>());
  return sources;
}

void load_images(const GltfDocument& document, const GltfOptions& options,
                 std::map<int, GltfImage>& cached, TextureStore& store, SceneDescription& scene) {
  std::map<int, int> numbers;  // index of the glTF image -> index in scene.images
  std::vector<int> wanted;
  std::vector<char> is_used(scene.materials.size(), 0);
  for (const MeshDescription& mesh : scene.meshes) {
    if (mesh.material >= 0) is_used[size_t(mesh.material)] = 1;
    for (const VariantMaterial& other : mesh.variant_materials) is_used[size_t(other.material)] = 1;
  }
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    for (TextureRef* slot : texture_slots(scene.materials[m])) {
      if (!is_used[m]) *slot = TextureRef();
      if (slot->image < 0) continue;
      const auto [entry, is_new] = numbers.try_emplace(slot->image, int(wanted.size()));
      if (is_new) wanted.push_back(slot->image);
      slot->image = entry->second;
    }
  }

  const std::vector<const GltfImage*> images =
      decode_images(document, options, wanted, cached, store);
  for (size_t i = 0; i < wanted.size(); ++i) {
    const GltfImage& image = *images[i];
    scene.repairs.non_finite_texels += image.decoded.non_finite;
    if (!image.fault.empty()) {
      log_warning(image.fault + "; the texture's other image is used");
    }
    if (!image.error) {
      if (image.decoded.truncated) {
        log_warning(document.place("/images/" + std::to_string(wanted[i])) + " (" +
                    shortened(image.decoded.image->name) +
                    "): the JPEG is truncated; the missing part is grey");
      }
      scene.images.push_back(image.decoded.image);
      continue;
    }
    try {
      std::rethrow_exception(image.error);
    } catch (const InputError& error) {
      log_warning(std::string(error.what()) + "; a neutral colour is used");
    }
    ++scene.repairs.replaced_images;
    scene.images.push_back(
        make_uniform_image("replaced image " + std::to_string(wanted[i]), {255, 255, 255}));
  }
  warn_about_transfer(scene, images, document.file);
  // Files usually encode a component of zero as 128, although (128/255) * 2 - 1 is 0.004.
  replace_failed(
      scene, images, "replaced normal map", {128, 128, 255},
      {&MaterialDescription::normal_texture, &MaterialDescription::clearcoat_normal_texture});
  replace_failed(scene, images, "replaced directions", {255, 128, 255},
                 {&MaterialDescription::anisotropy_texture});
  if (scene.repairs.non_finite_texels > 0) {
    log_warning(document.file + ": " + std::to_string(scene.repairs.non_finite_texels) +
                " texels were not finite; 0 is used instead");
  }
}

}  // namespace emberline
