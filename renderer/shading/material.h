// Materials compiled for a frame: texture slots without a texture become constants, and flags say
// which features a material has, so that a scene pays only for what it uses.
//
// Materials are built once from the scene description and then read by all threads. All const
// functions are pure.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "renderer/core/vector.h"
#include "renderer/description/scene_description.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/layers.h"
#include "renderer/shading/texture.h"

namespace emberline {

// Materials can use TEXCOORD_0 .. TEXCOORD_3.
inline constexpr int kMaxUvSets = 4;

// Interpolated vertex attributes at a hit. Missing sets of texture coordinates are 0.
struct SurfaceAttributes {
  std::array<Vec2f, kMaxUvSets> uv;
  // COLOR_0, linear; (1, 1, 1, 1) if has_color is false.
  Vec4f color = Vec4f(1.0f, 1.0f, 1.0f, 1.0f);
  bool has_color = false;

  SurfaceAttributes() { uv.fill(Vec2f(0.0f)); }
  // This constructor is for a mesh whose attributes are not read. It sets the coordinates to 0,
  // since the `uv` integrator shows them. It leaves the colour uninitialised, since the colour is
  // never read and this constructor runs at every hit.
  struct Unread {};
  explicit SurfaceAttributes(Unread) : color() { uv.fill(Vec2f(0.0f)); }
};

// A material's values at a point.
struct MaterialPoint {
  BsdfParameters bsdf;            // clamped to the ranges that SurfaceBsdf requires
  Rgb emission = Rgb(0.0f);       // radiance, the same in all directions
  Vec3f normal = Vec3f(0, 0, 1);  // unit, in tangent space; see mapped_normal()
  bool has_normal_map = false;
};

// Texel positions of a material's textures at a point, one per parametrisation (see
// Texture::same_parametrisation()).
struct TexelPositions {
  static constexpr size_t kMaxPositions = 18;  // if every slot has its own parametrisation
  size_t place[kMaxPositions];
  TexelCorners normal, clearcoat_normal;
  TexelPositions() {}  // runs at every hit, so it initialises nothing
};

class Material {
 public:
  // `textures` owns the textures of the slots. The material keeps pointers to its elements, so
  // `textures` must outlive the material and must not move elements (a growing deque does not).
  // Identical uses of an image share one Texture. Throws InputError for a UV set beyond kMaxUvSets.
  Material(const MaterialDescription& description, const SceneDescription& scene,
           std::deque<Texture>* textures);

  // Uses one random number for all textures, so that slots with the same parametrisation get the
  // same texel; base colour and roughness then match. Normal maps are filtered. Finding texels is
  // separate from reading them, so that the texels of many points can be prefetched before the
  // first texel is read.
  void find_texels(const SurfaceAttributes& attributes, float u_texture, TexelPositions* out) const;
  void evaluate(const SurfaceAttributes& attributes, const TexelPositions& texels,
                MaterialPoint& out) const {
    out = constant_;
    if (needs_uv() || attributes.has_color) evaluate_varying(attributes, texels, out);
  }
  // Evaluates the layers, which evaluate() leaves out. Call this only if has_layers() is true.
  void evaluate_layers(const TexelPositions& texels, MaterialLayers& out) const {
    out = layers_;
    if (layers_vary_) apply_layer_textures(texels, out);
  }
  bool has_layers() const { return has_layers_; }  // whether any layer has an effect
  // The layers' values without textures; a textured value is multiplied by its texel.
  const LayerParameters& layers() const { return layers_.parameters; }

  // Returns the radiance that is emitted below the clear coat, if there is one (see
  // emission_through_coat()). If unlit(), returns the base colour.
  Rgb emission(const SurfaceAttributes& attributes, float u_texture) const {
    return emission_varies_ ? varying_emission(attributes, u_texture) : emission();
  }
  const Rgb& emission() const { return constant_.emission; }  // call only if it does not vary
  // If the emission is animated, emission() is its maximum, and emission_scale() is the factor at a
  // given time.
  bool is_emission_animated() const { return emission_scale_ != nullptr; }
  Rgb emission_scale(float time) const { return emission_scale_->at(time); }
  // Returns the mean emission over a triangle with these corners, for the power of the light. It is
  // 0 for unlit materials.
  Rgb mean_emission(const SurfaceAttributes& a0, const SurfaceAttributes& a1,
                    const SurfaceAttributes& a2) const;

  // Returns the probability that a ray hits the surface. It is 1 for opaque materials and alpha for
  // blended materials. For masks, it is 0 or 1, because the cutoff is applied to the filtered
  // alpha.
  float coverage(const SurfaceAttributes& attributes, float u_texture) const;

  // Whether coverage() can differ from 1. Vertex colours may contain alpha.
  bool has_alpha(bool vertex_colors) const {
    return alpha_mode() != AlphaMode::kOpaque && (alpha_varies_ || vertex_colors);
  }
  AlphaMode alpha_mode() const { return alpha_mode_; }
  // Whether emission and coverage are the same everywhere and in all directions, so that emission()
  // needs no attributes.
  bool has_uniform_emission() const {
    return !emission_varies_ && !(layers().clearcoat > 0.0f) && alpha_mode() == AlphaMode::kOpaque;
  }
  // Whether shading or coverage reads vertex attributes. `vertex_colors` tells whether the mesh has
  // colours.
  bool reads_attributes(bool vertex_colors) const {
    return needs_uv() || vertex_colors || needs_tangents() || alpha_mode() != AlphaMode::kOpaque;
  }
  bool is_emissive() const {
    return is_emissive_;
  }  // whether the material is a light; never if unlit
  // Whether a triangle emits the same light with this material as with `other`: mean_emission() and
  // the emitting sides are then the same.
  bool has_same_emission(const Material& other) const;
  bool has_normal_map() const { return bool(normal_map_); }
  // Whether shading uses the mesh's tangent space.
  bool needs_tangents() const {
    return has_normal_map() || layers_.has_clearcoat_normal_map || layers().anisotropy > 0.0f;
  }
  bool double_sided() const { return double_sided_; }
  // Whether the material transmits light, clearly or diffusely. Its back faces are then visible
  // even if it is single-sided, and the integrator sets MaterialPoint::bsdf.inside if the ray hit
  // the back.
  bool is_transmissive() const { return has_transmission() || has_diffuse_transmission(); }
  // Whether transmitted light enters an interior rather than crossing a thin wall.
  bool is_solid() const { return !thin_walled_; }
  // Whether the material is a solid that is smooth and clear, at least in places. Light passes
  // through such places only along refracted rays.
  bool is_smooth_solid() const {
    return has_transmission() && is_solid() &&
           (square(roughness_) < kMirrorAlpha || metallic_roughness_texture_);
  }
  // Whether the solid is seen only through refraction and absorption. Where it does not refract,
  // its faces are invisible.
  bool is_clear_solid() const;
  float ior() const { return ior_; }                              // 0: reflects everything
  bool has_transmission() const { return transmission_ > 0.0f; }  // clear, not diffuse
  bool has_diffuse_transmission() const { return layers().diffuse_transmission > 0.0f; }
  // Whether the material is, at least in places, a smooth thin wall through which light goes
  // straight.
  bool is_smooth_wall() const {
    return has_transmission() && thin_walled_ &&
           (square(roughness_) < kMirrorAlpha || metallic_roughness_texture_);
  }
  // Attenuation per metre inside, for beer_transmittance(); 0 without an interior.
  const Rgb& attenuation() const { return attenuation_; }
  // 20 / Abbe number for clear transmission; 0 without dispersion.
  float dispersion() const { return dispersion_; }
  bool unlit() const { return unlit_; }  // does not scatter; only emission() is visible
  bool needs_uv() const { return uv_mask_ != 0; }
  uint32_t uv_mask() const { return uv_mask_; }  // bit n: TEXCOORD_n is read

 private:
  struct Slot {
    const Texture* texture = nullptr;  // null if none
    size_t place = 0;                  // index in TexelPositions
    explicit operator bool() const { return texture != nullptr; }
    const Texture& operator*() const { return *texture; }
    const Texture* operator->() const { return texture; }
  };
  struct NormalMap {
    Slot slot;
    float scale = 1.0f;
    explicit operator bool() const { return bool(slot); }
    Vec3f at(const TexelCorners& corners) const;  // unit, in tangent space
  };
  static Vec4f read(const Slot& slot, const TexelPositions& texels) {
    return slot->read(texels.place[slot.place]);
  }

  // Colours are multiplied in the colour space of the description. The product is converted at the
  // end.
  Rgb to_working_space(const Rgb& c) const {
    if (to_working_) [[unlikely]]
      return *to_working_ * c;
    return c;
  }
  // The result of evaluate() without textures and vertex colours.
  MaterialPoint constant_point() const;
  void evaluate_varying(const SurfaceAttributes& attributes, const TexelPositions& texels,
                        MaterialPoint& out) const;
  void apply_layer_textures(const TexelPositions& texels, MaterialLayers& out) const;
  Rgb varying_emission(const SurfaceAttributes& attributes, float u_texture) const;
  void apply_textures(const TexelPositions& texels, Rgb& base_color, MaterialPoint& out) const;
  Slot add_texture(const TextureRef& ref, bool srgb, const char* slot,
                   const MaterialDescription& description, const SceneDescription& scene,
                   std::deque<Texture>* textures);
  Slot slot_of(const Texture& texture);
  // Each of these functions compiles one part of the material. `add` creates the texture of a slot.
  void compile_base(const MaterialDescription& d, const auto& add);
  void compile_layers(const MaterialDescription& d, const auto& add);
  void compile_diffuse_transmission(const MaterialDescription& d, const auto& add);
  void compile_anisotropy(const MaterialDescription& d, const auto& add);
  void compile_iridescence(const MaterialDescription& d, const auto& add);
  void compile_sheen(const MaterialDescription& d, const auto& add);
  void compile_clearcoat(const MaterialDescription& d, const auto& add);
  void compile_interior(const MaterialDescription& d);
  void compile_coverage();
  // Whether the material is metallic everywhere and thus transmits nothing.
  bool always_metal() const { return metallic_ == 1.0f && !metallic_roughness_texture_; }
  const Vec2f& uv_of(const Texture& texture, const SurfaceAttributes& a) const {
    return a.uv[size_t(texture.uv_set())];
  }

  Rgb base_color_;
  float alpha_;
  float metallic_, roughness_;
  float ior_, specular_;
  Rgb specular_color_;
  Slot specular_texture_;
  Slot specular_color_texture_;
  Slot glossiness_texture_;
  Rgb emission_;
  std::shared_ptr<const TimeCurve<Rgb>> emission_scale_;
  float alpha_cutoff_;
  float transmission_ = 0.0f;
  bool thin_walled_ = true;
  Rgb attenuation_ = Rgb(0.0f);
  float dispersion_ = 0.0f;
  Slot base_color_texture_;
  Slot metallic_roughness_texture_;
  NormalMap normal_map_;
  Slot emission_texture_;
  Slot transmission_texture_;
  AlphaMode alpha_mode_;
  bool alpha_varies_ = false;  // not counting vertex colours
  bool is_emissive_ = false;
  bool emission_varies_ = false;
  MaterialPoint constant_;
  bool has_layers_ = false;
  bool layers_vary_ = false;  // whether textures vary the layers
  MaterialLayers layers_;
  float iridescence_thickness_minimum_ = 0.0f;
  Slot anisotropy_texture_;
  Slot iridescence_texture_;
  Slot iridescence_thickness_texture_;
  Slot diffuse_transmission_texture_;
  Slot diffuse_transmission_color_texture_;
  Slot sheen_color_texture_;
  Slot sheen_roughness_texture_;
  Slot clearcoat_texture_;
  Slot clearcoat_roughness_texture_;
  NormalMap clearcoat_normal_map_;
  bool double_sided_;
  bool unlit_;
  uint32_t uv_mask_ = 0;
  std::vector<const Texture*> parametrisations_;  // one texture for each parametrisation
  std::vector<Slot> slots_;                       // each texture once
  ToWorkingSpace to_working_;
};

// All materials of a scene, followed by glTF's default material.
class MaterialSet {
 public:
  // If `used_materials` is not empty, it tells for each material whether a placed mesh uses it.
  // Unused materials are not compiled, keep no textures and add nothing to features(). Throws
  // InputError like Material.
  explicit MaterialSet(const SceneDescription& scene, const std::vector<bool>& used_materials = {});
  MaterialSet(MaterialSet&&) = default;
  MaterialSet& operator=(MaterialSet&&) = default;

  // Index -1 is the default material.
  const Material& operator[](int index) const {
    return materials_[index < 0 ? materials_.size() - 1 : size_t(index)];
  }
  size_t size() const { return materials_.size() - 1; }

  // The following functions are for the report.
  uint64_t texture_bytes() const { return texture_bytes_; }  // resident texels, each image once
  uint64_t texture_file_bytes() const { return texture_file_bytes_; }  // texels kept in a file
  uint64_t bytes() const;  // resident texels, Texture objects and materials
  // Features that the scene's materials use: "textures (2 images)", "normal maps", "emission",
  // "transmission", "absorption", "dispersion", "diffuse transmission", "anisotropy",
  // "iridescence", "sheen", "clear coat", "unlit", "double-sided". Empty for a plain scene.
  // Coverage is not included, since it also depends on the meshes' vertex colours.
  const std::vector<std::string>& features() const { return features_; }

 private:
  std::deque<Texture> textures_;
  std::vector<Material> materials_;
  std::vector<std::string> features_;
  uint64_t texture_bytes_ = 0, texture_file_bytes_ = 0;
};

}  // namespace emberline
