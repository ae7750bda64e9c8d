// A material's JSON object, or one inside it, read member by member: factors, colours, texture
// slots. Every reader leaves its value as it is where the member is absent, so that the defaults
// are those of MaterialDescription.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/gltf/document/document.h"
#include "io/gltf/gltf_file.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// The members that had to be clamped, to be warned of together.
struct ClampedFactors {
  struct List {
    static constexpr size_t kMost = 8;  // that are named: a file may have any number
    std::vector<std::string> named;     // with the numbers that the file has
    uint64_t more = 0;
  };
  List shares, colors;  // to [0, 1]; to [0, inf)
};

// What all materials of a file are read with.
struct MaterialFile {
  const GltfDocument& document;
  const GltfOptions& options;
  CoverageReport& coverage;
  ClampedFactors& clamped;
};

// Which numbers a property takes, finite ones at most, and how a message calls them.
struct ValidNumbers {
  bool (*contain)(float);
  const char* expected;
};
inline constexpr ValidNumbers kNotNegative = {[](float x) { return x >= 0.0f; },
                                              "a number of at least 0"};

// A value that cannot be throws InputError (file, JSON pointer, what is expected); in an extension
// that the file does not require, and with GltfOptions::lenient, it is warned of, and the value
// stays as it was.
class GltfMaterialObject {
 public:
  // `file` and `object` have to outlive this. check_schema has seen the types.
  GltfMaterialObject(const MaterialFile& file, const nlohmann::json& object, std::string pointer)
      : file_(file), object_(object), pointer_(std::move(pointer)) {}

  // Clamped to [0, 1], and kept in ClampedFactors if that changes it.
  void share(const char* name, float& value) const;
  void shares(const char* name, Rgb& value) const;
  void shares(const char* name, Rgb& value, float& alpha) const;  // four numbers
  // Clamped to [0, inf).
  void non_negative(const char* name, Rgb& value) const;
  void number(const char* name, float& value, const ValidNumbers& valid) const;

  // Whether the slot names a texture of the file. One that it has not is a value that cannot be.
  bool has_texture(const char* name) const { return texture_info(name) != nullptr; }
  void texture(const char* name, TextureRef& slot) const;
  // With the "scale" of a normal map.
  void normal_texture(const char* name, TextureRef& slot, float& scale) const;

  std::optional<GltfMaterialObject> member(const char* name) const;
  std::optional<GltfMaterialObject> extension(const char* name) const;

  // For the coverage report of the file.
  void report_ignored(const std::string& what) const;
  // What is wrong with a member: thrown, or a warning in an extension that is optional.
  void fail(const std::string& name, const std::string& message) const;
  // Of a member, for messages.
  std::string place(const std::string& name) const {
    return file_.document.place(pointer_ + "/" + name);
  }

 private:
  void clamp(const char* name, std::span<float> values, double most) const;
  const nlohmann::json* texture_info(const char* name) const;
  TextureRef texture_ref(const nlohmann::json& info, const char* name) const;
  // Throws, or warns that `instead` takes the place of what was found.
  void refuse(const std::string& name, const std::string& message,
              const std::string& instead) const;

  const MaterialFile& file_;
  const nlohmann::json& object_;
  std::string pointer_;
  bool optional_ = false;  // inside an extension that the file does not require
};

// The material extensions, in layers.cpp: what they say, into MaterialDescription.
inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";

// All of KHR_materials_* that change how a surface scatters, except the above. Not for an unlit
// material, which must not have them: they are then reported as ignored. Beside
// KHR_materials_pbrSpecularGlossiness, which must stand alone, the index of refraction and the
// specular colour are its own; what lies on top of it is honoured.
void read_material_layers(const GltfMaterialObject& object, MaterialDescription& material);

// KHR_materials_pbrSpecularGlossiness, in place of pbrMetallicRoughness. It is exactly the material
// without metal of KHR_materials_ior's index 0 and KHR_materials_specular's colour, "Conversions".
void read_specular_glossiness(const GltfMaterialObject& object, MaterialDescription& material);

}  // namespace emberline
