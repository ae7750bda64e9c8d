#include "renderer/shading/material.h"

#include <algorithm>
#include <cassert>
#include <set>
#include <string>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"
#include "renderer/shading/lobes/anisotropic_ggx.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {

namespace {

float saturate(float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; }  // 0 for NaN

Rgb saturate(const Rgb& c) { return {saturate(c.x), saturate(c.y), saturate(c.z)}; }

float non_negative(float x) { return x > 0.0f && std::isfinite(x) ? x : 0.0f; }

Rgb non_negative(const Rgb& c) { return {non_negative(c.x), non_negative(c.y), non_negative(c.z)}; }

// Replaces an invalid index of refraction by `otherwise`.
float usable_ior(float ior, float otherwise) {
  return ior >= 1.0f ? std::min(ior, 1e4f) : otherwise;
}

float usable_scale(float scale) { return std::isfinite(scale) ? scale : 1.0f; }

// Clamps a film thickness (in nanometres) to a millimetre. A film of a millimetre shows no colours,
// but its phases can still be computed precisely.
float usable_thickness(float thickness) { return std::min(non_negative(thickness), 1e6f); }

// Returns the unit direction that a texel's red and green encode. If they encode none, returns the
// direction of the tangent.
Vec2f direction_of(const Vec4f& texel) {
  const Vec3f d = normalize_or(Vec3f(2.0f * texel.x - 1.0f, 2.0f * texel.y - 1.0f, 0.0f),
                               Vec3f(1.0f, 0.0f, 0.0f));
  return {d.x, d.y};
}

// Rotates `direction` counter-clockwise by the angle from the x axis to `turn`.
Vec2f rotate(const Vec2f& direction, const Vec2f& turn) {
  return {turn.x * direction.x - turn.y * direction.y, turn.y * direction.x + turn.x * direction.y};
}

Rgb rgb(const Vec4f& v) { return {v.x, v.y, v.z}; }

}  // namespace

Material::Slot Material::add_texture(const TextureRef& ref, bool srgb, const char* slot,
                                     const MaterialDescription& description,
                                     const SceneDescription& scene, std::deque<Texture>* textures) {
  if (ref.image < 0) return {};
  assert(size_t(ref.image) < scene.images.size() && scene.images[size_t(ref.image)]);
  if (ref.uv_set < 0 || ref.uv_set >= kMaxUvSets) {
    throw InputError(scene.file, "material \"" + shortened(description.name) + "\": its " + slot +
                                     " uses TEXCOORD_" + std::to_string(ref.uv_set) +
                                     "; sets 0 to " + std::to_string(kMaxUvSets - 1) +
                                     " are supported");
  }
  uv_mask_ |= 1u << ref.uv_set;
  Texture texture(scene.images[size_t(ref.image)], ref, srgb);
  const auto existing = std::find_if(textures->begin(), textures->end(),
                                     [&](const Texture& other) { return texture.same_use(other); });
  return slot_of(existing != textures->end() ? *existing
                                             : textures->emplace_back(std::move(texture)));
}

Material::Slot Material::slot_of(const Texture& texture) {
  const auto same =
      std::find_if(parametrisations_.begin(), parametrisations_.end(),
                   [&](const Texture* other) { return texture.same_parametrisation(*other); });
  const Slot slot{&texture, size_t(same - parametrisations_.begin())};
  if (same == parametrisations_.end()) parametrisations_.push_back(&texture);
  const auto is_same = [&](const Slot& other) { return other.texture == &texture; };
  if (std::none_of(slots_.begin(), slots_.end(), is_same)) slots_.push_back(slot);
  assert(parametrisations_.size() <= TexelPositions::kMaxPositions);
  return slot;
}

Material::Material(const MaterialDescription& d, const SceneDescription& scene,
                   std::deque<Texture>* textures)
    : base_color_(non_negative(d.base_color)),
      alpha_(saturate(d.alpha)),
      metallic_(saturate(d.metallic)),
      roughness_(saturate(d.roughness)),
      ior_(d.ior == 0.0f ? 0.0f : usable_ior(d.ior, 1.5f)),
      specular_(saturate(d.specular)),
      specular_color_(non_negative(d.specular_color)),
      emission_(non_negative(d.emission)),
      alpha_cutoff_(d.alpha_cutoff),
      alpha_mode_(d.alpha_mode),
      double_sided_(d.double_sided),
      unlit_(d.unlit),
      to_working_(scene.to_working) {
  const auto add = [&](const TextureRef& ref, bool srgb, const char* slot) {
    return add_texture(ref, srgb, slot, d, scene, textures);
  };
  // A scale of 0 flattens the map completely, so that its texture is not needed.
  const auto add_normal_map = [&](const TextureRef& ref, float scale, const char* slot) {
    const float s = usable_scale(scale);
    return NormalMap{s != 0.0f ? add(ref, false, slot) : Slot{}, s};
  };
  base_color_texture_ = add(d.base_color_texture, true, "base colour texture");
  if (!unlit_) {
    compile_base(d, add);
    compile_layers(d, [&](const TextureRef& ref, bool srgb, const char* slot) {
      const Slot texture = add(ref, srgb, slot);
      layers_vary_ = layers_vary_ || texture;
      return texture;
    });
    normal_map_ = add_normal_map(d.normal_texture, d.normal_scale, "normal texture");
    if (layers().clearcoat > 0.0f) {
      clearcoat_normal_map_ = add_normal_map(d.clearcoat_normal_texture, d.clearcoat_normal_scale,
                                             "clear coat normal texture");
      layers_.has_clearcoat_normal_map = bool(clearcoat_normal_map_);
      layers_vary_ = layers_vary_ || clearcoat_normal_map_;
    }
    compile_interior(d);
  }
  compile_coverage();
  emission_varies_ = unlit_ || emission_texture_;
  constant_ = constant_point();
}

void Material::compile_base(const MaterialDescription& d, const auto& add) {
  metallic_roughness_texture_ =
      add(d.metallic_roughness_texture, false, "metallic-roughness texture");
  if (roughness_ < 1.0f)
    glossiness_texture_ = add(d.glossiness_texture, true, "glossiness texture");
  if (specular_ > 0.0f) {
    specular_texture_ = add(d.specular_texture, false, "specular texture");
    if (!is_black(specular_color_)) {
      specular_color_texture_ = add(d.specular_color_texture, true, "specular colour texture");
    }
  }
  if (!always_metal()) transmission_ = saturate(d.transmission);
  if (has_transmission()) {
    transmission_texture_ = add(d.transmission_texture, false, "transmission texture");
  }
  is_emissive_ = !is_black(emission_);
  if (!is_emissive_) return;
  emission_texture_ = add(d.emission_texture, true, "emissive texture");
  emission_scale_ = converted(to_working_, d.emission_scale, emission_);
}

void Material::compile_layers(const MaterialDescription& d, const auto& add) {
  compile_diffuse_transmission(d, add);
  compile_anisotropy(d, add);
  compile_iridescence(d, add);
  compile_sheen(d, add);
  compile_clearcoat(d, add);
  const LayerParameters& p = layers();
  has_layers_ = p.anisotropy > 0.0f || p.iridescence > 0.0f || p.diffuse_transmission > 0.0f ||
                !is_black(p.sheen_color) || p.clearcoat > 0.0f;
}

void Material::compile_diffuse_transmission(const MaterialDescription& d, const auto& add) {
  LayerParameters& p = layers_.parameters;
  if (!always_metal()) p.diffuse_transmission = saturate(d.diffuse_transmission);
  if (!has_diffuse_transmission()) return;
  diffuse_transmission_texture_ =
      add(d.diffuse_transmission_texture, false, "diffuse transmission texture");
  p.diffuse_transmission_color = saturate(d.diffuse_transmission_color);
  if (is_black(p.diffuse_transmission_color)) return;
  diffuse_transmission_color_texture_ =
      add(d.diffuse_transmission_color_texture, true, "diffuse transmission colour texture");
  if (!diffuse_transmission_color_texture_) {
    p.diffuse_transmission_color = saturate(to_working_space(p.diffuse_transmission_color));
  }
}

void Material::compile_anisotropy(const MaterialDescription& d, const auto& add) {
  LayerParameters& p = layers_.parameters;
  p.anisotropy = saturate(d.anisotropy);
  if (p.anisotropy == 0.0f) return;
  AnisotropicAlbedo::prepare();
  const float angle = std::isfinite(d.anisotropy_rotation) ? d.anisotropy_rotation : 0.0f;
  p.anisotropy_direction = Vec2f(std::cos(angle), std::sin(angle));
  anisotropy_texture_ = add(d.anisotropy_texture, false, "anisotropy texture");
}

void Material::compile_iridescence(const MaterialDescription& d, const auto& add) {
  LayerParameters& p = layers_.parameters;
  const float minimum = usable_thickness(d.iridescence_thickness_minimum);
  const float maximum = usable_thickness(d.iridescence_thickness_maximum);
  const bool varies = d.iridescence_thickness_texture.image >= 0 && minimum != maximum;
  // A film of thickness 0 has no effect.
  if (maximum > 0.0f || (varies && minimum > 0.0f)) p.iridescence = saturate(d.iridescence);
  if (p.iridescence == 0.0f) return;
  iridescence_texture_ = add(d.iridescence_texture, false, "iridescence texture");
  p.iridescence_ior = usable_ior(d.iridescence_ior, 1.3f);
  p.iridescence_thickness = maximum;
  if (!varies) return;
  iridescence_thickness_minimum_ = minimum;
  iridescence_thickness_texture_ =
      add(d.iridescence_thickness_texture, false, "iridescence thickness texture");
}

void Material::compile_sheen(const MaterialDescription& d, const auto& add) {
  LayerParameters& p = layers_.parameters;
  p.sheen_color = saturate(d.sheen_color);
  if (is_black(p.sheen_color)) return;
  sheen_color_texture_ = add(d.sheen_color_texture, true, "sheen colour texture");
  if (!sheen_color_texture_) p.sheen_color = saturate(to_working_space(p.sheen_color));
  p.sheen_roughness = saturate(d.sheen_roughness);
  if (p.sheen_roughness == 0.0f) return;
  sheen_roughness_texture_ = add(d.sheen_roughness_texture, false, "sheen roughness texture");
}

void Material::compile_clearcoat(const MaterialDescription& d, const auto& add) {
  LayerParameters& p = layers_.parameters;
  p.clearcoat = saturate(d.clearcoat);
  if (p.clearcoat == 0.0f) return;
  clearcoat_texture_ = add(d.clearcoat_texture, false, "clear coat texture");
  p.clearcoat_roughness = saturate(d.clearcoat_roughness);
  if (p.clearcoat_roughness > 0.0f) {
    clearcoat_roughness_texture_ =
        add(d.clearcoat_roughness_texture, false, "clear coat roughness texture");
  }
}

void Material::compile_interior(const MaterialDescription& d) {
  if (!is_transmissive() || d.thin_walled) return;
  thin_walled_ = false;
  attenuation_ = attenuation_coefficient(saturate(to_working_space(saturate(d.attenuation_color))),
                                         d.attenuation_distance);
  // An index of 0, which reflects everything, has no dispersion.
  if (has_transmission() && ior_ > 0.0f) dispersion_ = non_negative(d.dispersion);
}

bool Material::is_clear_solid() const {
  const bool plain = !base_color_texture_ && !transmission_texture_ &&
                     !metallic_roughness_texture_ && !specular_texture_ &&
                     !specular_color_texture_ && !has_layers_;
  return plain && is_solid() && transmission_ == 1.0f && metallic_ == 0.0f &&
         base_color_ == Rgb(1.0f) && specular_ == 1.0f && specular_color_ == Rgb(1.0f) &&
         alpha_mode_ == AlphaMode::kOpaque && !is_emissive_ && !unlit_;
}

// Finds out whether alpha has an effect. Coverage costs time for every ray, and exporters often
// write rgba images that are opaque.
void Material::compile_coverage() {
  if (alpha_mode_ == AlphaMode::kOpaque) return;
  const float opaque = alpha_mode_ == AlphaMode::kMask ? alpha_cutoff_ : 1.0f;
  alpha_varies_ = alpha_ < opaque || (base_color_texture_ && !base_color_texture_->is_opaque());
}

MaterialPoint Material::constant_point() const {
  MaterialPoint point;
  point.emission = unlit_              ? non_negative(to_working_space(base_color_))
                   : emission_texture_ ? emission_
                                       : to_working_space(emission_);
  point.bsdf.base_color = saturate(to_working_space(base_color_));
  point.bsdf.metallic = metallic_;
  point.bsdf.roughness = roughness_;
  point.bsdf.ior = ior_;
  point.bsdf.specular = specular_;
  point.bsdf.specular_color =
      specular_color_texture_ ? specular_color_ : to_working_space(specular_color_);
  point.bsdf.transmission = transmission_;
  point.bsdf.thin_walled = thin_walled_;
  return point;
}

void Material::find_texels(const SurfaceAttributes& a, float u_texture, TexelPositions* out) const {
  for (size_t i = 0; i < parametrisations_.size(); ++i) {
    const Texture& texture = *parametrisations_[i];
    const TexelCorners corners = texture.corners(uv_of(texture, a));
    out->place[i] = texture.choose(corners, u_texture);
    if (normal_map_ && i == normal_map_.slot.place) out->normal = corners;
    if (clearcoat_normal_map_ && i == clearcoat_normal_map_.slot.place) {
      out->clearcoat_normal = corners;
    }
  }
  for (const Slot& slot : slots_) slot.texture->prefetch(out->place[slot.place]);
  if (normal_map_) normal_map_.slot->prefetch(out->normal);
  if (clearcoat_normal_map_) clearcoat_normal_map_.slot->prefetch(out->clearcoat_normal);
}

Vec3f Material::NormalMap::at(const TexelCorners& corners) const {
  const Vec4f texel = slot->read(corners);
  const Vec3f n = fma(Vec3f(texel.x, texel.y, texel.z), 2.0f, Vec3f(-1.0f));
  return normalize_or(Vec3f(n.x * scale, n.y * scale, n.z), Vec3f(0.0f, 0.0f, 1.0f));
}

void Material::evaluate_varying(const SurfaceAttributes& a, const TexelPositions& texels,
                                MaterialPoint& out) const {
  Rgb base = base_color_ * rgb(a.color);
  if (needs_uv()) apply_textures(texels, base, out);
  base = to_working_space(base);
  if (unlit_) out.emission = non_negative(base);
  out.bsdf.base_color = saturate(base);
}

void Material::apply_textures(const TexelPositions& texels, Rgb& base, MaterialPoint& out) const {
  if (base_color_texture_) base *= rgb(read(base_color_texture_, texels));
  if (specular_texture_) {
    out.bsdf.specular *= read(specular_texture_, texels).w;
  }
  if (specular_color_texture_) {
    out.bsdf.specular_color =
        to_working_space(out.bsdf.specular_color * rgb(read(specular_color_texture_, texels)));
  }
  if (glossiness_texture_) {
    const float glossiness = (1.0f - roughness_) * read(glossiness_texture_, texels).w;
    out.bsdf.roughness = saturate(1.0f - glossiness);
  }
  if (metallic_roughness_texture_) {
    const Vec4f texel = read(metallic_roughness_texture_, texels);
    out.bsdf.roughness = saturate(roughness_ * texel.y);
    out.bsdf.metallic = saturate(metallic_ * texel.z);
  }
  if (transmission_texture_) {
    out.bsdf.transmission = saturate(transmission_ * read(transmission_texture_, texels).x);
  }
  if (emission_texture_) {
    out.emission = to_working_space(out.emission * rgb(read(emission_texture_, texels)));
  }
  out.has_normal_map = has_normal_map();
  if (out.has_normal_map) out.normal = normal_map_.at(texels.normal);
}

void Material::apply_layer_textures(const TexelPositions& texels, MaterialLayers& out) const {
  LayerParameters& p = out.parameters;
  // Multiplies the value by one channel of the slot's texel.
  const auto scale = [&](float& value, Slot slot, int channel) {
    if (slot) value = saturate(value * read(slot, texels)[channel]);
  };
  const auto tint = [&](Rgb& value, Slot slot) {
    if (slot) value = saturate(to_working_space(value * rgb(read(slot, texels))));
  };
  if (anisotropy_texture_) {
    const Vec4f texel = read(anisotropy_texture_, texels);
    p.anisotropy = saturate(p.anisotropy * texel.z);
    p.anisotropy_direction = rotate(direction_of(texel), p.anisotropy_direction);
  }
  scale(p.iridescence, iridescence_texture_, 0);
  if (iridescence_thickness_texture_) {
    const float share = saturate(read(iridescence_thickness_texture_, texels).y);
    p.iridescence_thickness = lerp(iridescence_thickness_minimum_, p.iridescence_thickness, share);
  }
  scale(p.diffuse_transmission, diffuse_transmission_texture_, 3);
  tint(p.diffuse_transmission_color, diffuse_transmission_color_texture_);
  tint(p.sheen_color, sheen_color_texture_);
  scale(p.sheen_roughness, sheen_roughness_texture_, 3);
  scale(p.clearcoat, clearcoat_texture_, 0);
  scale(p.clearcoat_roughness, clearcoat_roughness_texture_, 1);
  if (clearcoat_normal_map_) p.clearcoat_normal = clearcoat_normal_map_.at(texels.clearcoat_normal);
}

Rgb Material::varying_emission(const SurfaceAttributes& a, float u_texture) const {
  if (!unlit_) {
    return to_working_space(
        emission_ * rgb(emission_texture_->lookup(uv_of(*emission_texture_, a), u_texture)));
  }
  Rgb base = base_color_ * rgb(a.color);
  if (base_color_texture_) {
    base *= rgb(base_color_texture_->lookup(uv_of(*base_color_texture_, a), u_texture));
  }
  return non_negative(to_working_space(base));
}

Rgb Material::mean_emission(const SurfaceAttributes& a0, const SurfaceAttributes& a1,
                            const SurfaceAttributes& a2) const {
  if (!is_emissive_) return Rgb(0.0f);
  if (!emission_texture_) return emission();
  const Texture& t = *emission_texture_;
  return to_working_space(emission_ *
                          t.mean_over_triangle(uv_of(t, a0), uv_of(t, a1), uv_of(t, a2)));
}

bool Material::has_same_emission(const Material& other) const {
  if (!is_emissive_ && !other.is_emissive_) return true;
  const Texture* a = emission_texture_ ? &*emission_texture_ : nullptr;
  const Texture* b = other.emission_texture_ ? &*other.emission_texture_ : nullptr;
  return is_emissive_ == other.is_emissive_ && emission_ == other.emission_ &&
         (a && b ? a->same_use(*b) : a == b) &&
         (double_sided_ || is_transmissive()) == (other.double_sided_ || other.is_transmissive());
}

float Material::coverage(const SurfaceAttributes& a, float u_texture) const {
  if (alpha_mode_ == AlphaMode::kOpaque) return 1.0f;
  float alpha = alpha_ * a.color.w;
  if (alpha_mode_ == AlphaMode::kMask) {
    // Alpha is filtered first, then compared with the cutoff. The reverse order would give another
    // result.
    if (base_color_texture_) {
      alpha *= base_color_texture_->bilinear_alpha(uv_of(*base_color_texture_, a));
    }
    return alpha >= alpha_cutoff_ ? 1.0f : 0.0f;
  }
  if (base_color_texture_ && base_color_texture_->has_alpha_channel()) {
    alpha *= base_color_texture_->lookup(uv_of(*base_color_texture_, a), u_texture).w;
  }
  return saturate(alpha);
}

MaterialSet::MaterialSet(const SceneDescription& scene, const std::vector<bool>& used_materials) {
  assert(used_materials.empty() || used_materials.size() == scene.materials.size());
  materials_.reserve(scene.materials.size() + 1);
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const bool used = used_materials.empty() || used_materials[i];
    materials_.emplace_back(used ? scene.materials[i] : MaterialDescription{}, scene, &textures_);
  }
  materials_.emplace_back(MaterialDescription{}, scene, &textures_);

  std::set<const Image*> images;
  for (const Texture& texture : textures_) images.insert(&texture.image());
  for (const Image* image : images) {
    (image->mapped ? texture_file_bytes_ : texture_bytes_) += image->byte_count();
  }

  const auto any = [&](auto has) { return std::any_of(materials_.begin(), materials_.end(), has); };
  const auto note = [&](bool used, const char* name) {
    if (used) features_.emplace_back(name);
  };
  if (!textures_.empty()) {
    features_.push_back("textures (" + std::to_string(images.size()) +
                        (images.size() == 1 ? " image" : " images") +
                        (texture_file_bytes_ > 0 ? ", in a temporary file)" : ")"));
  }
  note(any([](const Material& m) { return m.has_normal_map(); }), "normal maps");
  note(any([](const Material& m) { return m.is_emissive(); }), "emission");
  note(any([](const Material& m) { return m.has_transmission(); }), "transmission");
  note(any([](const Material& m) { return !is_black(m.attenuation()); }), "absorption");
  note(any([](const Material& m) { return m.dispersion() > 0.0f; }), "dispersion");
  note(any([](const Material& m) { return m.has_diffuse_transmission(); }), "diffuse transmission");
  note(any([](const Material& m) { return m.layers().anisotropy > 0.0f; }), "anisotropy");
  note(any([](const Material& m) { return m.layers().iridescence > 0.0f; }), "iridescence");
  note(any([](const Material& m) { return !is_black(m.layers().sheen_color); }), "sheen");
  note(any([](const Material& m) { return m.layers().clearcoat > 0.0f; }), "clear coat");
  note(any([](const Material& m) { return m.unlit(); }), "unlit");
  note(any([](const Material& m) { return m.double_sided(); }), "double-sided");
}

uint64_t MaterialSet::bytes() const {
  return texture_bytes_ + textures_.size() * sizeof(Texture) + materials_.size() * sizeof(Material);
}

}  // namespace emberline
