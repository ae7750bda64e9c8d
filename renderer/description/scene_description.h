// What a scene file says, as plain data: no Embree, no threads, nothing compiled for a frame.
//
// `io` fills it, `build_scene` reads it. Units are glTF's: metres, radians, candela (point, spot),
// lux (directional), radiance for emission. Y is up, right-handed. Indices are into the vectors of
// SceneDescription and are valid once load_gltf returns; -1 means "none".
#pragma once

#include <Imath/ImathBox.h>

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/core/colour_matrix.h"
#include "renderer/core/file_identity.h"
#include "renderer/core/time_curve.h"
#include "renderer/core/vector.h"
#include "renderer/description/mesh_arrays.h"

namespace emberline {

class MappedTexels;
struct InputError;

// ---- images and textures -----------------------------------------------------------------------

enum class TexelType : uint8_t { kUint8, kUint16, kHalf, kFloat };

// A decoded image in its file's own bit depth. Rows from the top; channels interleaved; alpha is
// not premultiplied. `texels` holds width * height * channels values of `type`; or they lie in a
// file that is mapped to memory (io/image/texture_store.h), in another order (mapped_texels.h), and
// it is empty.
struct Image {
  std::string name;  // for messages: URI or "#/images/3"
  int width = 0;
  int height = 0;
  int channels = 0;  // 1..4
  TexelType type = TexelType::kUint8;
  std::vector<std::byte> texels;
  std::shared_ptr<const MappedTexels> mapped;

  uint64_t byte_count() const {
    constexpr std::array<uint64_t, 4> kBytes = {1, 2, 2, 4};
    return uint64_t(width) * uint64_t(height) * uint64_t(channels) * kBytes[size_t(type)];
  }
};

enum class WrapMode : uint8_t { kRepeat, kMirroredRepeat, kClampToEdge };

// One use of an image by a material slot. UV (0, 0) is the image's top-left corner, as in glTF.
struct TextureRef {
  int image = -1;  // -1: no texture in this slot
  int uv_set = 0;  // TEXCOORD_n
  WrapMode wrap_s = WrapMode::kRepeat;
  WrapMode wrap_t = WrapMode::kRepeat;
  bool nearest = false;  // magFilter NEAREST
  // KHR_texture_transform as uv' = (m00 u + m01 v + m02, m10 u + m11 v + m12).
  std::array<float, 6> uv_transform = {1, 0, 0, 0, 1, 0};
};

// ---- materials

enum class AlphaMode : uint8_t { kOpaque, kMask, kBlend };

// glTF 2.0 metallic-roughness (specification section 3.9 and appendix B) and its extensions; a
// default is the extension's and means that it is not there. Factors are linear and multiply their
// texture. Colour textures are sRGB-encoded when their image is integer-valued; the others are
// linear data, and the letters say which channel is read.
struct MaterialDescription {
  std::string name;
  Rgb base_color = Rgb(1.0f);
  float alpha = 1.0f;
  TextureRef base_color_texture;  // rgb, and a as coverage
  float metallic = 1.0f;
  float roughness = 1.0f;
  TextureRef metallic_roughness_texture;  // g roughness, b metallic
  TextureRef normal_texture;              // tangent space, rgb in [0, 1] -> [-1, 1]
  float normal_scale = 1.0f;
  Rgb emission = Rgb(0.0f);  // emissiveFactor x KHR_materials_emissive_strength: radiance
  // See Motion: what there is of it at a time. Null: all of it.
  std::shared_ptr<const TimeCurve<Rgb>> emission_share = {};
  TextureRef emission_texture;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;  // KHR_materials_unlit: base colour is the radiance seen

  float ior = 1.5f;  // of the dielectric (KHR_materials_ior); >= 1, or 0: reflects everything
  // KHR_materials_specular: weight of the dielectric's reflection, [0, 1] (0: bare Lambert), and
  // colour of its reflection at normal incidence.
  float specular = 1.0f;
  TextureRef specular_texture;  // a
  Rgb specular_color = Rgb(1.0f);
  TextureRef specular_color_texture;  // rgb, sRGB
  // KHR_materials_pbrSpecularGlossiness is the above with an index of 0, and a glossiness, which is
  // 1 - roughness, times this.
  TextureRef glossiness_texture;  // a

  // KHR_materials_transmission, _volume and _dispersion.
  float transmission = 0.0f;          // share of the dielectric that is clear
  TextureRef transmission_texture;    // r
  bool thin_walled = true;            // thicknessFactor is 0: no interior
  Rgb attenuation_color = Rgb(1.0f);  // of white light after attenuation_distance in the interior
  float attenuation_distance = std::numeric_limits<float>::infinity();  // metres
  float dispersion = 0.0f;                                              // 20 / Abbe number, >= 0

  // KHR_materials_diffuse_transmission: share of the diffuse base that passes to the other side.
  float diffuse_transmission = 0.0f;
  TextureRef diffuse_transmission_texture;  // a
  Rgb diffuse_transmission_color = Rgb(1.0f);
  TextureRef diffuse_transmission_color_texture;  // rgb, sRGB

  // KHR_materials_anisotropy: the highlight is stretched along a direction of the tangent plane.
  float anisotropy = 0.0f;           // strength, [0, 1]
  float anisotropy_rotation = 0.0f;  // radians counter-clockwise from the tangent
  TextureRef anisotropy_texture;     // rg direction in [0, 1] -> [-1, 1], b strength

  // KHR_materials_iridescence: a thin film on the base. Thickness in nanometres, from minimum where
  // the texture is 0 to maximum where it is 1, or where there is none.
  float iridescence = 0.0f;
  TextureRef iridescence_texture;  // r
  float iridescence_ior = 1.3f;    // >= 1
  float iridescence_thickness_minimum = 100.0f;
  float iridescence_thickness_maximum = 400.0f;
  TextureRef iridescence_thickness_texture;  // g

  // KHR_materials_sheen: fibres on the base.
  Rgb sheen_color = Rgb(0.0f);
  TextureRef sheen_color_texture;  // rgb, sRGB
  float sheen_roughness = 0.0f;
  TextureRef sheen_roughness_texture;  // a

  // KHR_materials_clearcoat: a dielectric of index 1.5 on top of all.
  float clearcoat = 0.0f;
  TextureRef clearcoat_texture;  // r
  float clearcoat_roughness = 0.0f;
  TextureRef clearcoat_roughness_texture;  // g
  TextureRef clearcoat_normal_texture;     // as normal_texture; none: the vertex normal
  float clearcoat_normal_scale = 1.0f;
};

// Whether load_gltf gives the meshes that wear it tangents: something of it is meant in tangent
// space, or would be if its factor were not 0.
inline bool has_tangent_space(const MaterialDescription& material) {
  return material.normal_texture.image >= 0 || material.clearcoat_normal_texture.image >= 0 ||
         material.anisotropy_texture.image >= 0 || material.anisotropy > 0.0f;
}

// ---- geometry

// Empty with nothing in it.
struct WorldBounds : Imath::Box3d {
  // Another one that is placed in the world; nothing, if it is empty.
  void add(const WorldBounds& box, const Mat44d& to_world) {
    for (int corner = 0; corner < 8 && !box.isEmpty(); ++corner) {
      extendBy(transform_point(
          to_world, {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z}));
    }
  }
  double radius() const { return isEmpty() ? 0.0 : size().length() * 0.5; }
};

// What a mesh wears in one variant.
struct VariantMaterial {
  int variant = -1;  // into SceneDescription::variants
  int material = -1;

  bool operator==(const VariantMaterial&) const = default;
};

// A triangle mesh with one material (one glTF primitive, strips and fans already unrolled).
struct MeshDescription : MeshArrays {
  std::string name;   // "mesh name/primitive index", for messages and the id AOV's manifest
  int material = -1;  // -1: glTF's default material
  // By growing variant; in those that are absent the mesh wears `material`.
  std::vector<VariantMaterial> variant_materials;
  // True: at another time it may stand elsewhere, or be seen more often.
  bool may_move = false;
  // Set: its arrays are left out, since whoever gets the pose has them from one before; its extent.
  std::optional<WorldBounds> held = {};
};

// KHR_materials_variants: a set of materials that the meshes may wear instead of their own.
struct VariantDescription {
  std::string name;
};

// Motion while the shutter is open: what moves is also given at later times, evenly spaced up to
// its closing; at its opening it is where it stands without them. None: it is at rest. Between them
// vertices, positions and sizes go along straight lines, and transforms turn about an axis.
//
// Other values change at times of their own (time_curve.h), so that what is switched is so in an
// instant. What shines is described at its brightest, colour by colour, with the share of that
// which there is at a time, from 0 to 1: whoever reckons with the brightest alone, or edits it, has
// no need to know of time.

// A mesh placed in the world. Nodes are flattened at load; transforms keep double precision so
// that a far-away scene can be rebased before it is rounded to float.
struct InstanceDescription {
  std::string name;  // node name
  int mesh = -1;
  Mat44d to_world;  // row-vector convention; may mirror (negative determinant); finite
  std::vector<Mat44d> motion = {};
  std::shared_ptr<const ShownTimes> shown = {};  // null: always
  int node = -1;                                 // of the file; into SceneDescription::nodes
};

// A node of the file, by its number there.
struct NodeDescription {
  std::string name;
  int root = 0;           // the node without a parent that it is below; itself, if it has none
  bool has_mesh = false;  // whether it is seen or not
  int parent = -1;        // -1: none
};

// What moves is seen at an instant, but its velocity is asked for: where it is a frame later. Rays
// do not meet it there. Meshes and cameras have a `later` of their own.
struct LaterInstance {
  uint32_t instance = 0;  // into SceneDescription::instances
  Mat44d to_world;
};

// ---- lights and cameras

enum class PunctualType : uint8_t { kPoint, kSpot, kDirectional };

// KHR_lights_punctual.
struct PunctualLightDescription {
  std::string name;
  PunctualType type = PunctualType::kPoint;
  Rgb intensity = Rgb(1.0f);  // colour x intensity: candela, or lux for kDirectional
  // Radians from the axis, 0 <= inner < outer <= pi/2; of cones that change the widest.
  float inner_cone = 0.0f;
  float outer_cone = 0.785398163f;
  // Metres; beyond it a point light or spot gives no light. Of a range that changes the largest.
  float range = std::numeric_limits<float>::infinity();
  Mat44d to_world;  // it shines along -Z (spot, directional)
  std::vector<Mat44d> motion = {};
  // See Motion; null: they do not change.
  std::shared_ptr<const TimeCurve<Rgb>> share = {};
  std::shared_ptr<const TimeCurve<Vec2f>> cones = {};  // inner and outer
  std::shared_ptr<const TimeCurve<float>> range_share = {};
  std::shared_ptr<const ShownTimes> shown = {};
};

// Those that do are a scene's point lights, in the order of the description.
inline bool shines(const PunctualLightDescription& light) { return !is_black(light.intensity); }

struct CameraDescription {
  std::string name;
  std::string node = {};  // the name of the node that has it; empty: none
  bool orthographic = false;
  bool panorama = false;  // see camera.h; no file has one. Of the rest only where it is counts
  double fov_y = 0.8;     // radians, perspective
  std::optional<double> aspect;  // width / height; absent: from the frame
  double y_mag = 1.0;            // half the height, orthographic
  // Of whichever of the two counts; null: it does not change.
  std::shared_ptr<const TimeCurve<double>> zoom = {};
  // A thin lens, perspective only; no file has one.
  double lens_radius = 0.0;     // metres; 0: a pinhole
  double focus_distance = 0.0;  // metres along the axis to the plane that is sharp; > 0 with a lens
  Mat44d to_world;              // looks along -Z, +Y up; scale in it is ignored
  std::vector<Mat44d> motion = {};
  std::optional<Mat44d> later = {};  // see LaterInstance
  // Set: what the file says of it makes no camera. Whoever chooses it throws this.
  std::shared_ptr<const InputError> fault = {};
};

// A disc that is far away, above the horizon alone; it darkens towards its edge.
struct SunDisc {
  Vec3f direction = Vec3f(0, 1, 0);  // unit
  float radius = 0.0f;               // half the angle across
  Rgb irradiance = Rgb(0.0f);        // of the whole disc, on a surface that faces it
};

// A latitude-longitude environment: u = 0.5 + atan2(z, x) / 2 pi, top row +Y. Positive
// `rotation_degrees` turns it so that 90 brings what was at +X to -Z.
struct EnvironmentDescription {
  std::string file;                    // empty: constant colour
  Rgb constant = Rgb(1.0f);            // radiance if there is no image
  std::shared_ptr<const Image> image;  // kHalf or kFloat, 3 channels
  // Before an image, and dimmed, tinted and turned with it; an image has one sun or none.
  std::shared_ptr<const SunDisc> sun;
  float strength = 1.0f;
  Rgb tint = Rgb(1.0f);  // multiplies the radiance, as strength does
  float rotation_degrees = 0.0f;
};

// ---- the whole

// An animation of the file: it may pose the scene (GltfOptions).
struct AnimationDescription {
  std::string name;
  double duration = 0.0;      // seconds, from 0 to its last key frame
  size_t nodes = 0;           // that it moves, turns or scales
  size_t morphs = 0;          // nodes whose meshes it morphs
  size_t pointers = 0;        // other values that it changes
  size_t without_effect = 0;  // channels that lead nowhere
  std::string fault;          // why it cannot be chosen; empty: it can, as far as its JSON goes
};

// What the file uses and what becomes of it. Names are extension names, or short phrases such as
// "occlusionTexture" or "primitive mode LINES".
struct CoverageReport {
  std::vector<std::string> used;          // extensions honoured
  std::vector<std::string> approximated;  // rendered, but not to the letter; says how
  std::vector<std::string> ignored;       // no effect on the picture
};

// What was repaired or left out while loading, with counts; each is also warned of once.
struct LoadRepairs {
  uint64_t degenerate_triangles = 0;  // zero area or repeated vertices, dropped
  uint64_t non_finite_triangles = 0;  // a NaN or infinite vertex, dropped
  // Vertices with a NaN or infinite colour, normal, tangent or texture coordinate, replaced.
  uint64_t non_finite_attributes = 0;
  uint64_t non_finite_texels = 0;   // NaN or infinite or negative texels set to 0 (or clamped)
  uint64_t singular_instances = 0;  // transform without inverse, dropped
  uint64_t replaced_images = 0;     // --lenient: undecodable, replaced by neutral colour
};

// What edits count in: short lists, cheap to copy.
struct SceneLists {
  std::string file;
  std::vector<MaterialDescription> materials;
  std::vector<VariantDescription> variants;
  // Whether the meshes' variant_materials, and what those materials need, have been read.
  bool variants_read = false;
  bool tangents_read = false;  // of every mesh; else as has_tangent_space() says
  std::vector<PunctualLightDescription> lights;
  std::vector<CameraDescription> cameras;
  std::optional<EnvironmentDescription> environment;
  ToWorkingSpace to_working;  // what a Scene's colours are converted by; these are not
  bool may_be_dark = false;   // true: without any light there is none, and nobody is warned
};

struct SceneDescription : SceneLists {
  std::vector<NamedFile> files;  // all that were read for it, the scene first
  std::string generator;         // asset.generator
  std::vector<std::shared_ptr<const Image>> images;
  std::vector<MeshDescription> meshes;
  std::vector<InstanceDescription> instances;
  std::vector<NodeDescription> nodes;          // if they are asked for (GltfOptions::nodes)
  std::vector<LaterInstance> later_instances;  // those that move, by growing instance
  // Of a posed scene: what it takes up at rest, so that a view of the whole does not depend on the
  // pose.
  std::optional<WorldBounds> rest_bounds;
  CoverageReport coverage;
  LoadRepairs repairs;
  std::vector<AnimationDescription> animations;
};

}  // namespace emberline
