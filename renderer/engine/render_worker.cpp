#include "renderer/engine/render_worker.h"

#include <algorithm>
#include <chrono>

#include "renderer/film/film.h"
#include "renderer/film/filter.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/camera_solids.h"
#include "renderer/scene/cryptomatte_ids.h"
#include "renderer/scene/empty_pixels.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"

namespace emberline {
namespace {

// Returns how many sample dimensions a camera ray uses. These are kPixelX and kPixelY and, with a
// lens, also kLensX and kLensY. If something moves, all four and kTime are used.
int camera_dimensions(const Frame& frame) {
  return frame.moves() ? 5 : frame.camera.has_lens() ? 4 : 2;
}

// Samples between progress reports: about a millisecond of work.
constexpr uint64_t kSamplesPerReport = 2048;

}  // namespace

RenderWorker::RenderWorker(const Frame& frame)
    : frame_(frame),
      seed_(frame.seed),
      // If the first point has weight 1, all points have weight 1.
      has_sample_weights_(frame.exact_counts &&
                          frame.sampler.integration_weight(0, frame.samples_per_pixel) != 1.0f),
      samples_(frame.sampler, camera_dimensions(frame)),
      needs_first_hits_(frame.aovs.needs(ChannelFeed::kFirstHit)),
      needs_hit_ids_(frame.cryptomattes || frame.aovs.needs(ChannelFeed::kHitId)),
      needs_features_(frame.aovs.needs(ChannelFeed::kFeatures)),
      needs_catchers_(frame.aovs.needs(ChannelFeed::kCatchers)),
      counters_(frame.empty_counters()),
      light_values_(frame.light_groups ? frame.light_groups->size() : 0),
      path_layers_(frame.aovs),
      layer_values_(path_layers_.size()) {}

void RenderWorker::begin_batch(int x, int y, uint32_t first_sample, int count) {
  for (int i = 0; i < count; ++i) {
    addresses_[i] = {uint32_t(x), uint32_t(y), first_sample + uint32_t(i)};
  }
  count_ = count;
  samples_.start_batch({uint32_t(x), uint32_t(y), seed_}, first_sample, count);
}

// Starts each sample again to draw its lens dimensions. sample_film_positions() does not draw them,
// because only some frames need them.
void RenderWorker::generate_lens_rays(std::span<const Vec2f> film) {
  Vec2f lens[kSampleLanes];
  for (int i = 0; i < count_; ++i) {
    samples_.start_sample(i);
    lens[i] = {samples_.get(camera_dim::kLensX), samples_.get(camera_dim::kLensY)};
  }
  frame_.camera.rays(film, {lens, film.size()}, rays_);
}

// Generates the rays of a frame in which something moves, each ray at its own time.
void RenderWorker::generate_timed_rays(std::span<const Vec2f> film) {
  const Camera& camera = frame_.camera;
  if (!camera.moves()) {
    generate_rays(film);
    for (int i = 0; i < count_; ++i) {
      samples_.start_sample(i);
      rays_[i].time = samples_.get(camera_dim::kTime);
    }
    return;
  }
  for (int i = 0; i < count_; ++i) {
    samples_.start_sample(i);
    Vec2f lens(0.0f);
    if (camera.has_lens()) {
      lens = {samples_.get(camera_dim::kLensX), samples_.get(camera_dim::kLensY)};
    }
    rays_[i] = camera.ray(film[size_t(i)], lens, samples_.get(camera_dim::kTime));
  }
}

void RenderWorker::generate_rays(std::span<const Vec2f> film) {
  if (frame_.camera.has_lens()) {
    generate_lens_rays(film);
  } else {
    frame_.camera.rays(film, rays_);
  }
}

// Returns whether no surface is visible in any pixel of the batch.
bool RenderWorker::all_empty() const {
  if (!frame_.empty_pixels) return false;
  return std::all_of(addresses_, addresses_ + count_, [this](const SampleAddress& a) {
    return frame_.empty_pixels->contains(int(a.x), int(a.y));
  });
}

// Draws the film position and weight of each sample of the batch.
void RenderWorker::sample_film_positions(Vec2f* film) {
  for (int i = 0; i < count_; ++i) {
    samples_.start_sample(i);
    const FilterSample offset = frame_.filter.sample(
        {samples_.get(camera_dim::kPixelX), samples_.get(camera_dim::kPixelY)});
    weights_[i] = offset.weight;
    if (needs_features_) shares_[i] = frame_.filter.shares(offset.offset);
    if (has_sample_weights_) {
      const float weight =
          frame_.sampler.integration_weight(addresses_[i].sample, frame_.samples_per_pixel);
      weights_[i] *= weight;
      for (float& share : shares_[i]) share = needs_features_ ? share * weight : 0.0f;
    }
    film[i] = {float(addresses_[i].x) + 0.5f + offset.offset.x,
               float(addresses_[i].y) + 0.5f + offset.offset.y};
    values_[i] = SampleValue{};
  }
}

void RenderWorker::trace_batch() {
  Vec2f film[kSampleLanes];
  sample_film_positions(film);
  const auto count = size_t(count_);
  if (frame_.moves()) [[unlikely]] {
    generate_timed_rays({film, count});
  } else {
    generate_rays({film, count});
  }
  const bool velocity = frame_.aovs.contains(Aov::kVelocity);
  SampleBatch batch{frame_.scene, frame_.camera, {rays_, count}};
  batch.surface_aovs = needs_first_hits_;
  batch.hit_id = needs_hit_ids_;
  batch.aovs = &frame_.aovs;
  batch.all_rays_miss = all_empty();
  batch.guide = frame_.guide.get();
  batch.indirect_guide = frame_.indirect.guide.get();
  if (velocity) batch.velocity_frames = frame_.shutter_frames;
  if (frame_.light_groups) {
    light_values_.clear();
    batch.light_groups = frame_.light_groups;
    batch.light_values = &light_values_;
  }
  if (!path_layers_.empty()) {
    layer_values_.clear();
    batch.path_layers = &path_layers_;
    batch.layer_values = &layer_values_;
  }
  if (counters_.clamped.clamps()) batch.clamped = &counters_.clamped;
  if (needs_features_) {
    std::fill_n(features_, count, DenoiserFeatures{});
    batch.features = {features_, count};
  }
  batch.roles = frame_.roles;
  batch.optics = &counters_.optics;
  if (frame_.camera_solids) [[unlikely]] {
    frame_.camera_solids->interiors({rays_, count}, {interiors_, count});
    batch.interiors = interiors_;
  }
  if (needs_catchers_) [[unlikely]] {
    std::fill_n(catcher_samples_, count, CatcherSample{});
    batch.catcher_samples = {catcher_samples_, count};
    batch.catcher_guide = frame_.catcher_guide.get();
  }
  frame_.integrator.estimate(batch, samples_, {values_, count});
  if (velocity) [[unlikely]]
    add_background_velocity();
}

// The background is infinitely far away, so only the camera's rotation moves it.
void RenderWorker::add_background_velocity() {
  for (int i = 0; i < count_; ++i) {
    FirstHit& hit = values_[i].first_hit;
    if (hit.hit) continue;
    hit.velocity = frame_.camera.velocity(to_double(rays_[i].direction), frame_.shutter_frames);
  }
}

void RenderWorker::add(int lane, FilmTile& tile) {
  const SampleAddress& a = addresses_[lane];
  const int x = int(a.x), y = int(a.y);
  FilmSample sample{.value = values_[lane],
                    .filter_weight = weights_[lane],
                    .half = frame_.half_of(a.sample),
                    .lights = &light_values_,
                    .layers = &layer_values_,
                    .lane = lane};
  if (needs_features_) {
    sample.features = &features_[lane];
    sample.shares = &shares_[lane];
  }
  if (needs_catchers_) sample.catcher = &catcher_samples_[lane];
  if (frame_.cryptomattes) sample.ids = frame_.cryptomattes->ids_of_hit(values_[lane].first_hit.id);
  if (tile.add(x, y, sample)) {
    if (counters_.clamped.clamps()) counters_.clamped.add_remaining(values_[lane].radiance);
  } else {
    counters_.non_finite_samples++;
    counters_.locate({x, y, a.sample, seed_});
  }
}

// Traces the batch and adds its samples and their cost to the film. Divides the time equally among
// the samples, which may belong to several pixels.
void RenderWorker::add_batch(FilmTile& tile) {
  using Clock = std::chrono::steady_clock;
  const bool timed = frame_.aovs.contains(Aov::kTime);
  const Clock::time_point start = timed ? Clock::now() : Clock::time_point{};
  trace_batch();
  for (int i = 0; i < count_; ++i) {
    counters_.rays.add(values_[i].rays);
    add(i, tile);
    counters_.max_samples =
        std::max(counters_.max_samples, addresses_[i].sample + 1 - frame_.first_sample);
  }
  if (timed) {
    const double share = std::chrono::duration<double>(Clock::now() - start).count() / count_;
    for (int i = 0; i < count_; ++i) {
      tile.add_time(int(addresses_[i].x), int(addresses_[i].y), share);
    }
  }
  counters_.samples += uint64_t(count_);
  count_ = 0;
}

void RenderWorker::flush_partial_batch(FilmTile& tile) {
  if (count_ == 0) return;
  samples_.start_batch({addresses_, size_t(count_)}, seed_);
  add_batch(tile);
}

bool RenderWorker::render(std::span<const PixelWork> list, FilmTile& tile, RenderSink& sink,
                          const std::stop_token& stop) {
  uint64_t reported = counters_.samples;
  bool complete = true;
  count_ = 0;
  for (size_t i = 0; i < list.size() && complete; ++i) {
    const PixelWork& work = list[i];
    const uint32_t end = frame_.first_sample + work.first_sample + work.sample_count;
    for (uint32_t sample = end - work.sample_count; sample < end && complete;) {
      const uint32_t in_block = sample % kSampleLanes;
      if (in_block == 0 && end - sample >= uint32_t(kSampleLanes)) {
        flush_partial_batch(tile);  // the partial batch may have earlier samples of this pixel
        begin_batch(work.x, work.y, sample, kSampleLanes);
        add_batch(tile);
        sample += uint32_t(kSampleLanes);
      } else {
        // Successive pixels of the list may be far apart in the film. Without the prefetch, waiting
        // for memory took 2 % of a FlightHelmet frame with 32 samples per pixel.
        tile.prefetch(work.x, work.y);
        addresses_[count_++] = {uint32_t(work.x), uint32_t(work.y), sample++};
        if (count_ == kSampleLanes) flush_partial_batch(tile);
      }
      if (count_ == 0) complete = !stop.stop_requested();
    }
    if (counters_.samples - reported >= kSamplesPerReport) {
      sink.samples_finished(counters_.samples - reported);
      reported = counters_.samples;
    }
  }
  if (complete) flush_partial_batch(tile);
  count_ = 0;
  sink.samples_finished(counters_.samples - reported);
  return complete;
}

SampleValue RenderWorker::replay(int x, int y, uint32_t sample, Ray* camera_ray) {
  begin_batch(x, y, sample, 1);
  trace_batch();
  count_ = 0;
  if (camera_ray) *camera_ray = rays_[0];
  values_[0].radiance *= weights_[0];
  return values_[0];
}

}  // namespace emberline
