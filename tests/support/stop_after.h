// A sink that stops a progressive frame at a given moment.
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stop_token>
#include <vector>

#include "renderer/engine/render_sink.h"
#include "support/render.h"

namespace emberline::test {

// Requests a stop when `samples` samples are finished. Checks every picture that the driver
// reports, and stores the finished tiles in `image`.
class StopAfter final : public RenderSink {
 public:
  // If `require_positive`, all values of all pictures must be positive.
  StopAfter(MemorySink& image, uint64_t samples, const Rect& crop, bool require_positive)
      : image_(image),
        samples_(samples),
        requires_positive_(require_positive),
        rgba_(4 * size_t(crop.area())) {}

  void tile_finished(const FilmTile& tile) override { image_.tile_finished(tile); }
  void samples_finished(uint64_t count) override {
    if ((done_ += count) >= samples_) stop_.request_stop();
  }
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override {
    EXPECT_GE(progress.samples, last_.samples);
    EXPECT_GE(progress.completion, last_.completion);
    EXPECT_GE(progress.pass, last_.pass);
    EXPECT_EQ(progress.samples, done_.load());
    last_ = progress;
    ++pictures_;
    picture.resolve(rgba_);
    for (size_t i = 0; i < rgba_.size(); ++i) {
      ASSERT_TRUE(std::isfinite(rgba_[i])) << "value " << i;
      if (requires_positive_) {
        ASSERT_GT(rgba_[i], 0.0f) << "value " << i;
      }
    }
  }
  PixelStop stop_cause() const override { return PixelStop::kTimeLimit; }

  std::stop_token token() const { return stop_.get_token(); }
  const JobProgress& last() const { return last_; }
  int pictures() const { return pictures_; }

 private:
  MemorySink& image_;
  uint64_t samples_;
  bool requires_positive_;
  std::vector<float> rgba_;
  std::atomic<uint64_t> done_{0};
  std::stop_source stop_;
  JobProgress last_;
  int pictures_ = 0;
};

}  // namespace emberline::test
