#include "renderer/shading/material.h"

#include <algorithm>
#include <cassert>
#include <set>
#include <string>

#include "renderer/core/errors.h"
#include "renderer/shading/lobes/transmission_lobe.h"

namespace emberline {

namespace {

float saturate(float x) { return x > 0.0f ? std::min(x, 1.0f) : 0.0f; }  // NaN: 0

Rgb saturate(const Rgb& c) { return {saturate(c.x), saturate(c.y), saturate(c.z)}; }

float non_negative(float x) { return x > 0.0f && std::isfinite(x) ? x : 0.0f; }

Rgb non_negative(const Rgb& c) { return {non_negative(c.x), non_negative(c.y), non_negative(c.z)}; }

// 0 means "reflects everything"; what is no index of refraction becomes the default's.
float usable_ior(float ior) {
  if (ior == 0.0f) return 0.0f;
  return ior >= 1.0f ? std::min(ior, 1e4f) : 1.5f;
}

Rgb rgb(const Vec4f& v) { return {v.x, v.y, v.z}; }

// Whether any texel of an image with alpha is not opaque. Exporters often write rgba images that
// are opaque throughout, and a surface with coverage costs every ray a question.
bool has_transparent_texel(const Texture& texture) {
  if (!texture.has_alpha_channel()) return false;
  const Image& image = texture.image();
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (texture.texel(x, y).w < 1.0f) return true;
    }
  }
  return false;
}

}  // namespace

const Texture* Material::add_texture(const TextureRef& ref, bool srgb, const char* slot,
                                     const MaterialDescription& description,
                                     const SceneDescription& scene, std::deque<Texture>* textures) {
  if (ref.image < 0) return nullptr;
  assert(size_t(ref.image) < scene.images.size() && scene.images[size_t(ref.image)]);
  if (ref.uv_set < 0 || ref.uv_set >= kMaxUvSets) {
    throw InputError(scene.file, "material \"" + description.name + "\": its " + slot +
                                     " uses TEXCOORD_" + std::to_string(ref.uv_set) +
                                     "; sets 0 to " + std::to_string(kMaxUvSets - 1) +
                                     " are supported");
  }
  uv_mask_ |= 1u << ref.uv_set;
  Texture texture(scene.images[size_t(ref.image)], ref, srgb);
  for (const Texture& other : *textures) {
    if (texture.same_use(other)) return &other;
  }
  return &textures->emplace_back(std::move(texture));
}

Material::Material(const MaterialDescription& d, const SceneDescription& scene,
                   std::deque<Texture>* textures)
    : base_color_(non_negative(d.base_color)),
      alpha_(saturate(d.alpha)),
      metallic_(saturate(d.metallic)),
      roughness_(saturate(d.roughness)),
      ior_(usable_ior(d.ior)),
      specular_(saturate(d.specular)),
      specular_color_(non_negative(d.specular_color)),
      normal_scale_(std::isfinite(d.normal_scale) ? d.normal_scale : 1.0f),
      emission_(non_negative(d.emission)),
      alpha_cutoff_(d.alpha_cutoff),
      alpha_mode_(d.alpha_mode),
      double_sided_(d.double_sided),
      unlit_(d.unlit) {
  const auto add = [&](const TextureRef& ref, bool srgb, const char* slot) {
    return add_texture(ref, srgb, slot, d, scene, textures);
  };
  base_color_texture_ = add(d.base_color_texture, true, "base colour texture");
  if (!unlit_) {
    metallic_roughness_texture_ =
        add(d.metallic_roughness_texture, false, "metallic-roughness texture");
    if (specular_ > 0.0f) {
      specular_texture_ = add(d.specular_texture, false, "specular texture");
      specular_color_texture_ = add(d.specular_color_texture, true, "specular colour texture");
    }
    // A scale of 0 flattens the map altogether.
    if (normal_scale_ != 0.0f) normal_texture_ = add(d.normal_texture, false, "normal texture");
    is_emissive_ = !is_black(emission_);
    transmission_ =
        metallic_ < 1.0f || metallic_roughness_texture_ ? saturate(d.transmission) : 0.0f;
    if (transmission_ > 0.0f) {
      transmission_texture_ = add(d.transmission_texture, false, "transmission texture");
      thin_walled_ = d.thin_walled;
      if (!thin_walled_) {
        attenuation_ =
            attenuation_coefficient(saturate(d.attenuation_color), d.attenuation_distance);
      }
    }
    if (is_emissive_) emission_texture_ = add(d.emission_texture, true, "emissive texture");
  }
  if (alpha_mode_ != AlphaMode::kOpaque) {
    const float opaque = alpha_mode_ == AlphaMode::kMask ? alpha_cutoff_ : 1.0f;
    alpha_varies_ = alpha_ < opaque ||
                    (base_color_texture_ != nullptr && has_transparent_texel(*base_color_texture_));
  }
  emission_varies_ = unlit_ || emission_texture_ != nullptr;
  constant_ = constant_point();
}

MaterialPoint Material::constant_point() const {
  MaterialPoint point;
  point.emission = unlit_ ? non_negative(base_color_) : emission_;
  point.bsdf.base_color = saturate(base_color_);
  point.bsdf.metallic = metallic_;
  point.bsdf.roughness = roughness_;
  point.bsdf.ior = ior_;
  point.bsdf.specular = specular_;
  point.bsdf.specular_color = specular_color_;
  point.bsdf.transmission = transmission_;
  point.bsdf.thin_walled = thin_walled_;
  return point;
}

void Material::evaluate_varying(const SurfaceAttributes& a, float u_texture,
                                MaterialPoint& out) const {
  Rgb base = base_color_ * rgb(a.color);
  if (needs_uv()) apply_textures(a, u_texture, base, out);
  if (unlit_) out.emission = non_negative(base);
  out.bsdf.base_color = saturate(base);
}

void Material::apply_textures(const SurfaceAttributes& a, float u_texture, Rgb& base,
                              MaterialPoint& out) const {
  if (base_color_texture_ != nullptr) {
    base *= rgb(base_color_texture_->lookup(uv_of(*base_color_texture_, a), u_texture));
  }
  if (specular_texture_ != nullptr) {
    out.bsdf.specular *= specular_texture_->lookup(uv_of(*specular_texture_, a), u_texture).w;
  }
  if (specular_color_texture_ != nullptr) {
    const Vec4f texel =
        specular_color_texture_->lookup(uv_of(*specular_color_texture_, a), u_texture);
    out.bsdf.specular_color = specular_color_ * rgb(texel);
  }
  if (metallic_roughness_texture_ != nullptr) {
    const Vec4f texel =
        metallic_roughness_texture_->lookup(uv_of(*metallic_roughness_texture_, a), u_texture);
    out.bsdf.roughness = saturate(roughness_ * texel.y);
    out.bsdf.metallic = saturate(metallic_ * texel.z);
  }
  if (transmission_texture_ != nullptr) {
    const Vec4f texel = transmission_texture_->lookup(uv_of(*transmission_texture_, a), u_texture);
    out.bsdf.transmission = saturate(transmission_ * texel.x);
  }
  if (emission_texture_ != nullptr) {
    out.emission *= rgb(emission_texture_->lookup(uv_of(*emission_texture_, a), u_texture));
  }
  out.has_normal_map = normal_texture_ != nullptr;
  if (out.has_normal_map) {
    const Vec4f texel = normal_texture_->lookup(uv_of(*normal_texture_, a), u_texture);
    const Vec3f n = fma(Vec3f(texel.x, texel.y, texel.z), 2.0f, Vec3f(-1.0f));
    out.normal =
        normalize_or(Vec3f(n.x * normal_scale_, n.y * normal_scale_, n.z), Vec3f(0.0f, 0.0f, 1.0f));
  }
}

Rgb Material::varying_emission(const SurfaceAttributes& a, float u_texture) const {
  if (!unlit_) {
    return emission_ * rgb(emission_texture_->lookup(uv_of(*emission_texture_, a), u_texture));
  }
  Rgb base = base_color_ * rgb(a.color);
  if (base_color_texture_ != nullptr) {
    base *= rgb(base_color_texture_->lookup(uv_of(*base_color_texture_, a), u_texture));
  }
  return non_negative(base);
}

Rgb Material::mean_emission(const SurfaceAttributes& a0, const SurfaceAttributes& a1,
                            const SurfaceAttributes& a2) const {
  if (!is_emissive_) return Rgb(0.0f);
  if (emission_texture_ == nullptr) return emission_;
  const Texture& t = *emission_texture_;
  return emission_ * t.mean_over_triangle(uv_of(t, a0), uv_of(t, a1), uv_of(t, a2));
}

bool Material::emits_like(const Material& other) const {
  if (!is_emissive_ && !other.is_emissive_) return true;
  const Texture* a = emission_texture_ ? &*emission_texture_ : nullptr;
  const Texture* b = other.emission_texture_ ? &*other.emission_texture_ : nullptr;
  return is_emissive_ == other.is_emissive_ && emission_ == other.emission_ &&
         (a && b ? a->same_use(*b) : a == b) &&
         (double_sided_ || has_transmission()) == (other.double_sided_ || other.has_transmission());
}

float Material::coverage(const SurfaceAttributes& a, float u_texture) const {
  if (alpha_mode_ == AlphaMode::kOpaque) return 1.0f;
  float alpha = alpha_ * a.color.w;
  if (alpha_mode_ == AlphaMode::kMask) {
    // The cutoff is a step, and a step of a mean is not the mean of steps: the exact filter.
    if (base_color_texture_ != nullptr) {
      alpha *= base_color_texture_->bilinear_alpha(uv_of(*base_color_texture_, a));
    }
    return alpha >= alpha_cutoff_ ? 1.0f : 0.0f;
  }
  if (base_color_texture_ != nullptr && base_color_texture_->has_alpha_channel()) {
    alpha *= base_color_texture_->lookup(uv_of(*base_color_texture_, a), u_texture).w;
  }
  return saturate(alpha);
}

MaterialSet::MaterialSet(const SceneDescription& scene, const std::vector<bool>& worn) {
  assert(worn.empty() || worn.size() == scene.materials.size());
  materials_.reserve(scene.materials.size() + 1);
  for (size_t i = 0; i < scene.materials.size(); ++i) {
    const bool used = worn.empty() || worn[i];
    materials_.emplace_back(used ? scene.materials[i] : MaterialDescription{}, scene, &textures_);
  }
  materials_.emplace_back(MaterialDescription{}, scene, &textures_);

  std::set<const Image*> images;
  for (const Texture& texture : textures_) images.insert(&texture.image());
  for (const Image* image : images) texture_bytes_ += image->texels.size();
  image_count_ = images.size();

  const auto any = [&](auto has) { return std::any_of(materials_.begin(), materials_.end(), has); };
  const auto note = [&](bool used, const char* name) {
    if (used) features_.emplace_back(name);
  };
  if (!textures_.empty()) {
    features_.push_back("textures (" + std::to_string(image_count_) +
                        (image_count_ == 1 ? " image)" : " images)"));
  }
  note(any([](const Material& m) { return m.has_normal_map(); }), "normal maps");
  note(any([](const Material& m) { return m.is_emissive(); }), "emission");
  note(any([](const Material& m) { return m.has_transmission(); }), "transmission");
  note(any([](const Material& m) { return !is_black(m.attenuation()); }), "absorption");
  note(any([](const Material& m) { return m.unlit(); }), "unlit");
  note(any([](const Material& m) { return m.double_sided(); }), "double-sided");
}

uint64_t MaterialSet::bytes() const {
  return texture_bytes_ + textures_.size() * sizeof(Texture) + materials_.size() * sizeof(Material);
}

}  // namespace emberline
