// Measures the cost of light sampling in nanoseconds. This is not a test. Build it with `ninja
// lights_bench`.
#include <chrono>
#include <cstdio>

#include "renderer/core/moments.h"
#include "renderer/core/warps.h"
#include "renderer/description/scene_description.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_bvh.h"
#include "renderer/lights/light_sampler.h"
#include "renderer/lights/triangle_sampling.h"
#include "support/chi_square.h"
#include "support/single_queries.h"

namespace emberline {
namespace {

using test::TestRandom;
using Clock = std::chrono::steady_clock;

constexpr int kCalls = 1 << 17;
float sink = 0;  // keeps results alive

// Returns the nanoseconds of one call of body(i), where i runs over [0, kCalls), in the fastest of
// several runs.
template <class Body>
double nanoseconds(const Body& body) {
  double best = 1e30;
  for (int run = 0; run < 30; ++run) {
    const auto start = Clock::now();
    float sum = 0;
    for (int i = 0; i < kCalls; ++i) sum += body(i);
    sink += sum;
    const std::chrono::duration<double, std::nano> time = Clock::now() - start;
    best = std::min(best, time.count() / kCalls);
  }
  return best;
}

std::shared_ptr<Image> sky_map(int width) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = width / 2;
  image->channels = 3;
  image->type = TexelType::kFloat;
  image->texels.resize(size_t(width) * size_t(width / 2) * 3 * sizeof(float));
  auto* texel = reinterpret_cast<float*>(image->texels.data());
  for (size_t i = 0; i < image->texels.size() / sizeof(float); ++i)
    texel[i] = 0.1f + to_unit_float(hash32(uint32_t(i)));
  texel[image->texels.size() / sizeof(float) / 3] = 1e5f;
  return image;
}

std::vector<EmissiveTriangle> emitters(int count) {
  std::vector<EmissiveTriangle> result;
  for (int i = 0; i < count; ++i) {
    TestRandom random(1, uint64_t(i));
    const auto point = [&random](float scale) {
      return Vec3f(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f) * scale;
    };
    EmissiveTriangle t;
    t.p0 = point(100);
    t.p1 = t.p0 + point(0.3f);
    t.p2 = t.p0 + point(0.3f);
    t.mean_radiance = Rgb(random.next() + 0.1f);
    result.push_back(t);
  }
  return result;
}

void bench_environment() {
  std::vector<Vec3f> random_directions, coherent;
  std::vector<Vec2f> u;
  for (int i = 0; i < kCalls; ++i) {
    u.push_back(TestRandom(2, uint64_t(i)).vec2());
    random_directions.push_back(square_to_sphere(u.back()));
    coherent.push_back(square_to_sphere(
        {0.3f + 0.2f * float(i / 1024) / 1024, 0.4f + 0.2f * float(i % 1024) / 1024}));
  }
  for (int width : {1024, 4096}) {
    const auto start = Clock::now();
    const EnvironmentLight light(sky_map(width), 1.0f, 30.0f);
    const std::chrono::duration<double, std::milli> build = Clock::now() - start;
    std::printf("environment %d: tables %.1f ms (image included)\n", width, build.count());
    std::printf(
        "  radiance          %6.1f ns random %6.1f coherent\n", nanoseconds([&](int i) {
          return test::radiance_of(light, random_directions[size_t(i)]).x;
        }),
        nanoseconds([&](int i) { return test::radiance_of(light, coherent[size_t(i)]).x; }));
    const auto both = [&light](const Vec3f& w) {
      float pdf = 0;
      return light.radiance_and_pdf(w, &pdf).x + pdf;
    };
    std::printf("  radiance and pdf  %6.1f ns random %6.1f coherent\n",
                nanoseconds([&](int i) { return both(random_directions[size_t(i)]); }),
                nanoseconds([&](int i) { return both(coherent[size_t(i)]); }));
    std::printf("  sample            %6.1f ns\n",
                nanoseconds([&](int i) { return light.sample(u[size_t(i)]).pdf; }));
  }
}

void bench_triangles() {
  std::vector<Vec2f> u;
  std::vector<Vec3f> points;
  for (int i = 0; i < kCalls; ++i) {
    TestRandom random(3, uint64_t(i));
    u.push_back(random.vec2());
    points.push_back(Vec3f(random.next(), random.next(), random.next() + 0.2f));
  }
  const Vec3f p0(0, 0, 0), p1(1, 0, 0), p2(0, 1, 0);
  std::printf("triangle\n");
  for (float distance : {1.0f, 1000.0f}) {
    const auto at = [&](int i) { return points[size_t(i)] * distance; };
    std::printf("  sample, %-9s %6.1f ns\n", distance == 1 ? "spherical" : "by area",
                nanoseconds([&](int i) {
                  TriangleBatch batch;
                  batch.add({p0, p1, p2}, at(i), u[size_t(i)]);
                  batch.sample();
                  return batch[0].pdf;
                }));
  }
  for (int together : {1, 4, kRayBatch}) {
    std::printf("  sample, %2d at once %5.1f ns\n", together, nanoseconds([&](int i) {
                  if (i % together != 0) return 0.0f;
                  TriangleBatch batch;
                  for (int j = i; j < i + together; ++j) {
                    batch.add({p0, p1, p2}, points[size_t(j)], u[size_t(j)]);
                  }
                  batch.sample();
                  return batch[0].pdf + batch[together - 1].pdf;
                }));
  }
  std::printf("  pdf               %6.1f ns\n", nanoseconds([&](int i) {
                return triangle_pdf(project_triangle(p0, p1, p2, points[size_t(i)]), 1.0f);
              }));
}

void bench_sampler() {
  std::vector<LightQuery> queries;
  std::vector<float> picks;
  std::vector<Vec2f> u;
  for (int i = 0; i < kCalls; ++i) {
    TestRandom random(4, uint64_t(i));
    picks.push_back(random.next());
    u.push_back(random.vec2());
    queries.push_back(
        {Vec3f(random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f) * 100.0f,
         square_to_sphere(random.vec2())});
  }
  for (int count : {1, 8, 15, 16, 100, 1000, 10'000, 100'000, 1'000'000}) {
    for (uint32_t threshold : {1u, 1u << 30}) {
      if (threshold > 1 && count > 1000) continue;
      const auto start = Clock::now();
      const LightSampler lights(emitters(count), {}, nullptr, nullptr, threshold);
      const std::chrono::duration<double, std::milli> build = Clock::now() - start;
      const double sample = nanoseconds([&](int i) {
        return test::sample_one(lights, queries[size_t(i)], picks[size_t(i)], u[size_t(i)]).pdf;
      });
      const double pdf = nanoseconds([&](int i) {
        return lights.pdf_triangle(queries[size_t(i)], uint32_t(i) % uint32_t(count), 1);
      });
      Moments one;
      for (int i = 0; i < kCalls; ++i) {
        const LightQuery query{Vec3f(0.0f), Vec3f(0, 1, 0), true};
        const LightSample s = test::sample_one(lights, query, picks[size_t(i)], u[size_t(i)]);
        if (s.pdf > 0)
          one.add(luminance(lights.triangles()[s.index].mean_radiance) *
                  std::abs(dot(s.direction, query.normal)) / s.pdf);
        else
          one.add(0);
      }
      std::printf("%-28s build %7.1f ms, sample %6.1f ns, pdf %6.1f ns, relative deviation %.2f\n",
                  lights.describe().c_str(), build.count(), sample, pdf,
                  std::sqrt(one.variance()) / one.mean());
    }
  }
}

}  // namespace
}  // namespace emberline

int main() {
  emberline::bench_environment();
  emberline::bench_triangles();
  emberline::bench_sampler();
  return emberline::sink == 1e-30f;
}
