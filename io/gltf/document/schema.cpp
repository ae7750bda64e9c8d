#include "io/gltf/document/schema.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/gltf/geometry/node_objects.h"
#include "io/json/schema_checker.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

using namespace schema;

// These tables follow chapter 5 of the specification and the schemas of the extensions.

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
                               defaultable(string("mimeType")), name()};
constexpr Property kSampler[] = {integer("magFilter"), integer("minFilter"), integer("wrapS"),
                                 integer("wrapT")};
constexpr Property kTextureSource[] = {required(index("source", "/images"))};
constexpr Property kTextureExtensions[] = {object("EXT_texture_webp", kTextureSource),
                                           object("KHR_texture_basisu", kTextureSource)};
constexpr Property kTexture[] = {propagating(index("sampler", "/samplers")),
                                 index("source", "/images"),
                                 object("extensions", kTextureExtensions)};

// The limit of sixteen UV sets is our choice. No known tool writes more than eight.
constexpr Property kTextureTransform[] = {numbers("offset", 2), number("rotation"),
                                          numbers("scale", 2), integer("texCoord", 0, 15)};
constexpr Property kTextureInfoExtensions[] = {object("KHR_texture_transform", kTextureTransform)};
// GltfMaterialObject checks the index, since it may tolerate an invalid one (GltfOptions::lenient).
constexpr Property kTextureInfo[] = {required(integer("index")), integer("texCoord", 0, 15),
                                     number("scale"), defaultable(number("strength")),
                                     object("extensions", kTextureInfoExtensions)};
// A reference to a texture that may be missing, because it does not affect the picture.
constexpr Property kDefaultableTextureInfo[] = {
    required(propagating(index("index", "/textures"))), integer("texCoord", 0, 15),
    defaultable(number("strength")), object("extensions", kTextureInfoExtensions)};
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
constexpr Property kMaterial[] = {name(),
                                  object("pbrMetallicRoughness", kMetallicRoughness),
                                  object("normalTexture", kTextureInfo),
                                  defaultable(object("occlusionTexture", kDefaultableTextureInfo)),
                                  object("emissiveTexture", kTextureInfo),
                                  numbers("emissiveFactor", 3),
                                  string("alphaMode"),
                                  number("alphaCutoff", 0),
                                  boolean("doubleSided"),
                                  object("extensions", kMaterialExtensions)};

constexpr Property kDraco[] = {required(index("bufferView", "/bufferViews")),
                               required(reference("attributes", Kind::kIndexMap, nullptr))};
constexpr Property kVariantMapping[] = {
    required(index("material", "/materials")),
    required(reference("variants", Kind::kIndices, "/extensions/KHR_materials_variants/variants"))};
constexpr Property kVariantMappings[] = {
    required(per_element(objects("mappings", kVariantMapping)))};
constexpr Property kPrimitiveExtensions[] = {object("KHR_draco_mesh_compression", kDraco),
                                             object("KHR_materials_variants", kVariantMappings)};
constexpr Property kPrimitive[] = {
    required(per_element(reference("attributes", Kind::kIndexMap, "/accessors"))),
    index("indices", "/accessors"),
    index("material", "/materials"),
    integer("mode", 0, 6),
    per_element(reference("targets", Kind::kIndexMaps, "/accessors")),
    object("extensions", kPrimitiveExtensions)};
constexpr Property kMesh[] = {name(), required(objects("primitives", kPrimitive)),
                              numbers("weights", 0)};

constexpr Property kNodeLight[] = {
    required(index("light", "/extensions/KHR_lights_punctual/lights"))};
constexpr Property kNodeInstancing[] = {
    required(per_element(reference("attributes", Kind::kIndexMap, "/accessors")))};
constexpr Property kNodeVisibility[] = {boolean("visible")};
constexpr Property kNodeExtensions[] = {
    object("KHR_lights_punctual", kNodeLight), object("KHR_node_visibility", kNodeVisibility),
    essential(object("EXT_mesh_gpu_instancing", kNodeInstancing))};
constexpr Property kNode[] = {name(),
                              reference("children", Kind::kIndices, "/nodes"),
                              index("mesh", "/meshes"),
                              defaultable(index("camera", "/cameras")),
                              index("skin", "/skins"),
                              numbers("matrix", 16),
                              numbers("translation", 3),
                              numbers("rotation", 4),
                              numbers("scale", 3),
                              numbers("weights", 0),
                              object("extensions", kNodeExtensions)};
constexpr Property kScene[] = {name(), reference("nodes", Kind::kIndices, "/nodes")};
constexpr Property kSkin[] = {index("inverseBindMatrices", "/accessors"),
                              defaultable(index("skeleton", "/nodes")),
                              required(reference("joints", Kind::kIndices, "/nodes"))};

// Clip planes are ignored.
constexpr Property kPerspective[] = {
    required(number("yfov")), required(defaultable(number("znear"))),
    defaultable(number("aspectRatio")), defaultable(number("zfar"))};
// xmag is only a hint about the frame's aspect ratio.
constexpr Property kOrthographic[] = {
    required(defaultable(number("xmag"))), required(number("ymag")),
    required(defaultable(number("znear"))), required(defaultable(number("zfar")))};
constexpr Property kCamera[] = {name(), required(string("type")),
                                object("perspective", kPerspective),
                                object("orthographic", kOrthographic)};
constexpr Property kSpot[] = {number("innerConeAngle", 0),
                              number("outerConeAngle", FLT_TRUE_MIN, kMaxOuterCone)};
constexpr Property kLight[] = {name(),
                               numbers("color", 3),
                               number("intensity", 0),
                               positive("range"),
                               required(string("type")),
                               object("spot", kSpot)};
constexpr Property kLights[] = {required(per_element(objects("lights", kLight)))};
constexpr Property kVariant[] = {name()};
constexpr Property kVariants[] = {required(per_element(objects("variants", kVariant)))};
constexpr Property kRootExtensions[] = {object("KHR_lights_punctual", kLights),
                                        object("KHR_materials_variants", kVariants)};

constexpr Property kAsset[] = {required(string("version")), string("minVersion"),
                               defaultable(string("generator"))};

constexpr Property kAnimationPointer[] = {required(string("pointer"))};
constexpr Property kTargetExtensions[] = {object("KHR_animation_pointer", kAnimationPointer)};
constexpr Property kTarget[] = {index("node", "/nodes"), required(string("path")),
                                object("extensions", kTargetExtensions)};
constexpr Property kChannel[] = {required(integer("sampler")), required(object("target", kTarget))};
constexpr Property kAnimationSampler[] = {required(index("input", "/accessors")),
                                          string("interpolation"),
                                          required(index("output", "/accessors"))};
constexpr Property kAnimation[] = {name(), required(objects("channels", kChannel)),
                                   required(objects("samplers", kAnimationSampler))};
// The arrays are checked in this order, so the target of a `propagating` index must come first.
constexpr Property kRoot[] = {required(object("asset", kAsset)),
                              index("scene", "/scenes"),
                              plain("extensionsRequired", Kind::kStrings),
                              defaultable(plain("extensionsUsed", Kind::kStrings)),
                              per_element(objects("buffers", kBuffer)),
                              per_element(objects("bufferViews", kBufferView)),
                              per_element(objects("accessors", kAccessor)),
                              per_element(objects("animations", kAnimation)),
                              per_element(objects("cameras", kCamera)),
                              per_element(objects("images", kImage)),
                              per_element(objects("samplers", kSampler)),
                              per_element(objects("textures", kTexture)),
                              object("extensions", kRootExtensions),
                              per_element(objects("materials", kMaterial)),
                              per_element(objects("meshes", kMesh)),
                              essential(per_element(objects("nodes", kNode))),
                              essential(per_element(objects("scenes", kScene))),
                              per_element(objects("skins", kSkin))};

// Removes and returns the next step of the pointer.
std::string_view take_step(std::string_view& pointer) {
  pointer.remove_prefix(std::min<size_t>(pointer.size(), 1));
  const std::string_view step = pointer.substr(0, pointer.find('/'));
  pointer.remove_prefix(step.size());
  return step;
}

// Collects the members that the table does not list. Adds each member only once per kind of object,
// and at most as many as a report shows.
void find_unknown(const nlohmann::json& value, Schema schema, const std::string& kind,
                  std::vector<std::string>& found) {
  if (value.is_array()) {
    for (const nlohmann::json& element : value) find_unknown(element, schema, kind, found);
    return;
  }
  if (!value.is_object()) return;
  constexpr size_t kMaxFound = 100;
  for (const auto& [name, member] : value.items()) {
    if (name == "extras" || name == "extensions" || found.size() >= kMaxFound) continue;
    const auto property = std::ranges::find(schema, name, &Property::name);
    if (property == schema.end()) {
      std::string text = "\"" + shortened(name) + "\" of " + kind;
      if (std::ranges::find(found, text) == found.end()) found.push_back(std::move(text));
    } else if (property->kind == Kind::kObject || property->kind == Kind::kObjects) {
      find_unknown(member, property->schema, kind + "/" + name, found);
    }
  }
}

}  // namespace

std::vector<std::string> unknown_members(const nlohmann::json& root) {
  std::vector<std::string> found;
  for (const Property& property : kRoot) {
    const std::string name = property.name;
    const bool is_checked = name == "nodes" || name == "meshes" || name == "materials";
    if (is_checked && root.contains(name))
      find_unknown(root.at(name), property.schema, name, found);
  }
  return found;
}

const Property* find_property(std::string_view pointer) {
  Schema schema = kRoot;
  while (true) {
    const auto found = std::ranges::find(schema, take_step(pointer), &Property::name);
    if (found == schema.end()) return nullptr;
    if (found->kind == Kind::kObjects) take_step(pointer);  // skips the index
    if (pointer.empty()) return &*found;
    schema = found->schema;
  }
}

void check_schema(nlohmann::json& root, const std::string& file, GltfFaults& faults) {
  check_document(root, file, faults, kRoot);
}

}  // namespace emberline
