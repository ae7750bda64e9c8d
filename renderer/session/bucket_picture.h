// The frame of a driver that finishes one bucket after another and lets them go, kept so that it
// can be looked at.
#pragma once

#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "renderer/engine/render_sink.h"
#include "renderer/film/film.h"
#include "renderer/session/grading.h"

namespace emberline {

// Buckets come from many threads; whoever holds lock() has the picture for himself, and everything
// else here wants it held.
class BucketPicture final : public LivePicture {
 public:
  // Buckets appear over `before`: R G B A of each pixel, rows from the top.
  // `averages`: tiles may show something else than the means of their sums. `extras`: of the tiles
  // that come, as far as they are to be kept.
  BucketPicture(const Rect& crop, const AovSet& aovs, bool averages, std::vector<float> before,
                const FilmExtras& extras = {});

  std::unique_lock<std::mutex> lock() { return std::unique_lock(mutex_); }

  void begin(const Rect& pixels) { in_progress_.push_back(pixels); }
  void finish(const FilmTile& tile, const std::shared_ptr<const Grading>& grading);
  const std::vector<Rect>& in_progress() const { return in_progress_; }
  uint64_t samples() const { return samples_; }
  double completion() const { return double(pixels_) / double(film_.rect().area()); }
  // As displayed. Each bucket is graded once, when it comes, unless the grading changes.
  std::span<const uint8_t> rgba8(const std::shared_ptr<const Grading>& grading);

  // With what was there before where no bucket is yet; mixed on the calling thread alone.
  void resolve(std::span<float> rgba, const LightMix* mix = nullptr) const override;
  const FilmTile& film() const override { return film_; }
  // kNone for a bucket that is there, if its tiles have no `stop` channel.
  PixelStop stop_so_far(int x, int y) const override {
    return film_.sample_count(x, y) > 0 ? film_.stop(x, y) : PixelStop::kGoingOn;
  }

 private:
  std::mutex mutex_;
  FilmTile film_;
  const bool averages_;
  std::vector<float> rgba_;
  std::vector<uint8_t> rgba8_;
  std::shared_ptr<const Grading> grading_;  // of rgba8_
  std::vector<Rect> in_progress_;
  int64_t pixels_ = 0;
  uint64_t samples_ = 0;
};

}  // namespace emberline
