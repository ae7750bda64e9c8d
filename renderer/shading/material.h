// Materials as a frame needs them: constants where a slot has no texture, flags for what exists, so
// that a scene pays only for what it uses.
//
// Built once from the scene description, then read by every thread: all const functions are pure.
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

// TEXCOORD_0 .. TEXCOORD_3 can be used by a material.
inline constexpr int kMaxUvSets = 4;

// Interpolated vertex attributes at a hit. Sets that the mesh lacks are 0.
struct SurfaceAttributes {
  std::array<Vec2f, kMaxUvSets> uv;
  // COLOR_0, linear; (1, 1, 1, 1) without, and has_color says that there is none to be asked.
  Vec4f color = Vec4f(1.0f, 1.0f, 1.0f, 1.0f);
  bool has_color = false;

  SurfaceAttributes() { uv.fill(Vec2f(0.0f)); }
  // For a mesh without: the coordinates are 0, as a view of them shows; the colour is left as it
  // is, since nobody will read it. This is made at every hit.
  struct Unread {};
  explicit SurfaceAttributes(Unread) : color() { uv.fill(Vec2f(0.0f)); }
};

// What a material says at a point.
struct MaterialPoint {
  BsdfParameters bsdf;            // clamped to the ranges that SurfaceBsdf asks for
  Rgb emission = Rgb(0.0f);       // radiance, alike in all directions
  Vec3f normal = Vec3f(0, 0, 1);  // tangent space, unit; see mapped_normal()
  bool has_normal_map = false;
};

// Where a material's textures are read for a point, one place for each of its parametrisations.
struct TexelPlaces {
  static constexpr size_t kMost = 18;  // a parametrisation for each slot
  size_t place[kMost];
  TexelCorners normal, clearcoat_normal;
  TexelPlaces() {}  // made at every hit: nothing to be cleared
};

class Material {
 public:
  // `textures` owns what the slots point to; the material keeps pointers into it, so it must
  // outlive the material and not move its elements (a deque does not, on growth). Equal uses of an
  // image share one Texture. Throws InputError for a texture that asks for a UV set beyond
  // kMaxUvSets.
  Material(const MaterialDescription& description, const SceneDescription& scene,
           std::deque<Texture>* textures);

  // One number for all textures: slots that share a parametrisation then take the same texel, so
  // that base colour and roughness belong together. Normal maps are filtered.
  // In two steps, so that whoever shades many points can have the texels of all on their way before
  // the first is read.
  void find_texels(const SurfaceAttributes& attributes, float u_texture, TexelPlaces* out) const;
  void evaluate(const SurfaceAttributes& attributes, const TexelPlaces& texels,
                MaterialPoint& out) const {
    out = constant_;
    if (needs_uv() || attributes.has_color) evaluate_varying(attributes, texels, out);
  }
  // What evaluate() leaves out; only where has_layers().
  void evaluate_layers(const TexelPlaces& texels, MaterialLayers& out) const {
    out = layers_;
    if (layers_vary_) apply_layer_textures(texels, out);
  }
  bool has_layers() const { return has_layers_; }  // any of them can have an effect
  // What they are where no texture has a say; with one, its factor.
  const LayerParameters& layers() const { return layers_.parameters; }

  // Emitted radiance below any clear coat (emission_through_coat); with unlit(), the base colour.
  Rgb emission(const SurfaceAttributes& attributes, float u_texture) const {
    return emission_varies_ ? varying_emission(attributes, u_texture) : emission();
  }
  const Rgb& emission() const { return constant_.emission; }  // if it is the same everywhere
  // All of the above at its brightest. What there is of it at a time of the shutter, if it changes.
  bool emission_changes() const { return emission_share_ != nullptr; }
  Rgb emission_share(float time) const { return emission_share_->at(time); }
  // Its mean over a triangle with these corners, for light power. 0 for unlit materials: they show
  // a colour, but are not lights.
  Rgb mean_emission(const SurfaceAttributes& a0, const SurfaceAttributes& a1,
                    const SurfaceAttributes& a2) const;

  // Probability that the surface is there at all: 1 (opaque), 0 or 1 by the cutoff on the filtered
  // alpha (mask), alpha (blend).
  float coverage(const SurfaceAttributes& attributes, float u_texture) const;

  // Whether coverage() can be anything but 1. A mesh with vertex colours may have alpha in them.
  bool has_alpha(bool vertex_colors) const {
    return alpha_mode() != AlphaMode::kOpaque && (alpha_varies_ || vertex_colors);
  }
  AlphaMode alpha_mode() const { return alpha_mode_; }
  // Emission and coverage are the same everywhere and in all directions: emission() needs no
  // attributes to be found.
  bool emits_evenly() const {
    return !emission_varies_ && !(layers().clearcoat > 0.0f) && alpha_mode() == AlphaMode::kOpaque;
  }
  // Whether evaluate(), coverage() or a direction in tangent space looks at the attributes of a
  // mesh with or without colours.
  bool reads_attributes(bool vertex_colors) const {
    return needs_uv() || vertex_colors || needs_tangents() || alpha_mode() != AlphaMode::kOpaque;
  }
  bool is_emissive() const { return is_emissive_; }  // belongs among the lights; never if unlit
  // Whether the lights made of the two are the same: their mean_emission() and their sides.
  bool emits_like(const Material& other) const;
  bool has_normal_map() const { return bool(normal_map_); }
  // Something of it is in the tangent space of the mesh.
  bool needs_tangents() const {
    return has_normal_map() || layers_.has_clearcoat_normal_map || layers().anisotropy > 0.0f;
  }
  bool double_sided() const { return double_sided_; }
  // Light passes through, clear or diffuse: faces are seen from behind even if single-sided, and
  // the integrator sets MaterialPoint::bsdf.inside when it is the back that was hit.
  bool passes_light() const { return has_transmission() || has_diffuse_transmission(); }
  // Light that passes goes through an interior, and not through a thin wall.
  bool is_solid() const { return !thin_walled_; }
  // A solid that is smooth and clear at least in places: only rays that it bends come through.
  bool is_smooth_solid() const {
    return has_transmission() && is_solid() &&
           (square(roughness_) < kMirrorAlpha || metallic_roughness_texture_);
  }
  // A solid of which nothing but its index and its interior shows: where it bends nothing, its face
  // is not seen.
  bool is_clear_solid() const;
  float ior() const { return ior_; }                              // 0: reflects everything
  bool has_transmission() const { return transmission_ > 0.0f; }  // clear
  bool has_diffuse_transmission() const { return layers().diffuse_transmission > 0.0f; }
  // At least in places it is a thin wall that is smooth, and light goes straight on.
  bool is_smooth_wall() const {
    return has_transmission() && thin_walled_ &&
           (square(roughness_) < kMirrorAlpha || metallic_roughness_texture_);
  }
  // Per metre travelled inside, for beer_transmittance(); 0 without an interior.
  const Rgb& attenuation() const { return attenuation_; }
  // 20 / Abbe number of what clear transmission bends; 0 where nothing does.
  float dispersion() const { return dispersion_; }
  bool unlit() const { return unlit_; }  // no scattering: emission() is what is seen
  bool needs_uv() const { return uv_mask_ != 0; }
  uint32_t uv_mask() const { return uv_mask_; }  // bit n: TEXCOORD_n is read

 private:
  struct Slot {
    const Texture* texture = nullptr;  // null: none
    size_t place = 0;                  // which of TexelPlaces
    explicit operator bool() const { return texture != nullptr; }
    const Texture& operator*() const { return *texture; }
    const Texture* operator->() const { return texture; }
  };
  struct NormalMap {
    Slot slot;
    float scale = 1.0f;
    explicit operator bool() const { return bool(slot); }
    Vec3f at(const TexelCorners& corners) const;  // tangent space, unit
  };
  static Vec4f read(const Slot& slot, const TexelPlaces& texels) {
    return slot->read(texels.place[slot.place]);
  }

  // Colours are products in the description's space, converted when they are complete.
  Rgb working(const Rgb& c) const {
    if (to_working_) [[unlikely]]
      return *to_working_ * c;
    return c;
  }
  // What evaluate() says where neither a texture nor a vertex colour has a say.
  MaterialPoint constant_point() const;
  void evaluate_varying(const SurfaceAttributes& attributes, const TexelPlaces& texels,
                        MaterialPoint& out) const;
  void apply_layer_textures(const TexelPlaces& texels, MaterialLayers& out) const;
  Rgb varying_emission(const SurfaceAttributes& attributes, float u_texture) const;
  void apply_textures(const TexelPlaces& texels, Rgb& base_color, MaterialPoint& out) const;
  Slot add_texture(const TextureRef& ref, bool srgb, const char* slot,
                   const MaterialDescription& description, const SceneDescription& scene,
                   std::deque<Texture>* textures);
  Slot slot_of(const Texture& texture);
  // What each compiles; `add` makes a texture of a slot.
  void compile_base(const MaterialDescription& d, const auto& add);
  void compile_layers(const MaterialDescription& d, const auto& add);
  void compile_diffuse_transmission(const MaterialDescription& d, const auto& add);
  void compile_anisotropy(const MaterialDescription& d, const auto& add);
  void compile_iridescence(const MaterialDescription& d, const auto& add);
  void compile_sheen(const MaterialDescription& d, const auto& add);
  void compile_clearcoat(const MaterialDescription& d, const auto& add);
  void compile_interior(const MaterialDescription& d);
  void compile_coverage();
  // A metal lets nothing through.
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
  std::shared_ptr<const TimeCurve<Rgb>> emission_share_;
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
  bool alpha_varies_ = false;  // without vertex colours
  bool is_emissive_ = false;
  bool emission_varies_ = false;
  MaterialPoint constant_;
  bool has_layers_ = false;
  bool layers_vary_ = false;  // a texture has a say
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
  std::vector<const Texture*> parametrisations_;  // a texture of each
  std::vector<Slot> slots_;                       // each texture once
  ToWorkingSpace to_working_;
};

// All materials of a scene, glTF's default material behind them.
class MaterialSet {
 public:
  // `worn`, if not empty, says of each material whether a placed mesh has it: of one that none has
  // nothing is compiled, no texture is kept and no feature named. Throws InputError as Material
  // does.
  explicit MaterialSet(const SceneDescription& scene, const std::vector<bool>& worn = {});
  MaterialSet(MaterialSet&&) = default;
  MaterialSet& operator=(MaterialSet&&) = default;

  // -1: the default material.
  const Material& operator[](int index) const {
    return materials_[index < 0 ? materials_.size() - 1 : size_t(index)];
  }
  size_t size() const { return materials_.size() - 1; }

  // For the report.
  uint64_t texture_bytes() const { return texture_bytes_; }  // resident texels, each image once
  uint64_t texture_file_bytes() const { return texture_file_bytes_; }  // of the images in a file
  uint64_t bytes() const;  // texels, tables and materials
  // What the scene's materials need, in words: "textures (2 images)", "normal maps", "emission",
  // "transmission", "absorption", "dispersion", "diffuse transmission", "anisotropy",
  // "iridescence", "sheen", "clear coat", "unlit", "double-sided". Empty for a plain scene.
  // Coverage is the meshes' affair: vertex colours have a say in it.
  const std::vector<std::string>& features() const { return features_; }

 private:
  std::deque<Texture> textures_;
  std::vector<Material> materials_;
  std::vector<std::string> features_;
  uint64_t texture_bytes_ = 0, texture_file_bytes_ = 0;
};

}  // namespace emberline
