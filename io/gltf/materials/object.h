// Reads a material's JSON object, or one inside it, member by member: factors, colours, texture
// slots. Absent members leave the value unchanged, so defaults are those of MaterialDescription.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Clamped members, for one combined warning.
struct ClampedFactors {
  struct List {
    static constexpr size_t kMaxNamed = 8;  // listed by name: a file may have any number
    std::vector<std::string> named;         // with their values
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

// Invalid values throw InputError (file, JSON pointer, what was expected). In an extension that the
// file does not require, or with GltfOptions::lenient, they cause a warning and leave the value
// unchanged.
class GltfMaterialObject {
 public:
  // `file` and `object` must outlive this. check_schema has checked the types.
  GltfMaterialObject(const MaterialFile& file, const nlohmann::json& object, std::string pointer)
      : file_(file), object_(object), pointer_(std::move(pointer)) {}

  // Clamp to [0, 1] and record clamped members in ClampedFactors.
  void unit_factor(const char* name, float& value) const;
  void unit_factors(const char* name, Rgb& value) const;
  void unit_factors(const char* name, Rgb& value, float& alpha) const;  // four numbers
  // Clamps to [0, inf).
  void non_negative(const char* name, Rgb& value) const;
  void number(const char* name, float& value, const ValidNumbers& valid) const;

  // Whether the slot has a texture. A texture index that does not exist is an invalid value.
  bool has_texture(const char* name) const { return texture_info(name) != nullptr; }
  void texture(const char* name, TextureRef& slot) const;
  // Also reads the "scale" of a normal map.
  void normal_texture(const char* name, TextureRef& slot, float& scale) const;

  std::optional<GltfMaterialObject> member(const char* name) const;
  std::optional<GltfMaterialObject> extension(const char* name) const;

  // Adds to the file's coverage report.
  void report_ignored(const std::string& what) const;
  // Reports a faulty member: throws, or warns in an optional extension.
  void fail(const std::string& name, const std::string& message) const;
  // The member's place, for messages.
  std::string place(const std::string& name) const {
    return file_.document.place(pointer_ + "/" + name);
  }

 private:
  void clamp(const char* name, std::span<float> values, double max_value) const;
  const nlohmann::json* texture_info(const char* name) const;
  TextureRef texture_ref(const nlohmann::json& info, const char* name) const;
  // Throws, or warns and says what is used `fallback`.
  void reject_value(const std::string& name, const std::string& message,
                    const std::string& fallback) const;

  const MaterialFile& file_;
  const nlohmann::json& object_;
  std::string pointer_;
  bool optional_ = false;  // inside an extension that the file does not require
};

// Material extensions, implemented in layers.cpp.
inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// Reads all KHR_materials_* that change scattering, except specular-glossiness. An unlit material
// must not have them; they are then reported as ignored. With KHR_materials_pbrSpecularGlossiness,
// which defines its own index of refraction and specular colour, only the layers on top are read.
void read_material_layers(const GltfMaterialObject& object, MaterialDescription& material);

// Reads KHR_materials_pbrSpecularGlossiness, which replaces pbrMetallicRoughness. It equals the
// non-metallic material with index 0 of KHR_materials_ior and the colour of KHR_materials_specular
// ("Conversions").
void read_specular_glossiness(const GltfMaterialObject& object, MaterialDescription& material);

}  // namespace emberline
