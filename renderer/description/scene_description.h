// The contents of a scene file as plain data, before anything is compiled for rendering.
//
// `io` fills in a SceneDescription, and `build_scene` reads it. Units are those of glTF: metres,
// radians, candela (point, spot), lux (directional), radiance for emission. Coordinates are
// right-handed, and Y is up. Indices refer to the vectors of SceneDescription, and are valid once
// load_gltf has returned; -1 means "none".
#pragma once

#include <Imath/ImathBox.h>

#include <array>
#include <cmath>
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

// A decoded image in the bit depth of its file. Rows start at the top, channels are interleaved,
// and alpha is not premultiplied. `texels` contains width * height * channels values of `type`. If
// `mapped` is set, `texels` is empty; the texels are then in a memory-mapped file
// (io/image/texture_store.h), in tiled order (mapped_texels.h).
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

// Says how a texture slot of a material uses an image. UV (0, 0) is the image's top-left corner, as
// in glTF.
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

// A glTF 2.0 metallic-roughness material (specification section 3.9 and appendix B) with its
// extensions. The default values of an extension have the same effect as its absence. Factors are
// linear, and each multiplies its texture. Colour textures are sRGB-encoded if their image is
// integer-valued; other textures are linear data. In the comments on textures, letters name the
// channels that are read.
struct MaterialDescription {
  std::string name;
  Rgb base_color = Rgb(1.0f);
  float alpha = 1.0f;
  TextureRef base_color_texture;  // rgb: colour, a: coverage
  float metallic = 1.0f;
  float roughness = 1.0f;
  TextureRef metallic_roughness_texture;  // g roughness, b metallic
  TextureRef normal_texture;              // in tangent space; rgb in [0, 1] maps to [-1, 1]
  float normal_scale = 1.0f;
  Rgb emission = Rgb(0.0f);  // radiance: emissiveFactor x emissiveStrength
  // A factor on the emission that varies over time (see "Motion" below); null: constant.
  std::shared_ptr<const TimeCurve<Rgb>> emission_scale = {};
  TextureRef emission_texture;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  bool double_sided = false;
  bool unlit = false;  // KHR_materials_unlit: the base colour is shown as radiance

  float ior = 1.5f;  // of the dielectric (KHR_materials_ior): >= 1, or 0 to reflect everything
  // KHR_materials_specular: the weight of the dielectric's reflection in [0, 1], and the
  // reflection's colour at normal incidence. A weight of 0 leaves only the Lambertian base.
  float specular = 1.0f;
  TextureRef specular_texture;  // a
  Rgb specular_color = Rgb(1.0f);
  TextureRef specular_color_texture;  // rgb, sRGB
  // KHR_materials_pbrSpecularGlossiness is represented by an ior of 0 and the members above, plus
  // this texture, which multiplies the glossiness (1 - roughness).
  TextureRef glossiness_texture;  // a

  // KHR_materials_transmission, _volume and _dispersion.
  float transmission = 0.0f;          // fraction that the dielectric transmits clearly
  TextureRef transmission_texture;    // r
  bool thin_walled = true;            // true if thicknessFactor is 0; then there is no interior
  Rgb attenuation_color = Rgb(1.0f);  // colour of white light after attenuation_distance
  float attenuation_distance = std::numeric_limits<float>::infinity();  // metres
  float dispersion = 0.0f;                                              // 20 / Abbe number, >= 0

  // KHR_materials_diffuse_transmission: fraction of the diffuse base that is transmitted.
  float diffuse_transmission = 0.0f;
  TextureRef diffuse_transmission_texture;  // a
  Rgb diffuse_transmission_color = Rgb(1.0f);
  TextureRef diffuse_transmission_color_texture;  // rgb, sRGB

  // KHR_materials_anisotropy: the highlight is stretched along a direction in the tangent plane.
  float anisotropy = 0.0f;           // strength, [0, 1]
  float anisotropy_rotation = 0.0f;  // radians counter-clockwise from the tangent
  TextureRef anisotropy_texture;     // rg direction, [0, 1] maps to [-1, 1]; b strength

  // KHR_materials_iridescence: a thin film on the base. Its thickness in nanometres is the minimum
  // where the texture is 0, and the maximum where it is 1 or if there is no texture.
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

  // KHR_materials_clearcoat: a dielectric of index 1.5 on top of everything.
  float clearcoat = 0.0f;
  TextureRef clearcoat_texture;  // r
  float clearcoat_roughness = 0.0f;
  TextureRef clearcoat_roughness_texture;  // g
  TextureRef clearcoat_normal_texture;     // like normal_texture; without it: the vertex normal
  float clearcoat_normal_scale = 1.0f;
};

// Returns whether surfaces with this material are lights.
inline bool emits(const MaterialDescription& material) {
  const auto positive = [](float x) { return x > 0.0f && std::isfinite(x); };
  const Rgb& e = material.emission;
  return !material.unlit && (positive(e.x) || positive(e.y) || positive(e.z));
}

// Returns whether the material is anisotropic or has a texture in tangent space, even one whose
// factor is 0. If so, load_gltf computes tangents for meshes with this material.
inline bool has_tangent_space(const MaterialDescription& material) {
  return material.normal_texture.image >= 0 || material.clearcoat_normal_texture.image >= 0 ||
         material.anisotropy_texture.image >= 0 || material.anisotropy > 0.0f;
}

// ---- geometry

// A box in world space, which is empty by default.
struct WorldBounds : Imath::Box3d {
  // Transforms a box to world space and adds it. An empty box adds nothing.
  void add(const WorldBounds& box, const Mat44d& to_world) {
    for (int corner = 0; corner < 8 && !box.isEmpty(); ++corner) {
      extendBy(transform_point(
          to_world, {corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                     corner & 4 ? box.max.z : box.min.z}));
    }
  }
  double radius() const { return isEmpty() ? 0.0 : size().length() * 0.5; }
};

// The material of a mesh in one variant.
struct VariantMaterial {
  int variant = -1;  // into SceneDescription::variants
  int material = -1;

  bool operator==(const VariantMaterial&) const = default;
};

// A triangle mesh with one material. It is one glTF primitive, whose strips and fans are already
// converted to triangles.
struct MeshDescription : MeshArrays {
  std::string name;   // "mesh name/primitive index", for messages and the id AOV's manifest
  int material = -1;  // -1: glTF's default material
  // Sorted by variant; in variants that are not listed, the mesh uses `material`.
  std::vector<VariantMaterial> variant_materials;
  // If true, the mesh may have another position, or more visible instances, at another time of the
  // animation.
  bool may_move = false;
  // Set if the scene to be reposed (repose_scene()) already has this mesh. The arrays are then
  // empty, and this contains their bounds.
  std::optional<WorldBounds> reused_bounds = {};
};

// KHR_materials_variants: a set of materials that may replace the meshes' own materials.
struct VariantDescription {
  std::string name;
};

// Motion while the shutter is open. The ordinary transforms and vertices are those at shutter open.
// `motion` contains those at later times, which are evenly spaced up to shutter close; it is empty
// if nothing moves. Between the times, vertices, positions and scales are interpolated linearly,
// and rotations about an axis.
//
// Other values have their own key times (time_curve.h), so that they can switch instantly. Emitted
// light is stored as the maximum of each channel and a curve of factors in [0, 1]. Code that only
// uses or edits the maximum can ignore the curve.

// A mesh placed in the world. The node hierarchy is flattened at load. Transforms stay in double,
// so that a distant scene can be moved to the origin before it is rounded to float.
struct InstanceDescription {
  std::string name;  // node name
  int mesh = -1;
  Mat44d to_world;  // for row vectors; finite; mirrors if its determinant is negative
  std::vector<Mat44d> motion = {};
  std::shared_ptr<const VisibilityTimes> visibility = {};  // null: always visible
  int node = -1;  // index of the node in the file and in SceneDescription::nodes
};

// A node of the file. It has the same index in SceneDescription::nodes as in the file.
struct NodeDescription {
  std::string name;
  int root = 0;                  // index of the topmost ancestor, or of the node itself
  bool has_mesh = false;         // even if the mesh is not visible
  int parent = -1;               // -1: none
  bool has_camera = false;       // even if the camera cannot be used
  bool has_light = false;        // from KHR_lights_punctual
  bool in_scene = false;         // true if the rendered scene contains the node
  bool catches_shadows = false;  // set for the plane of catcher_plane.h
};

// The transform of a moving instance one frame after the rendered instant. If the shutter is
// instant, motion vectors are computed from this transform; it is not used for tracing. Meshes and
// cameras have their own `next_frame`.
struct NextFrameInstance {
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
  // Angles from the axis in radians, with 0 <= inner < outer <= pi/2. If the cones change over
  // time, these are the maxima.
  float inner_cone = 0.0f;
  float outer_cone = 0.785398163f;
  // A point light or spot reaches no farther than this distance in metres. If the distance changes
  // over time, this is its maximum.
  float range = std::numeric_limits<float>::infinity();
  Mat44d to_world;  // spots and directional lights emit along -Z
  std::vector<Mat44d> motion = {};
  // Values that change over time (see "Motion" above); null: constant.
  std::shared_ptr<const TimeCurve<Rgb>> share = {};
  std::shared_ptr<const TimeCurve<Vec2f>> cones = {};  // inner and outer angle
  std::shared_ptr<const TimeCurve<float>> range_scale = {};
  std::shared_ptr<const VisibilityTimes> visibility = {};
};

// Returns whether the light becomes one of the Scene's point lights. These have the same order as
// the description's lights.
inline bool shines(const PunctualLightDescription& light) { return !is_black(light.intensity); }

struct CameraDescription {
  std::string name;
  std::string node = {};  // name of the camera's node; may be empty
  bool orthographic = false;
  bool panorama = false;         // not in files; only the position is used (camera.h)
  double fov_y = 0.8;            // radians, perspective
  std::optional<double> aspect;  // width / height; absent: the frame's ratio
  double y_mag = 1.0;            // half the height of an orthographic view
  // fov_y (or, if orthographic, y_mag) as it changes over time; null: constant.
  std::shared_ptr<const TimeCurve<double>> zoom = {};
  // A thin lens. Only perspective cameras can have one; files never do.
  double lens_radius = 0.0;     // metres; 0: a pinhole
  double focus_distance = 0.0;  // metres along the axis to the plane of focus; > 0 with a lens
  Mat44d to_world;              // the camera looks along -Z, +Y is up; its scale is ignored
  std::vector<Mat44d> motion = {};
  std::optional<Mat44d> next_frame = {};  // see NextFrameInstance
  // Set if the camera is invalid in the file. Selecting the camera then throws this error.
  std::shared_ptr<const InputError> fault = {};
};

// A distant disc with limb darkening, visible only above the horizon.
struct SunDisc {
  Vec3f direction = Vec3f(0, 1, 0);  // unit
  float radius = 0.0f;               // half the angular diameter, radians
  Rgb irradiance = Rgb(0.0f);        // of the whole disc, on a surface that faces it
};

// A latitude-longitude environment with u = 0.5 + atan2(z, x) / 2 pi, and with +Y in the top row. A
// `rotation_degrees` of 90 rotates it such that +X moves to -Z.
struct EnvironmentDescription {
  std::string file;                    // empty: constant colour
  Rgb constant = Rgb(1.0f);            // radiance if there is no image
  std::shared_ptr<const Image> image;  // kHalf or kFloat, 3 channels
  // A sun in front of the image; may be null. It is scaled, tinted and rotated with the image.
  std::shared_ptr<const SunDisc> sun;
  float strength = 1.0f;
  Rgb tint = Rgb(1.0f);  // multiplies the radiance, as does strength
  float rotation_degrees = 0.0f;
};

// ---- the whole

// An animation of the file; GltfOptions may choose it to pose the scene.
struct AnimationDescription {
  std::string name;
  double duration = 0.0;      // seconds, from 0 to its last key frame
  size_t nodes = 0;           // number of nodes that it moves, rotates or scales
  size_t morphs = 0;          // number of nodes whose meshes it morphs
  size_t pointers = 0;        // number of other values that it changes
  size_t without_effect = 0;  // number of channels without a valid target
  std::string fault;          // error if it is chosen; empty if its JSON is valid
};

// The features that the file uses, and how the renderer treats them. Entries are extension names,
// or short phrases such as "occlusionTexture" or "primitive mode LINES".
struct CoverageReport {
  std::vector<std::string> used;          // supported extensions
  std::vector<std::string> approximated;  // rendered approximately; the entry says how
  std::vector<std::string> ignored;       // without effect on the image
  // If the file has animations but none is chosen, a text that says how many there are and which
  // `setting` chooses one. Otherwise empty.
  std::string not_played;
};

// Numbers of repairs and omissions during loading. Each kind is reported in a single warning.
struct LoadRepairs {
  uint64_t degenerate_triangles = 0;  // zero area or repeated vertices, dropped
  uint64_t non_finite_triangles = 0;  // a NaN or infinite vertex, dropped
  // Vertices with a NaN or infinite colour, normal, tangent or texture coordinate. The value is
  // replaced.
  uint64_t non_finite_attributes = 0;
  uint64_t non_finite_texels = 0;   // NaN, infinite or negative; set to 0 or clamped
  uint64_t singular_instances = 0;  // the transform has no inverse; dropped
  uint64_t replaced_images = 0;     // --lenient: cannot be decoded; replaced by a neutral colour
};

// The lists of a scene that edits refer to. They are short and cheap to copy.
struct SceneLists {
  std::string file;
  std::vector<MaterialDescription> materials;
  std::vector<VariantDescription> variants;
  // True if the meshes' variant_materials have been read, together with the data that these
  // materials need.
  bool variants_read = false;
  bool tangents_read = false;  // for all meshes, not only where has_tangent_space() holds
  std::vector<PunctualLightDescription> lights;
  std::vector<CameraDescription> cameras;
  std::optional<EnvironmentDescription> environment;
  ToWorkingSpace to_working;  // applied by build_scene(); colours here are not converted yet
  bool may_be_dark = false;   // if true, a scene without light stays dark; no warning
};

struct SceneDescription : SceneLists {
  std::vector<NamedFile> files;  // all files that were read, the scene first
  std::string generator;         // asset.generator
  std::vector<std::shared_ptr<const Image>> images;
  std::vector<MeshDescription> meshes;
  std::vector<InstanceDescription> instances;
  std::vector<NodeDescription> nodes;                   // if requested (GltfOptions::nodes)
  std::vector<NextFrameInstance> next_frame_instances;  // of moving instances, in ascending order
  // Bounds of the rest pose, if the scene is posed. A view of the whole scene frames these bounds,
  // so that it does not depend on the pose.
  std::optional<WorldBounds> rest_bounds;
  CoverageReport coverage;
  LoadRepairs repairs;
  std::vector<AnimationDescription> animations;
};

}  // namespace emberline
