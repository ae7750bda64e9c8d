// Runs each numeric kernel on fixed random numbers, and prints a hash of all bits of its results.
// This program is built twice, as usual and without optimisation, and same_output.py compares what
// the two print.
#include <bit>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <type_traits>
#include <vector>

#include "renderer/core/frame.h"
#include "renderer/core/hash.h"
#include "renderer/core/warps.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/film/filter.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_sampler.h"
#include "renderer/scene/camera.h"
#include "renderer/shading/bsdf.h"
#include "renderer/shading/shading_normal.h"
#include "renderer/shading/texture.h"
#include "samplers/sampler.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

constexpr uint32_t kRounds = 20'000;

// Random numbers in [0, 1) that the compiler cannot evaluate in advance.
class Random {
 public:
  explicit Random(uint32_t stream) : stream_(hash32(stream)) {}
  float next() { return to_unit_float(hash_combine(stream_, count_++)); }
  float between(float a, float b) { return a + (b - a) * next(); }
  Vec2f square() {
    const float x = next();
    return {x, next()};
  }
  Vec3f cube(float half) {
    const float x = between(-half, half), y = between(-half, half);
    return {x, y, between(-half, half)};
  }
  Vec3f direction() { return normalize_or(cube(1.0f), Vec3f(0, 0, 1)); }

 private:
  uint32_t stream_, count_ = 0;
};

class Bits {
 public:
  template <class Number>
  void add(Number x) requires(std::is_arithmetic_v<Number>) {
    if constexpr (std::is_same_v<Number, float>) {
      hash_ = (hash_ ^ std::bit_cast<uint32_t>(x)) * 0x100000001b3u;
    } else {
      hash_ = (hash_ ^ uint64_t(x)) * 0x100000001b3u;
    }
  }
  void add(const Vec2f& v) { add(v.x), add(v.y); }
  void add(const Vec3f& v) { add(v.x), add(v.y), add(v.z); }
  void add(const Vec4f& v) { add(v.x), add(v.y), add(v.z), add(v.w); }
  template <class First, class... Rest>
  void add(const First& first, const Rest&... rest) requires(sizeof...(Rest) > 0) {
    add(first), (add(rest), ...);
  }
  void print(const char* kernel) const {
    std::printf("%-16s %016llx\n", kernel, static_cast<unsigned long long>(hash_));
  }

 private:
  uint64_t hash_ = 0xcbf29ce484222325u;
};

void vectors() {
  Random random(1);
  Bits bits;
  for (uint32_t i = 0; i < kRounds; ++i) {
    const Vec3f a = random.cube(3.0f), b = random.cube(1e-3f), n = random.direction();
    const ShadingFrame frame = ShadingFrame::from_normal(n);
    bits.add(dot(a, b), cross(a, b), luminance(a), normalize_or(a, b), lerp(a, b, random.next()));
    bits.add(frame.to_local(a), frame.to_world(a));
    bits.add(transform_point(Mat44d().rotate(to_double(a)), to_double(b)).x);
    const SurfaceFrame surface =
        make_surface_frame(n, normalize_or(n + b, n), normalize_or(n + a * 0.2f, n), a);
    bits.add(surface.shading.tangent, surface.shading.normal);
    bits.add(mapped_normal(n, Vec4f(a.x, a.y, a.z, 1.0f), random.direction()));
  }
  bits.print("vectors");
}

void warps() {
  Random random(2);
  Bits bits;
  for (uint32_t i = 0; i < kRounds; ++i) {
    const Vec2f u = random.square();
    bits.add(square_to_disk(u), square_to_cosine_hemisphere(u), square_to_sphere(u));
    bits.add(square_to_triangle(u));
  }
  bits.print("warps");
}

void scattering() {
  Random random(3);
  Bits bits;
  for (uint32_t i = 0; i < kRounds; ++i) {
    BsdfParameters p;
    p.base_color = Rgb{random.next(), random.next(), random.next()};
    p.metallic = i % 3 == 0 ? random.next() : float(i % 2);
    p.roughness = i % 7 == 0 ? 0.0f : random.next();
    p.ior = random.between(1.0f, 2.5f);
    p.specular = random.next();
    if (i % 4 == 0) p.transmission = random.next();
    p.thin_walled = i % 8 == 0;
    p.inside = i % 5 == 0;
    Vec3f wo = random.direction();
    wo.z = std::abs(wo.z);
    const Vec3f bump = normalize_or(Vec3f(0, 0, 1) + random.cube(0.1f), Vec3f(0, 0, 1));
    const SurfaceBsdf bsdf(p, wo, bump);
    const float u_lobe = random.next();
    const BsdfSample sample = bsdf.sample(u_lobe, random.square());
    float pdf = 0.0f;
    bits.add(bsdf.albedo(), bsdf.eval_and_pdf(random.direction(), &pdf), pdf, sample.valid);
    if (sample.valid) bits.add(sample.wi, sample.weight, sample.pdf);
  }
  bits.print("scattering");
}

std::shared_ptr<const Image> noise(int width, int height, int channels) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = channels;
  image->type = TexelType::kFloat;
  const size_t values = size_t(width) * size_t(height) * size_t(channels);
  image->texels.resize(values * sizeof(float));
  auto* const texels = reinterpret_cast<float*>(image->texels.data());
  Random random(4);
  for (size_t i = 0; i < values; ++i) texels[i] = random.next();
  return image;
}

void textures() {
  TextureRef ref;
  ref.image = 0;
  ref.uv_transform = {0.9f, 0.3f, 0.1f, -0.2f, 1.1f, 0.4f};
  const Texture texture(noise(61, 37, 4), ref, false);
  Random random(5);
  Bits bits;
  for (uint32_t i = 0; i < kRounds; ++i) {
    const Vec2f uv = random.square() * 3.0f;
    bits.add(texture.lookup(uv, random.next()), texture.bilinear(uv), texture.bilinear_alpha(uv));
  }
  bits.print("textures");
}

void add_light_sample(const LightSample& s, Bits* bits) {
  bits->add(s.index, s.direction, s.distance, s.position, s.radiance, s.pdf);
}

void lights(const char* name, size_t triangles) {
  Random random(6);
  std::vector<EmissiveTriangle> emitters(triangles);
  for (EmissiveTriangle& t : emitters) {
    t.p0 = random.cube(2.0f);
    t.p1 = t.p0 + random.cube(0.3f);
    t.p2 = t.p0 + random.cube(0.3f);
    t.mean_radiance = Rgb(random.next() + 0.1f);
  }
  std::vector<PointLight> points(3);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].type = PointLightType(i);
    points[i].position = random.cube(2.0f);
    points[i].direction = random.direction();
    points[i].intensity = Rgb(random.next() + 0.5f);
  }
  const auto sky = std::make_shared<const EnvironmentLight>(noise(64, 32, 3), 0.5f, 30.0f);
  const LightSampler sampler(emitters, points, sky);
  Bits bits;
  for (uint32_t i = 0; i < kRounds; ++i) {
    const LightQuery query{random.cube(2.0f), random.direction(), i % 4 == 0};
    const float u_pick = random.next();
    const LightSample s = test::sample_one(sampler, query, u_pick, random.square());
    add_light_sample(s, &bits);
    bits.add(test::pdf_environment(sampler, query, random.direction()));
    bits.add(sampler.pdf_triangle(query, i % uint32_t(triangles), 1.0f));
    bits.add(test::radiance_of(*sky, random.direction()));
  }
  bits.print(name);
}

void cameras() {
  CameraDescription description;
  description.to_world = look_at_matrix({1, 2, 3}, {0.1, -0.2, 0.3});
  Random random(7);
  Bits bits;
  for (const double radius : {0.0, 0.02}) {
    description.lens_radius = radius;
    description.focus_distance = 3;
    const Camera camera(description, 640, 360, Vec3d(0.1, 0.2, 0.3), 1.0);
    for (uint32_t i = 0; i < kRounds; ++i) {
      Vec2f film[3], lens[3];
      Ray rays[3];
      for (int k = 0; k < 3; ++k) film[k] = random.square() * 360.0f, lens[k] = random.square();
      if (camera.has_lens()) {
        camera.rays(film, lens, rays);
      } else {
        camera.rays(film, rays);
      }
      for (const Ray& ray : rays) bits.add(ray.origin, ray.direction);
    }
  }
  bits.print("cameras");
}

void samplers() {
  for (const SamplerEntry& entry : sampler_table()) {
    SamplerSettings settings;
    settings.width = settings.height = 64;
    const auto sampler = entry.create(settings);
    Bits bits;
    for (uint32_t i = 0; i < 256; ++i) {
      SlotBlock block;
      sampler->fill({i % 64, i / 4, 9}, i % 5, i % 4 * 16, kSampleLanes, block);
      for (const auto& dimension : block.values) {
        for (const float value : dimension) bits.add(value);
      }
    }
    bits.print(std::string(entry.name).c_str());
  }
}

void filters() {
  for (const FilterEntry& entry : filter_table()) {
    const PixelFilter filter = PixelFilter::create(entry.name);
    Random random(8);
    Bits bits;
    for (uint32_t i = 0; i < kRounds; ++i) {
      const FilterSample s = filter.sample(random.square());
      bits.add(s.offset, s.weight);
    }
    bits.print(std::string(entry.name).c_str());
  }
}

}  // namespace
}  // namespace emberline

int main() {
  using namespace emberline;
  vectors();
  warps();
  scattering();
  textures();
  lights("few lights", 3);
  lights("light BVH", 300);
  cameras();
  samplers();
  filters();
}
