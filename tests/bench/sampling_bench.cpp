// Benchmarks the start of every sample (random numbers, pixel position, camera ray) and its end
// (the film).
#include <memory>
#include <string>

#include "bench/parts.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/film/film.h"
#include "renderer/film/filter.h"
#include "renderer/scene/camera.h"
#include "samplers/pixel_samples.h"

namespace emberline::bench {
namespace {

// Draws a batch of 16 samples, with all four pairs of `slots` slots that start at `first_slot`.
struct SampleNumbers {
  std::shared_ptr<const Sampler> sampler;
  uint32_t first_slot, slots;
  PixelSamples samples{*sampler};
  uint32_t batch = 0;

  SampleNumbers(std::shared_ptr<const Sampler> s, uint32_t first, uint32_t count)
      : sampler(std::move(s)), first_slot(first), slots(count) {}
  float operator()() {
    ++batch;
    const uint32_t first = 16 * (batch % 4);
    samples.start_batch({batch / 4 % 1024, batch / 4096, 1}, first, kSampleLanes);
    float sum = 0;
    for (int i = 0; i < kSampleLanes; ++i) {
      samples.start_sample(i);
      for (uint32_t slot = first_slot; slot < first_slot + slots; ++slot) {
        samples.start_slot(slot);
        for (int d = 0; d < kSlotDimensions; ++d) sum += samples.get(d);
      }
    }
    return sum;
  }
};

void add_samplers() {
  for (const SamplerEntry& entry : sampler_table()) {
    const std::shared_ptr<const Sampler> sampler = entry.create({});
    const double points = kSampleLanes * kSlotDimensions / 2;
    const std::string name = "sampler/" + std::string(entry.name);
    add_benchmark(name + "/2d_point", SampleNumbers(sampler, 0, 4), 4 * points);
    // The first eight slots are filled for a whole batch, later slots sample by sample.
    add_benchmark(name + "/2d_point_of_a_long_path", SampleNumbers(sampler, 9, 1), points);
  }
}

void add_filters() {
  for (const FilterEntry& entry : filter_table()) {
    const PixelFilter filter = PixelFilter::create(entry.name);
    add_benchmark("filter/" + std::string(entry.name) + "/sample",
                  [filter, u = inputs([](uint32_t i) { return random_point(1, i); })]() mutable {
                    const FilterSample s = filter.sample(u());
                    return s.offset.x + s.offset.y + s.weight;
                  });
  }
}

void add_cameras() {
  for (const bool orthographic : {false, true}) {
    CameraDescription description;
    description.orthographic = orthographic;
    description.to_world = look_at_matrix({1, 2, 3}, {0, 0, 0});
    const Camera camera(description, 1280, 720, Vec3d(0.0), 1.0);
    auto film = inputs([](uint32_t i) { return random_point(2, i) * Vec2f(1280.0f, 720.0f); });
    add_benchmark(orthographic ? "camera/orthographic" : "camera/perspective",
                  [camera, film]() mutable {
                    const Ray ray = camera.ray(film());
                    return ray.origin.x + ray.direction.x + ray.direction.y + ray.direction.z;
                  });
  }
}

// Adds 16 samples to each pixel of a bucket of 64 x 64 pixels, in the order in which a worker adds
// them.
void add_films() {
  for (const char* aovs : {"", "variance,albedo,N,Z,id"}) {
    auto tile = std::make_shared<FilmTile>(AovSet::parse(aovs));
    tile->reset({0, 0, 64, 64});
    auto values = inputs([](uint32_t i) {
      SampleValue value;
      value.radiance = Rgb(random_unit(3, i), random_unit(4, i), random_unit(5, i));
      value.alpha = 1.0f;
      value.first_hit.hit = true;
      value.first_hit.id = 1 + i % 7;
      return value;
    });
    add_benchmark(std::string("film/add") + (*aovs ? "/all_aovs" : ""),
                  [tile, values, n = 0u]() mutable {
                    const uint32_t pixel = n++ / 16 % 4096;
                    return tile->add(int(pixel % 64), int(pixel / 64), {values(), 1.0f, 0});
                  });
  }
}

}  // namespace

void add_sampling_benchmarks() {
  add_samplers();
  add_filters();
  add_cameras();
  add_films();
}

}  // namespace emberline::bench
