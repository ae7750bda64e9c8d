// Benchmarks of lights by their number, of the environment, and of hits.
#include <memory>
#include <string>
#include <vector>

#include "bench/parts.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_sampler.h"
#include "support/moving_scenes.h"
#include "support/single_queries.h"

namespace emberline::bench {
namespace {

// Returns noise, with one texel 1e5 times as bright.
std::shared_ptr<const Image> sky(int width) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = width / 2;
  image->channels = 3;
  image->type = TexelType::kFloat;
  const size_t values = size_t(width) * size_t(width / 2) * 3;
  image->texels.resize(values * sizeof(float));
  auto* const texels = reinterpret_cast<float*>(image->texels.data());
  for (size_t i = 0; i < values; ++i) texels[i] = 0.1f + to_unit_float(hash32(uint32_t(i)));
  texels[values / 3] = 1e5f;
  return image;
}

void add_environments() {
  for (const int width : {1024, 4096}) {
    const auto light = std::make_shared<const EnvironmentLight>(sky(width), 1.0f, 30.0f);
    const std::string name = "environment/" + std::to_string(width);
    for (const bool random : {false, true}) {
      const std::string way = random ? "/random" : "/coherent";
      auto direction = inputs([random](uint32_t i) {
        return square_to_sphere(random ? random_point(20, i)
                                       : Vec2f(0.3f, 0.4f) + random_point(20, i) * 0.01f);
      });
      add_benchmark(name + "/radiance" + way, [light, direction]() mutable {
        return test::radiance_of(*light, direction()).x;
      });
      add_benchmark(name + "/radiance_and_pdf" + way, [light, direction]() mutable {
        float pdf = 0.0f;
        return light->radiance_and_pdf(direction(), &pdf).x + pdf;
      });
    }
    auto random = inputs([](uint32_t i) { return square_to_sphere(random_point(20, i)); });
    add_benchmark(name + "/pdf/random",
                  [light, random]() mutable { return test::pdf_of(*light, random()); });
    add_benchmark(name + "/sample", [light, u = inputs([](uint32_t i) {
                                              return random_point(21, i);
                                            })]() mutable { return light->sample(u()).pdf; });
  }
}

Vec3f random_position(uint32_t stream, uint32_t i, float size) {
  return (Vec3f(random_unit(stream, i), random_unit(stream + 1, i), random_unit(stream + 2, i)) -
          Vec3f(0.5f)) *
         size;
}

void add_lights() {
  for (const uint32_t count : {1u, 15u, 16u, 1000u, 100'000u}) {
    std::vector<EmissiveTriangle> triangles(count);
    for (uint32_t i = 0; i < count; ++i) {
      EmissiveTriangle& t = triangles[i];
      t.p0 = random_position(30, i, 100.0f);
      t.p1 = t.p0 + random_position(33, i, 0.3f);
      t.p2 = t.p0 + random_position(36, i, 0.3f);
      t.mean_radiance = Rgb(0.1f + random_unit(39, i));
    }
    const auto lights = std::make_shared<const LightSampler>(std::move(triangles),
                                                             std::vector<PointLight>{}, nullptr);
    auto query = inputs([](uint32_t i) {
      return LightQuery{random_position(40, i, 100.0f), square_to_sphere(random_point(43, i))};
    });
    const std::string name = "lights/" + std::to_string(count);
    add_benchmark(name + "/sample",
                  [lights, query, u = inputs([](uint32_t i) { return random_point(44, i); }),
                   i = 0u]() mutable {
                    return test::sample_one(*lights, query(), random_unit(45, ++i), u()).pdf;
                  });
    add_benchmark(name + "/pdf", [lights, query, count, i = 0u]() mutable {
      return lights->pdf_triangle(query(), ++i % count, 10.0f);
    });
  }
}

// Returns rays at any time, all of which hit the sphere of add_surfaces().
auto rays_towards_ball(bool random) {
  return inputs([random](uint32_t i) {
    const Vec3f at = square_to_sphere(random ? random_point(50, i)
                                             : Vec2f(0.3f, 0.4f) + random_point(50, i) * 0.02f) *
                     0.5f;
    const Vec3f from = random ? square_to_sphere(random_point(52, i)) * 3.0f : Vec3f(0, 3, 3);
    return Ray{from, normalize(at - from), kInfinity, random_unit(54, i)};
  });
}

void add_surface(const std::string& name, const std::shared_ptr<const Scene>& scene) {
  for (const bool random : {false, true}) {
    auto ray = rays_towards_ball(random);
    auto hit = inputs([&](uint32_t i) {
      SurfaceHit found;
      if (!scene->intersect(ray.values[i], {}, &found)) std::abort();
      return std::pair(found, ray.values[i].time);
    });
    const std::string way = random ? "/random" : "/coherent";
    add_benchmark(name + "/intersect" + way, [scene, ray]() mutable {
      SurfaceHit found;
      scene->intersect(ray(), {}, &found);
      return found.t;
    });
    add_benchmark(name + "/interaction" + way, [scene, hit]() mutable {
      SurfaceInteraction s;
      const auto& [found, time] = hit();
      scene->interaction(found, time, &s);
      benchmark::DoNotOptimize(s);
      return s.position.x;
    });
  }
}

// A sphere of 80,000 triangles seen from outside: at rest, with all attributes of a mapped surface,
// as an instance, and in motion with three steps (translating, rotating, deforming).
void add_surfaces() {
  enum class Kind { kFlat, kSmooth, kInstanced, kMoving, kTurning, kDeforming };
  const std::pair<Kind, const char*> kinds[] = {
      {Kind::kFlat, "surface/flat"},           {Kind::kSmooth, "surface/smooth_mapped"},
      {Kind::kInstanced, "surface/instanced"}, {Kind::kMoving, "surface/moving"},
      {Kind::kTurning, "surface/turning"},     {Kind::kDeforming, "surface/deforming"}};
  for (const auto& [kind, name] : kinds) {
    test::SceneBuilderForTests b;
    const int material = b.add_material(test::lambert(Rgb(0.5f)));
    const bool smooth = kind == Kind::kSmooth;
    MeshDescription mesh = test::SceneBuilderForTests::sphere(1.0f, 200, material, false, smooth);
    if (smooth) {
      mesh.uv_sets = {std::vector<Vec2f>(mesh.positions.size(), Vec2f(0.25f, 0.75f))};
      mesh.tangents.assign(mesh.positions.size(), Vec4f(0, 1, 0, 1));
    }
    for (int step = 1; step < 3 && kind == Kind::kDeforming; ++step) {
      MeshStep later{mesh.positions, {}, {}};
      for (Vec3f& p : later.positions) p *= 1.0f + 0.1f * float(step);
      mesh.motion.push_back(std::move(later));
    }
    const int index = b.add_mesh(std::move(mesh));
    b.place(index);
    if (kind == Kind::kInstanced) b.place(index, test::translation(9, 0, 0));
    for (int step = 1; step < 3; ++step) {
      const Mat44d way = test::translation(0.1 * step, 0, 0);
      auto& motion = b.description.instances[0].motion;
      if (kind == Kind::kMoving) motion.push_back(way);
      if (kind == Kind::kTurning) motion.push_back(test::turned(0.3 * step) * way);
    }
    b.set_environment(Rgb(1.0f));
    const std::shared_ptr<const Scene> scene = b.build();
    add_surface(name, scene);
  }
}

}  // namespace

void add_lights_and_scene_benchmarks() {
  add_environments();
  add_lights();
  add_surfaces();
}

}  // namespace emberline::bench
