#include "renderer/drivers/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "integrators/path_media.h"
#include "renderer/core/archive.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/core/readable.h"
#include "renderer/drivers/frame_driver.h"
#include "renderer/film/film.h"
#include "renderer/film/light_mix.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/interior.h"
#include "renderer/scene/light_groups.h"
#include "renderer/scene/scene.h"

namespace emberline {

namespace {

bool comes_before(const NonFiniteSample& a, const NonFiniteSample& b) {
  return std::tie(a.y, a.x, a.sample, a.seed) < std::tie(b.y, b.x, b.sample, b.seed);
}

}  // namespace

void warn_about_optics(const OpticsCounters& c) {
  if (c.rays_ended_at_panes > 0) {
    log_warning(fmt::format(
        "{} rays were stopped after {} panes in a row: the scene behind them is too dark",
        c.rays_ended_at_panes, kMaxWalls));
  }
  if (c.dropped_solids > 0) {
    log_warning(fmt::format(
        "{} times, a path was inside more than {} solids at once and ignored one of them, so "
        "refraction is wrong there",
        c.dropped_solids, Interior::kLimit));
  }
  constexpr double kMinReportedFraction = 1e-3;
  if (c.blocked_fraction() >= kMinReportedFraction) {
    log_warning(
        fmt::format("smooth solid glass alone blocked {} of the light samples of point, spot and "
                    "directional lights: surfaces behind it stay dark. Light them with emissive "
                    "surfaces or an environment, or give the glass a thicknessFactor of 0",
                    readable_percent(c.blocked_fraction())));
  }
}

bool Frame::moves() const { return scene.moves() || camera.moves(); }

FilmExtras Frame::with_light_groups(FilmExtras extras) const {
  if (light_groups) extras.light_groups = light_groups->size();
  return extras;
}

RenderCounters Frame::empty_counters() const {
  RenderCounters counters;
  if (clamp_indirect > 0.0f) {
    counters.clamped = ClampedLight(clamp_indirect, light_groups ? light_groups->size() : 0);
  }
  return counters;
}

void RenderCounters::locate(const NonFiniteSample& sample) {
  located.insert(std::ranges::upper_bound(located, sample, comes_before), sample);
  if (located.size() > kMaxLocated) located.pop_back();
}

void RenderCounters::merge(const RenderCounters& other) {
  rays.merge(other.rays);
  max_samples = std::max(max_samples, other.max_samples);
  samples += other.samples;
  non_finite_samples += other.non_finite_samples;
  clamped.merge(other.clamped);
  optics.merge(other.optics);
  located.insert(located.end(), other.located.begin(), other.located.end());
  std::ranges::sort(located, comes_before);
  if (located.size() > kMaxLocated) located.resize(kMaxLocated);
}

void RenderCounters::archive(Archive& archive) {
  constexpr uint64_t kLimit = UINT64_MAX / 4;  // so that sums of a few counters do not overflow
  for (uint64_t* count : {&rays.camera, &rays.scatter, &rays.shadow, &samples, &non_finite_samples,
                          &optics.rays_ended_at_panes, &optics.dropped_solids,
                          &optics.point_light_samples, &optics.blocked_by_glass}) {
    archive.number(*count, uint64_t(0), kLimit);
  }
  archive.number(min_samples, 0u, UINT32_MAX);
  archive.number(max_samples, 0u, UINT32_MAX);
  clamped.archive(archive);
  archive.list(located, kMaxLocated);
  archive.check(located.empty() == (non_finite_samples == 0));
}

void FrameDriver::resolve(const FilmTile& film, std::span<float> rgba, const LightMix* mix) const {
  if (mix) return relight(film, *mix, rgba);
  const Rect& pixels = film.rect();
  constexpr size_t kGrain = 4096;  // the same as in relight()
  parallel_ranges(size_t(pixels.area()), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) film.rgba(pixels.x_of(i), pixels.y_of(i), &rgba[4 * i]);
  });
}

}  // namespace emberline
