#include "renderer/drivers/render_work_item.h"

#include <algorithm>
#include <chrono>

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

namespace emberline {
namespace {

// What trace_batch asks slot 0 for: kPixelX and kPixelY.
constexpr int kCameraDimensions = 2;

// Samples between two reports of progress: about a millisecond of work.
constexpr uint64_t kReportedSamples = 2048;

// Flush-to-zero and denormals-are-zero, bits 15 and 6 of MXCSR (Intel SDM, section 10.2.3).
unsigned flush_denormals() {
#if defined(__x86_64__) || defined(_M_X64)
  const unsigned saved = _mm_getcsr();
  _mm_setcsr(saved | 0x8040u);
  return saved;
#else
  return 0;
#endif
}

void restore_mode([[maybe_unused]] unsigned saved) {
#if defined(__x86_64__) || defined(_M_X64)
  _mm_setcsr(saved);
#endif
}

// Which of the film's two half sums a sample belongs to; samplers/sampler.h defines the streams.
int half_of(uint32_t sample, StreamCount streams) {
  return streams == StreamCount::kTwo ? int((sample >> 3) & 1u) : 0;
}

}  // namespace

RenderWorker::RenderWorker(const Frame& frame)
    : frame_(frame), samples_(frame.sampler, kCameraDimensions), saved_mode_(flush_denormals()) {}

RenderWorker::~RenderWorker() { restore_mode(saved_mode_); }

void RenderWorker::trace_batch(int x, int y, uint32_t first_sample, int count) {
  samples_.start_batch({uint32_t(x), uint32_t(y), frame_.seed}, first_sample, count);
  Vec2f film[kSampleLanes];
  for (int i = 0; i < count; ++i) {
    samples_.start_sample(first_sample + uint32_t(i));
    const FilterSample offset = frame_.filter.sample(
        {samples_.get(camera_dim::kPixelX), samples_.get(camera_dim::kPixelY)});
    weights_[i] = offset.weight;
    film[i] = {float(x) + 0.5f + offset.offset.x, float(y) + 0.5f + offset.offset.y};
    values_[i] = SampleValue{};
  }
  frame_.camera.rays({film, size_t(count)}, rays_);
  const bool surface = frame_.aovs.contains(Aov::kAlbedo) || frame_.aovs.contains(Aov::kNormal) ||
                       frame_.aovs.contains(Aov::kDepth);
  const SampleBatch batch{frame_.scene, frame_.camera, {rays_, size_t(count)},
                          first_sample, surface,       frame_.aovs.contains(Aov::kId)};
  frame_.integrator.estimate(batch, samples_, {values_, size_t(count)}, counters_.rays);
}

bool RenderWorker::render(const WorkItem& item, FilmTile& tile, FrameObserver& observer,
                          const std::stop_token& stop) {
  using Clock = std::chrono::steady_clock;
  const bool timed = frame_.aovs.contains(Aov::kTime);
  const uint32_t end = item.first_sample + item.sample_count;
  const bool had_samples = counters_.samples > 0;
  uint32_t fewest = had_samples ? counters_.min_samples : item.sample_count;
  bool complete = true;
  for (int y = item.pixels.y0; y < item.pixels.y1; ++y) {
    uint64_t row_samples = 0, unreported = 0;
    for (int x = item.pixels.x0; x < item.pixels.x1; ++x) {
      const Clock::time_point start = timed ? Clock::now() : Clock::time_point{};
      uint32_t sample = item.first_sample;
      while (sample < end) {
        if (stop.stop_requested()) {
          complete = false;
          break;
        }
        // Batches end at multiples of 16, so a batch never straddles two blocks of the sampler.
        const uint32_t block_end = (sample / kSampleLanes + 1) * uint32_t(kSampleLanes);
        const int count = int(std::min(end, block_end) - sample);
        trace_batch(x, y, sample, count);
        for (int i = 0; i < count; ++i) {
          const uint32_t k = sample + uint32_t(i);
          if (!tile.add(x, y, half_of(k, frame_.streams), weights_[i], values_[i])) {
            counters_.non_finite_samples++;
            if (counters_.located.size() < FrameCounters::kLocatedLimit) {
              counters_.located.push_back({x, y, k});
            }
          }
        }
        sample += uint32_t(count);
      }
      const uint32_t done = sample - item.first_sample;
      row_samples += done;
      unreported += done;
      if (unreported >= kReportedSamples) {
        observer.samples_finished(unreported);
        unreported = 0;
      }
      fewest = std::min(fewest, done);
      counters_.max_samples = std::max(counters_.max_samples, done);
      if (timed) {
        tile.add_time(x, y, std::chrono::duration<double>(Clock::now() - start).count());
      }
    }
    counters_.samples += row_samples;
    observer.samples_finished(unreported);
  }
  counters_.min_samples = fewest;
  counters_.stopped = counters_.stopped || !complete;
  return complete;
}

SampleValue RenderWorker::replay(int x, int y, uint32_t sample, Ray* camera_ray) {
  trace_batch(x, y, sample, 1);
  if (camera_ray) *camera_ray = rays_[0];
  values_[0].radiance *= weights_[0];
  return values_[0];
}

}  // namespace emberline
