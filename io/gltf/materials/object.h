// Reads a material's JSON object, or an object inside it, member by member: factors, colours and
// texture slots. An absent member leaves the value unchanged, so MaterialDescription decides the
// default.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Members whose values were clamped. Each list causes one warning.
struct ClampedFactors {
  struct List {
    static constexpr size_t kMaxNamed = 8;  // the rest are only counted; a file may have any number
    std::vector<std::string> named;         // clamped members and their values
    uint64_t more = 0;
  };
  List unit_factors, colors;  // clamped to [0, 1] and to [0, inf)
};

// Shared state for reading all materials of a file.
struct MaterialFile {
  const GltfDocument& document;
  const GltfOptions& options;
  CoverageReport& coverage;
  ClampedFactors& clamped;
};

// A property's valid range and its description for messages. Infinity and NaN are never valid.
struct ValidNumbers {
  bool (*accepts)(float);
  const char* expected;
};
inline constexpr ValidNumbers kNotNegative = {[](float x) { return x >= 0.0f; },
                                              "a number of at least 0"};

// Invalid values throw InputError (file, JSON pointer, what was expected). With
// GltfOptions::lenient, or in an extension that the file does not require, they cause a warning
// instead and leave the value unchanged.
class GltfMaterialObject {
 public:
  // `file` and `object` must outlive this object. check_schema() has already checked the types.
  GltfMaterialObject(const MaterialFile& file, const nlohmann::json& object, std::string pointer)
      : file_(file), object_(object), pointer_(std::move(pointer)) {}

  // These functions clamp to [0, 1] and record clamped members in ClampedFactors.
  void unit_factor(const char* name, float& value) const;
  void unit_factors(const char* name, Rgb& value) const;
  void unit_factors(const char* name, Rgb& value, float& alpha) const;  // four numbers
  // Clamps to [0, inf), and records clamped members in ClampedFactors.
  void non_negative(const char* name, Rgb& value) const;
  void number(const char* name, float& value, const ValidNumbers& valid) const;

  // Whether the slot has a texture. A texture index that is out of range is an invalid value.
  bool has_texture(const char* name) const { return texture_info(name) != nullptr; }
  void texture(const char* name, TextureRef& slot) const;
  // Also reads the "scale" of a normal map.
  void normal_texture(const char* name, TextureRef& slot, float& scale) const;

  std::optional<GltfMaterialObject> member(const char* name) const;
  std::optional<GltfMaterialObject> extension(const char* name) const;

  // Adds a line to the file's coverage report.
  void report_ignored(const std::string& what) const;
  // Reports a faulty member: warns in an optional extension, and otherwise throws InputError.
  void fail(const std::string& name, const std::string& message) const;
  // Returns the place of the member `name`, for messages.
  std::string place(const std::string& name) const {
    return file_.document.place(pointer_ + "/" + name);
  }

 private:
  void clamp(const char* name, std::span<float> values, double max_value) const;
  const nlohmann::json* texture_info(const char* name) const;
  TextureRef texture_ref(const nlohmann::json& info, const char* name) const;
  // Throws or warns. The warning says that `fallback` is used instead.
  void reject_value(const std::string& name, const std::string& message,
                    const std::string& fallback) const;

  const MaterialFile& file_;
  const nlohmann::json& object_;
  std::string pointer_;
  bool optional_ = false;  // whether we are inside an extension that the file does not require
};

// Material extensions, implemented in layers.cpp.
inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// Reads all KHR_materials_* extensions that change scattering, except specular-glossiness. An unlit
// material must not have them; if it does, they are reported as ignored. Specular-glossiness
// defines its own index of refraction and specular colour, so KHR_materials_ior and
// KHR_materials_specular are not read together with it.
void read_material_layers(const GltfMaterialObject& object, MaterialDescription& material);

// Reads KHR_materials_pbrSpecularGlossiness, which replaces pbrMetallicRoughness. According to the
// extension's section "Conversions", such a material is equivalent to a non-metallic material with
// ior = 0 in KHR_materials_ior and with the specular colour in KHR_materials_specular.
void read_specular_glossiness(const GltfMaterialObject& object, MaterialDescription& material);

}  // namespace emberline
