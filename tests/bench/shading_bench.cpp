// Benchmarks of textures and scattering functions.
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/parts.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/texture.h"

namespace emberline::bench {
namespace {

constexpr int kTextureSize = 2048;

std::shared_ptr<const Image> noise(TexelType type) {
  auto image = std::make_shared<Image>();
  image->width = image->height = kTextureSize;
  image->channels = 4;
  image->type = type;
  const size_t values = size_t(kTextureSize) * kTextureSize * 4;
  if (type == TexelType::kUint8) {
    image->texels.resize(values);
    for (size_t i = 0; i < values; ++i) image->texels[i] = std::byte(hash32(uint32_t(i)) >> 24);
  } else {
    image->texels.resize(values * sizeof(float));
    auto* const texels = reinterpret_cast<float*>(image->texels.data());
    for (size_t i = 0; i < values; ++i) texels[i] = to_unit_float(hash32(uint32_t(i)));
  }
  return image;
}

// Returns a point for coherent look-ups. The look-ups of a pixel's samples lie within a texel or
// two, and the pixel drifts.
Vec2f coherent_point(uint32_t i) {
  const Vec2f pixel(float(i / 16 % 64) / 64, float(i / 1024) / 64);
  return pixel + random_point(6, i) * (2.0f / kTextureSize);
}

void add_textures() {
  struct Kind {
    const char* name;
    TexelType type;
    bool srgb;
  };
  for (const Kind& kind :
       {Kind{"byte_srgb", TexelType::kUint8, true}, Kind{"byte_linear", TexelType::kUint8, false},
        Kind{"float", TexelType::kFloat, false}}) {
    TextureRef ref;
    ref.image = 0;
    const auto texture = std::make_shared<const Texture>(noise(kind.type), ref, kind.srgb);
    for (const bool random : {false, true}) {
      // There are more points than fit into the caches, so they are computed instead of read from a
      // list.
      const auto place = [random](uint32_t i) {
        return random ? random_point(7, i) : coherent_point(i);
      };
      const std::string name =
          std::string("texture/") + kind.name + (random ? "/random" : "/coherent");
      add_benchmark(name + "/lookup", [texture, place, i = 0u]() mutable {
        ++i;
        return texture->lookup(place(i), random_unit(8, i)).x;
      });
      add_benchmark(name + "/bilinear",
                    [texture, place, i = 0u]() mutable { return texture->bilinear(place(++i)).x; });
    }
  }
  add_benchmark("texture/the_inputs_alone/random", [i = 0u]() mutable {
    ++i;
    return random_point(7, i).x + random_unit(8, i);
  });
}

struct Surface {
  const char* name;
  BsdfParameters parameters;
  std::optional<LayerParameters> layers = {};

  SurfaceBsdf at(const Vec3f& wo, const Vec3f& ng = Vec3f(0.0f, 0.0f, 1.0f)) const {
    return layers ? SurfaceBsdf(parameters, *layers, wo, ng) : SurfaceBsdf(parameters, wo, ng);
  }
};

// Adds surfaces, each with one more lobe on a rough dielectric or metal.
void add_layered(std::vector<Surface>& list) {
  const auto add = [&list](const char* name, float metallic, const LayerParameters& layers) {
    BsdfParameters p;
    p.base_color = Rgb(0.8f, 0.5f, 0.3f);
    p.metallic = metallic;
    p.roughness = 0.3f;
    list.push_back({name, p, layers});
  };
  add("list_of_base_alone", 0.0f, {});
  add("coat_smooth", 0.0f, {.clearcoat = 1.0f});
  add("coat_rough", 0.0f, {.clearcoat = 1.0f, .clearcoat_roughness = 0.3f});
  add("sheen", 0.0f, {.sheen_color = Rgb(0.8f), .sheen_roughness = 0.4f});
  add("stretched_metal", 1.0f, {.anisotropy = 0.7f});
  add("film_on_metal", 1.0f, {.iridescence = 1.0f, .iridescence_thickness = 400.0f});
  add("film_on_dielectric", 0.0f, {.iridescence = 1.0f, .iridescence_thickness = 400.0f});
  add("diffuse_transmission", 0.0f, {.diffuse_transmission = 0.5f});
}

std::vector<Surface> surfaces() {
  std::vector<Surface> list;
  const auto add = [&list](const char* name, const auto& change) {
    BsdfParameters p;
    p.base_color = Rgb(0.8f, 0.5f, 0.3f);
    change(p);
    list.push_back({name, p});
  };
  using P = BsdfParameters;
  add("lambert", [](P& p) { p.specular = 0.0f; });
  add("dielectric_rough", [](P& p) { p.roughness = 0.5f; });
  add("dielectric_smooth", [](P& p) { p.roughness = 0.0f; });
  add("metal_rough", [](P& p) {
    p.metallic = 1.0f;
    p.roughness = 0.3f;
  });
  add("mirror", [](P& p) {
    p.metallic = 1.0f;
    p.roughness = 0.0f;
  });
  add("half_metal", [](P& p) {
    p.metallic = 0.5f;
    p.roughness = 0.4f;
  });
  add("glass_smooth", [](P& p) {
    p.transmission = 1.0f;
    p.roughness = 0.0f;
    p.thin_walled = false;
  });
  add("glass_rough", [](P& p) {
    p.transmission = 1.0f;
    p.roughness = 0.3f;
    p.thin_walled = false;
  });
  add("pane_rough", [](P& p) {
    p.transmission = 1.0f;
    p.roughness = 0.3f;
  });
  add_layered(list);
  return list;
}

// Returns a direction away from the horizon, since lobes return early near the horizon.
Vec3f upward(uint32_t stream, uint32_t i) {
  const Vec3f w = square_to_cosine_hemisphere(random_point(stream, i));
  return normalize(Vec3f(w.x, w.y, w.z + 0.05f));
}

void add_bsdfs() {
  for (const Surface& surface : surfaces()) {
    const std::string name = std::string("bsdf/") + surface.name;
    add_benchmark(name + "/construct",
                  [surface, wo = inputs([](uint32_t i) { return upward(10, i); })]() mutable {
                    return surface.at(wo()).albedo().x;
                  });
    add_benchmark(name + "/construct_bent",
                  [surface, wo = inputs([](uint32_t i) { return upward(10, i); })]() mutable {
                    const Vec3f ng = normalize(Vec3f(0.1f, 0.0f, 1.0f));
                    return surface.at(wo(), ng).albedo().x;
                  });
    // There are few enough to stay in the cache, as in a render, and enough for different wo.
    const auto made = std::make_shared<std::vector<SurfaceBsdf>>();
    for (uint32_t i = 0; i < 64; ++i) made->push_back(surface.at(upward(10, i)));
    add_benchmark(
        name + "/sample",
        [made, u = inputs([](uint32_t i) { return random_point(11, i); }), i = 0u]() mutable {
          const Vec2f& point = u();
          const BsdfSample s = (*made)[++i % 64].sample(u().x, point);
          return s.weight.x + s.pdf + s.wi.z;
        });
    add_benchmark(name + "/eval_and_pdf",
                  [made, wi = inputs([](uint32_t i) { return upward(12, i); }), i = 0u]() mutable {
                    float pdf = 0.0f;
                    return (*made)[++i % 64].eval_and_pdf(wi(), &pdf).x + pdf;
                  });
  }
}

}  // namespace

void add_shading_benchmarks() {
  add_textures();
  add_bsdfs();
}

}  // namespace emberline::bench
