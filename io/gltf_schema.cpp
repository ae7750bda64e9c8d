#include "io/gltf_schema.h"

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using nlohmann::json;

enum class Kind : uint8_t {
  kInteger,  // minimum..maximum
  kIndex,    // into the array `target`
  kNumber,   // minimum..maximum
  kNumbers,  // `count` numbers, any number of them when 0
  kBoolean,
  kString,
  kStrings,
  kIndices,    // array of indices into `target`
  kIndexMap,   // object: name -> index into `target` (any integer when null)
  kIndexMaps,  // array of those
  kObject,     // of `schema`
  kObjects,    // array of objects of `schema`
};

struct Property;
using Schema = std::span<const Property>;

struct Property {
  const char* name;
  Kind kind;
  bool required = false;
  double minimum = -FLT_MAX;
  double maximum = FLT_MAX;
  size_t count = 0;
  const char* target = nullptr;
  Schema schema;
};

constexpr double kLargestInteger = 0x1p53;  // beyond, JSON numbers stop being exact

constexpr Property integer(const char* name, double minimum = 0, double maximum = kLargestInteger) {
  return {name, Kind::kInteger, false, minimum, maximum, 0, nullptr, {}};
}
constexpr Property number(const char* name, double minimum = -FLT_MAX) {
  return {name, Kind::kNumber, false, minimum, FLT_MAX, 0, nullptr, {}};
}
// Any number: its range is the reader's affair, which may be lenient.
constexpr Property any_number(const char* name) {
  return {name, Kind::kNumber, false, -DBL_MAX, DBL_MAX, 0, nullptr, {}};
}
constexpr Property numbers(const char* name, size_t count) {
  return {name, Kind::kNumbers, false, -FLT_MAX, FLT_MAX, count, nullptr, {}};
}
constexpr Property plain(const char* name, Kind kind) {
  return {name, kind, false, 0, 0, 0, nullptr, {}};
}
constexpr Property boolean(const char* name) { return plain(name, Kind::kBoolean); }
constexpr Property string(const char* name) { return plain(name, Kind::kString); }
constexpr Property to(const char* name, Kind kind, const char* target) {
  return {name, kind, false, 0, 0, 0, target, {}};
}
constexpr Property index(const char* name, const char* target) {
  return to(name, Kind::kIndex, target);
}
constexpr Property object(const char* name, Schema schema) {
  return {name, Kind::kObject, false, 0, 0, 0, nullptr, schema};
}
constexpr Property objects(const char* name, Schema schema) {
  return {name, Kind::kObjects, false, 0, 0, 0, nullptr, schema};
}
constexpr Property required(Property property) {
  property.required = true;
  return property;
}

// The tables: specification chapter 5 and the extensions' own schemas.

constexpr Property kSparseIndices[] = {required(index("bufferView", "/bufferViews")),
                                       integer("byteOffset"), required(integer("componentType"))};
constexpr Property kSparseValues[] = {required(index("bufferView", "/bufferViews")),
                                      integer("byteOffset")};
constexpr Property kSparse[] = {required(integer("count")),
                                required(object("indices", kSparseIndices)),
                                required(object("values", kSparseValues))};
constexpr Property kAccessor[] = {index("bufferView", "/bufferViews"),
                                  integer("byteOffset"),
                                  required(integer("componentType")),
                                  boolean("normalized"),
                                  required(integer("count", 1)),
                                  required(string("type")),
                                  object("sparse", kSparse)};

constexpr Property kMeshoptView[] = {required(index("buffer", "/buffers")),
                                     integer("byteOffset"),
                                     required(integer("byteLength")),
                                     required(integer("byteStride", 1, 256)),
                                     required(integer("count", 1)),
                                     required(string("mode")),
                                     string("filter")};
constexpr Property kViewExtensions[] = {object("EXT_meshopt_compression", kMeshoptView),
                                        object("KHR_meshopt_compression", kMeshoptView)};
constexpr Property kBufferView[] = {
    required(index("buffer", "/buffers")), integer("byteOffset"), required(integer("byteLength")),
    integer("byteStride", 1, 65535), object("extensions", kViewExtensions)};
constexpr Property kMeshoptBuffer[] = {boolean("fallback")};
constexpr Property kBufferExtensions[] = {object("EXT_meshopt_compression", kMeshoptBuffer),
                                          object("KHR_meshopt_compression", kMeshoptBuffer)};
constexpr Property kBuffer[] = {string("uri"), required(integer("byteLength")),
                                object("extensions", kBufferExtensions)};

constexpr Property kImage[] = {string("uri"), index("bufferView", "/bufferViews"),
                               string("mimeType"), string("name")};
constexpr Property kSampler[] = {integer("magFilter"), integer("minFilter"), integer("wrapS"),
                                 integer("wrapT")};
constexpr Property kTextureSource[] = {required(index("source", "/images"))};
constexpr Property kTextureExtensions[] = {object("EXT_texture_webp", kTextureSource),
                                           object("KHR_texture_basisu", kTextureSource)};
constexpr Property kTexture[] = {index("sampler", "/samplers"), index("source", "/images"),
                                 object("extensions", kTextureExtensions)};

// Sixteen UV sets: chosen by us; no tool is known to write more than eight.
constexpr Property kTextureTransform[] = {numbers("offset", 2), number("rotation"),
                                          numbers("scale", 2), integer("texCoord", 0, 15)};
constexpr Property kTextureInfoExtensions[] = {object("KHR_texture_transform", kTextureTransform)};
// Whether the file has the texture is the reader's affair, which may be lenient.
constexpr Property kTextureInfo[] = {required(integer("index")), integer("texCoord", 0, 15),
                                     number("scale"), number("strength"),
                                     object("extensions", kTextureInfoExtensions)};
constexpr Property kMetallicRoughness[] = {numbers("baseColorFactor", 4),
                                           object("baseColorTexture", kTextureInfo),
                                           number("metallicFactor"), number("roughnessFactor"),
                                           object("metallicRoughnessTexture", kTextureInfo)};
constexpr Property kEmissiveStrength[] = {number("emissiveStrength", 0)};
constexpr Property kSpecularGlossiness[] = {
    numbers("diffuseFactor", 4), object("diffuseTexture", kTextureInfo),
    numbers("specularFactor", 3), number("glossinessFactor"),
    object("specularGlossinessTexture", kTextureInfo)};
constexpr Property kIor[] = {any_number("ior")};
constexpr Property kSpecular[] = {number("specularFactor"), object("specularTexture", kTextureInfo),
                                  numbers("specularColorFactor", 3),
                                  object("specularColorTexture", kTextureInfo)};
constexpr Property kTransmission[] = {number("transmissionFactor"),
                                      object("transmissionTexture", kTextureInfo)};
constexpr Property kVolume[] = {any_number("thicknessFactor"),
                                object("thicknessTexture", kTextureInfo),
                                any_number("attenuationDistance"), numbers("attenuationColor", 3)};
constexpr Property kDispersion[] = {any_number("dispersion")};
constexpr Property kDiffuseTransmission[] = {
    number("diffuseTransmissionFactor"), object("diffuseTransmissionTexture", kTextureInfo),
    numbers("diffuseTransmissionColorFactor", 3),
    object("diffuseTransmissionColorTexture", kTextureInfo)};
constexpr Property kAnisotropy[] = {number("anisotropyStrength"), any_number("anisotropyRotation"),
                                    object("anisotropyTexture", kTextureInfo)};
constexpr Property kIridescence[] = {number("iridescenceFactor"),
                                     object("iridescenceTexture", kTextureInfo),
                                     any_number("iridescenceIor"),
                                     any_number("iridescenceThicknessMinimum"),
                                     any_number("iridescenceThicknessMaximum"),
                                     object("iridescenceThicknessTexture", kTextureInfo)};
constexpr Property kSheen[] = {
    numbers("sheenColorFactor", 3), object("sheenColorTexture", kTextureInfo),
    number("sheenRoughnessFactor"), object("sheenRoughnessTexture", kTextureInfo)};
constexpr Property kClearcoat[] = {
    number("clearcoatFactor"), object("clearcoatTexture", kTextureInfo),
    number("clearcoatRoughnessFactor"), object("clearcoatRoughnessTexture", kTextureInfo),
    object("clearcoatNormalTexture", kTextureInfo)};
constexpr Property kMaterialExtensions[] = {
    object("KHR_materials_anisotropy", kAnisotropy),
    object("KHR_materials_clearcoat", kClearcoat),
    object("KHR_materials_diffuse_transmission", kDiffuseTransmission),
    object("KHR_materials_dispersion", kDispersion),
    object("KHR_materials_emissive_strength", kEmissiveStrength),
    object("KHR_materials_ior", kIor),
    object("KHR_materials_iridescence", kIridescence),
    object("KHR_materials_pbrSpecularGlossiness", kSpecularGlossiness),
    object("KHR_materials_sheen", kSheen),
    object("KHR_materials_specular", kSpecular),
    object("KHR_materials_transmission", kTransmission),
    object("KHR_materials_unlit", Schema()),
    object("KHR_materials_volume", kVolume)};
constexpr Property kMaterial[] = {string("name"),
                                  object("pbrMetallicRoughness", kMetallicRoughness),
                                  object("normalTexture", kTextureInfo),
                                  object("occlusionTexture", kTextureInfo),
                                  object("emissiveTexture", kTextureInfo),
                                  numbers("emissiveFactor", 3),
                                  string("alphaMode"),
                                  number("alphaCutoff", 0),
                                  boolean("doubleSided"),
                                  object("extensions", kMaterialExtensions)};

constexpr Property kDraco[] = {required(index("bufferView", "/bufferViews")),
                               required(to("attributes", Kind::kIndexMap, nullptr))};
constexpr Property kVariantMapping[] = {
    required(index("material", "/materials")),
    required(to("variants", Kind::kIndices, "/extensions/KHR_materials_variants/variants"))};
constexpr Property kVariantMappings[] = {required(objects("mappings", kVariantMapping))};
constexpr Property kPrimitiveExtensions[] = {object("KHR_draco_mesh_compression", kDraco),
                                             object("KHR_materials_variants", kVariantMappings)};
constexpr Property kPrimitive[] = {required(to("attributes", Kind::kIndexMap, "/accessors")),
                                   index("indices", "/accessors"),
                                   index("material", "/materials"),
                                   integer("mode", 0, 6),
                                   to("targets", Kind::kIndexMaps, "/accessors"),
                                   object("extensions", kPrimitiveExtensions)};
constexpr Property kMesh[] = {string("name"), required(objects("primitives", kPrimitive)),
                              numbers("weights", 0)};

constexpr Property kNodeLight[] = {
    required(index("light", "/extensions/KHR_lights_punctual/lights"))};
constexpr Property kNodeInstancing[] = {required(to("attributes", Kind::kIndexMap, "/accessors"))};
constexpr Property kNodeExtensions[] = {object("KHR_lights_punctual", kNodeLight),
                                        object("EXT_mesh_gpu_instancing", kNodeInstancing)};
constexpr Property kNode[] = {string("name"),
                              to("children", Kind::kIndices, "/nodes"),
                              index("mesh", "/meshes"),
                              index("camera", "/cameras"),
                              index("skin", "/skins"),
                              numbers("matrix", 16),
                              numbers("translation", 3),
                              numbers("rotation", 4),
                              numbers("scale", 3),
                              numbers("weights", 0),
                              object("extensions", kNodeExtensions)};
constexpr Property kScene[] = {string("name"), to("nodes", Kind::kIndices, "/nodes")};
constexpr Property kSkin[] = {index("inverseBindMatrices", "/accessors"),
                              index("skeleton", "/nodes"),
                              required(to("joints", Kind::kIndices, "/nodes"))};

constexpr Property kPerspective[] = {required(number("yfov")), required(number("znear")),
                                     number("aspectRatio"), number("zfar")};
constexpr Property kOrthographic[] = {required(number("xmag")), required(number("ymag")),
                                      required(number("znear")), required(number("zfar"))};
constexpr Property kCamera[] = {string("name"), required(string("type")),
                                object("perspective", kPerspective),
                                object("orthographic", kOrthographic)};
constexpr Property kSpot[] = {number("innerConeAngle"), number("outerConeAngle")};
constexpr Property kLight[] = {string("name"),  numbers("color", 3),      number("intensity", 0),
                               number("range"), required(string("type")), object("spot", kSpot)};
constexpr Property kLights[] = {required(objects("lights", kLight))};
constexpr Property kVariant[] = {required(string("name"))};
constexpr Property kVariants[] = {required(objects("variants", kVariant))};
constexpr Property kRootExtensions[] = {object("KHR_lights_punctual", kLights),
                                        object("KHR_materials_variants", kVariants)};

constexpr Property kAsset[] = {required(string("version")), string("minVersion"),
                               string("generator")};
constexpr Property kAnimation[] = {string("name")};
constexpr Property kRoot[] = {required(object("asset", kAsset)),
                              index("scene", "/scenes"),
                              plain("extensionsUsed", Kind::kStrings),
                              plain("extensionsRequired", Kind::kStrings),
                              objects("accessors", kAccessor),
                              objects("animations", kAnimation),
                              objects("bufferViews", kBufferView),
                              objects("buffers", kBuffer),
                              objects("cameras", kCamera),
                              objects("images", kImage),
                              objects("materials", kMaterial),
                              objects("meshes", kMesh),
                              objects("nodes", kNode),
                              objects("samplers", kSampler),
                              objects("scenes", kScene),
                              objects("skins", kSkin),
                              objects("textures", kTexture),
                              object("extensions", kRootExtensions)};

class Checker {
 public:
  Checker(json& root, const std::string& file) : root_(root), file_(file) {}

  // The recursion is as deep as the tables nest.
  void check_object(json& value, Schema schema) {
    if (!value.is_object()) fail_type("an object", value);
    for (const Property& property : schema) {
      const auto member = value.find(property.name);
      if (member == value.end()) {
        if (property.required)
          fail(std::string("the required member \"") + property.name + "\" is missing");
        continue;
      }
      const Step step(pointer_, property.name);
      check_property(*member, property);
    }
  }

 private:
  // Appends to the JSON pointer for as long as it lives.
  class Step {
   public:
    Step(json::json_pointer& pointer, std::string name) : pointer_(pointer) {
      pointer_.push_back(std::move(name));
    }
    ~Step() { pointer_.pop_back(); }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    json::json_pointer& pointer_;
  };

  [[noreturn]] void fail(const std::string& message) const {
    throw InputError(file_ + (pointer_.empty() ? "" : "#" + shortened(pointer_.to_string())),
                     message);
  }
  [[noreturn]] void fail_type(const std::string& expected, const json& found) const {
    const bool shows = found.is_number() || found.is_string() || found.is_boolean();
    fail("expected " + expected + ", found " +
         (shows ? shortened(found.dump(-1, ' ', true)) : std::string(found.type_name())));
  }

  template <class CheckElement>
  void check_array(json& value, const CheckElement& check_element) {
    if (!value.is_array()) fail_type("an array", value);
    size_t i = 0;
    for (json& element : value) {
      const Step step(pointer_, std::to_string(i++));
      check_element(element);
    }
  }

  void check_integer(json& value, double minimum, double maximum) {
    const double number = value.is_number() ? value.get<double>() : -1.0;
    if (!value.is_number() || number != std::floor(number) || std::abs(number) > kLargestInteger) {
      fail_type("a whole number", value);
    }
    if (number < minimum || number > maximum) {
      fail("expected a whole number from " + std::to_string(int64_t(minimum)) + " to " +
           std::to_string(int64_t(maximum)) + ", found " + value.dump());
    }
    if (value.is_number_float()) value = int64_t(number);
  }

  void check_index(json& value, const char* target) {
    if (!target) return check_integer(value, 0, kLargestInteger);
    const json::json_pointer pointer(target);
    size_t count = 0;
    if (root_.contains(pointer) && root_.at(pointer).is_array()) count = root_.at(pointer).size();
    const double number = value.is_number() ? value.get<double>() : -1.0;
    if (!value.is_number() || number != std::floor(number) || number < 0) {
      fail_type("an index (a whole number from 0)", value);
    }
    if (!(number < double(count))) {
      fail("index " + value.dump() + " is out of range: the file has " + std::to_string(count) +
           " " + pointer.back());
    }
    if (value.is_number_float()) value = int64_t(number);
  }

  void check_number(const json& value, double minimum, double maximum) {
    if (!value.is_number()) fail_type("a number", value);
    const double number = value.get<double>();
    if (!std::isfinite(number) || number < minimum || number > maximum) {
      fail("the number " + value.dump() + " is out of range");
    }
  }

  void check_index_map(json& value, const char* target) {
    if (!value.is_object()) fail_type("an object", value);
    for (auto& [name, element] : value.items()) {
      const Step step(pointer_, name);
      check_index(element, target);
    }
  }

  void check_property(json& value, const Property& p) {
    switch (p.kind) {
      case Kind::kInteger:
        return check_integer(value, p.minimum, p.maximum);
      case Kind::kIndex:
        return check_index(value, p.target);
      case Kind::kNumber:
        return check_number(value, p.minimum, p.maximum);
      case Kind::kNumbers:
        check_array(value, [&](json& e) { check_number(e, p.minimum, p.maximum); });
        if (p.count > 0 && value.size() != p.count) {
          fail("expected " + std::to_string(p.count) + " numbers, found " +
               std::to_string(value.size()));
        }
        return;
      case Kind::kBoolean:
        if (!value.is_boolean()) fail_type("true or false", value);
        return;
      case Kind::kString:
        if (!value.is_string()) fail_type("a string", value);
        return;
      case Kind::kStrings:
        return check_array(value, [&](json& e) {
          if (!e.is_string()) fail_type("a string", e);
        });
      case Kind::kIndices:
        return check_array(value, [&](json& e) { check_index(e, p.target); });
      case Kind::kIndexMap:
        return check_index_map(value, p.target);
      case Kind::kIndexMaps:
        return check_array(value, [&](json& e) { check_index_map(e, p.target); });
      case Kind::kObject:
        return check_object(value, p.schema);
      case Kind::kObjects:
        return check_array(value, [&](json& e) { check_object(e, p.schema); });
    }
  }

  json& root_;
  const std::string& file_;
  json::json_pointer pointer_;
};

}  // namespace

void check_schema(json& root, const std::string& file) {
  Checker(root, file).check_object(root, kRoot);
}

}  // namespace emberline
