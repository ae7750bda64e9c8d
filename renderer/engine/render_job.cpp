#include "renderer/engine/render_job.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/flush_denormals.h"
#include "renderer/drivers/bucket_schedule.h"
#include "renderer/engine/film_memory.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_loop.h"
#include "renderer/engine/time_budget.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"

namespace emberline {
namespace {

// Returns what each light group or light-path layer contributes to each pixel, including pixels
// that are filled in from their neighbours. The result is ordered by pixel, then by group.
std::vector<Rgb> resolve_groups(const LivePicture& picture, LightMix::Source of, size_t groups) {
  const auto pixels = size_t(picture.film().rect().area());
  std::vector<Rgb> lights(groups * pixels);
  std::vector<float> rgba(4 * pixels);
  for (size_t g = 0; g < groups; ++g) {
    std::vector<Rgb> weights(groups, Rgb(0.0f));
    weights[g] = Rgb(1.0f);
    const LightMix alone(weights, of);
    picture.resolve(rgba, &alone);
    for (size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[4 * i], 3, &lights[groups * i + g].x);
  }
  return lights;
}

// Returns the end of the range of parts to render before the next pause. These are all parts of the
// round or, if a picture is wanted after `samples_to_picture` samples, only the parts up to that
// number.
size_t end_before_pause(const FrameDriver& driver, const Round& round, size_t begin,
                        std::optional<uint64_t> samples_to_picture) {
  if (!samples_to_picture) return round.parts;
  size_t end = begin;
  for (uint64_t samples = 0; end < round.parts && samples < *samples_to_picture; ++end) {
    samples += driver.samples(end);
  }
  return end;
}

// Renders the parts of `work`, or fewer if a picture is wanted soon.
RenderedParts execute(RenderLoop& loop, RoundWork& work) {
  loop.run_workers(work.parts_left(), [&](RenderWorker& worker, const auto& should_continue) {
    bool has_part = false;
    work.take_parts(worker, loop.sink, loop.stop, [&] {
      if (has_part && loop.sink.needs_picture()) return false;
      has_part = true;
      return should_continue();
    });
  });
  return work.rendered(loop.stop.stop_requested());
}

}  // namespace

void store_driver_picture(const FrameDriver& driver, FilmTile& film) {
  if (!driver.overrides_means()) return;
  const Rect& pixels = film.rect();
  std::vector<float> shown(4 * size_t(pixels.area()));
  driver.resolve(film, shown, nullptr);
  for (size_t i = 0; i < size_t(pixels.area()); ++i) {
    film.set_override(pixels.x_of(i), pixels.y_of(i), &shown[4 * i]);
  }
}

uint64_t count_unsampled(const FilmTile& film) {
  uint64_t count = 0;
  for (size_t i = 0; i < size_t(film.rect().area()); ++i) count += film.sums(i).samples() == 0;
  return count;
}

RenderJob::RenderJob(Frame frame, DriverFactory drivers)
    : frame_(std::move(frame)), drivers_(std::move(drivers)) {}

RenderJob::~RenderJob() = default;

RenderResult RenderJob::render(RenderSink& sink, std::stop_token stop) {
  RenderLoop loop(frame_, sink, std::move(stop), counters_);
  drivers_.tiles ? render_tiles(loop) : render_crop(loop);
  const bool ended_by_time = sink.stop_cause() == PixelStop::kTimeLimit && !drivers_.tiles;
  return {counters_, !counters_.stopped || ended_by_time, unsampled_pixels_};
}

void RenderJob::begin() {
  film_ = std::make_unique<FilmTile>(frame_.aovs, film_extras());
  reset_film(frame_.crop, film_.get());
  driver_ = drivers_.create(frame_, frame_.crop);
  counters_ = frame_.empty_counters();
}

void RenderJob::archive(Archive& archive) {
  TileResult result{driver_->error_estimate(), driver_->min_samples(*film_), counters_};
  bool finished = is_budget_spent_ || (driver_->finished() && frame_.time_budget_s == 0);
  result.archive(archive);
  archive.number(finished, false, true);
  if (archive.loading() && frame_.time_budget_s > 0) is_budget_spent_ = finished;
  film_->archive(archive);
  driver_->archive(archive, *film_);
  counters_ = result.counters;
  archive.number(parts_done_, size_t(0), driver_->round().parts);
}

void RenderJob::save(std::vector<std::byte>& state) {
  Archive saving(state);
  archive(saving);
  saving.end();
}

void RenderJob::make_resumable() {
  resumable_ = true;
  begin();
}

void RenderJob::load(std::span<const std::byte> state) {
  Archive loading(state);
  archive(loading);
  loading.end();
  film_is_ahead_ = true;
}

void RenderJob::extend(std::span<const std::byte> finished) {
  Archive loading(finished);
  TileResult result{.counters = counters_};
  bool is_finished = false;
  result.archive(loading);
  loading.number(is_finished, false, true);
  loading.check(is_finished);
  film_->archive(loading);
  film_->clear_overrides();
  driver_->extend(loading, *film_);
  counters_ = result.counters;
  film_is_ahead_ = true;
}

// Called when the driver has finished its planned work. Adds work if the time budget allows more.
// Returns false if the frame is finished.
bool RenderJob::extend_work(std::optional<FrameBudget>& budget) {
  if (!budget) return false;
  while (const std::optional<double> factor = budget->next_factor(work_of(counters_.rays))) {
    driver_->extend_work(*factor);
    if (!driver_->finished()) return true;
  }
  return false;
}

void RenderJob::render_crop(RenderLoop& loop) {
  if (!driver_) begin();
  JobProgress progress;
  std::optional<FrameBudget> budget;
  if (frame_.time_budget_s > 0) {
    budget.emplace(
        frame_.time_budget_s, [watch = Stopwatch()] { return watch.seconds(); },
        work_of(counters_.rays));
  }
  while (!is_budget_spent_ && (!driver_->finished() || extend_work(budget))) {
    if (parts_done_ == driver_->round().parts) {
      if (!driver_->next(*film_, resumable_ ? std::stop_token() : loop.stop)) {
        if (driver_->finished()) continue;
        break;
      }
      parts_done_ = 0;
    }
    const Round round = driver_->round();
    std::optional<uint64_t> picture_at = loop.sink.next_picture_at();
    if (picture_at) *picture_at = std::max(*picture_at, counters_.samples + 1) - counters_.samples;
    const size_t end = end_before_pause(*driver_, round, parts_done_, picture_at);
    RoundWork work(*driver_, *film_, parts_done_, end, film_is_ahead_);
    const RenderedParts parts = execute(loop, work);
    if (!parts.complete) loop.sink.interrupted();
    driver_->rendered(parts, *film_);
    if (!parts.complete) break;
    const bool round_done = parts.end == round.parts;
    // Asks the driver for its current round, because it may have released the finished one.
    parts_done_ = round_done ? driver_->round().parts : parts.end;
    progress.pass = round.pass;
    progress.samples = counters_.samples;
    progress.rays = counters_.rays.total();
    progress.completion = std::min(1.0, double(progress.samples) / double(frame_.crop.area()));
    progress.pass_finished = round.ends_pass && round_done;
    progress.error_estimate = driver_->error_estimate();
    loop.sink.picture_changed(progress, *this);
  }
  counters_.min_samples = driver_->min_samples(*film_);
  is_budget_spent_ |=
      budget && (driver_->finished() || loop.sink.stop_cause() == PixelStop::kTimeBudget);
  counters_.stopped = !driver_->finished() && !is_budget_spent_;
  unsampled_pixels_ = counters_.min_samples == 0 ? count_unsampled(*film_) : 0;
}

uint64_t RenderJob::job_bytes_per_pixel() const {
  if (drivers_.tiles) return 0;
  return film_bytes_per_pixel(frame_.aovs, film_extras()) + drivers_.bytes_per_pixel;
}

uint64_t RenderJob::film_bytes() const { return driver_ ? film_->bytes() + driver_->bytes() : 0; }

SampleReplay RenderJob::replay(int x, int y, uint32_t sample) const {
  RenderWorker worker(frame_);
  SampleReplay replay;
  replay.value = worker.replay(x, y, sample, &replay.camera_ray);
  replay.rays = worker.take_counters().rays;
  return replay;
}

std::optional<double> RenderJob::error_estimate() const {
  return driver_ ? driver_->error_estimate() : tile_error_;
}

void RenderJob::end(PixelStop interrupted) {
  if (!driver_) return;
  driver_->end(*film_, interrupted);
  store_driver_picture(*driver_, *film_);
}

// Delivers tiles of the same sizes and positions as those of the bucket driver. Pixels without
// samples get the values that the picture shows.
void RenderJob::deliver(RenderSink& sink) {
  if (!driver_) return;
  end(sink.stop_cause());
  const Rect& crop = film_->rect();
  const std::vector<Rect> tiles =
      bucket_schedule(crop, drivers_.tile_size, BucketOrder::kScanline, 0);
  // The picture is computed before the workers start, because the computation uses TBB. If a worker
  // waited for it, TBB could give that worker a tile that needs the picture.
  std::vector<float> shown;
  if (film_->min_samples() == 0) {
    shown.resize(4 * size_t(crop.area()));
    resolve(shown);
  }
  const auto groups = size_t(std::max(0, film_->extras().light_groups));
  const auto layers = PathLayers(film_->aovs()).list().size();
  std::vector<Rgb> lights, paths;
  if (!shown.empty() && groups > 0)
    lights = resolve_groups(*this, LightMix::Source::kLights, groups);
  if (!shown.empty() && layers > 0) paths = resolve_groups(*this, LightMix::Source::kPaths, layers);
  std::atomic<size_t> next{0};
  const auto work = [&](size_t /*worker*/) {
    const FlushDenormals flush;                     // the render workers do the same
    FilmTile tile(film_->aovs(), film_->extras());  // one per worker, to reuse its memory
    for (size_t i = next++; i < tiles.size(); i = next++) {
      const Rect& rect = tiles[i];
      tile.reset(rect);
      for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
          tile.copy_pixel(*film_, x, y);
          if (film_->sample_count(x, y) > 0) continue;
          const size_t pixel = crop.index_of(x, y);
          tile.set_override(x, y, &shown[4 * pixel]);
          if (groups > 0)
            tile.override_lights(x, y, std::span(lights).subspan(groups * pixel, groups));
          if (layers > 0)
            tile.override_layers(x, y, std::span(paths).subspan(layers * pixel, layers));
        }
      }
      sink.tile_finished(tile);
    }
  };
  parallel_tasks(std::min(tiles.size(), worker_count()), work);
}

}  // namespace emberline
