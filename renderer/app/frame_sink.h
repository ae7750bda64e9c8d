// The sink through which a CommandFrame observes its render. Private to command_frame.cpp.
#pragma once

#include <atomic>

#include "renderer/app/command_frame.h"
#include "renderer/app/progress.h"
#include "renderer/engine/render_sink.h"

namespace emberline {

// Passes finished tiles to the files and the report. During the render, also updates the progress,
// records passes, takes snapshots and updates the viewer.
class CommandFrame::FrameSink final : public RenderSink {
 public:
  // `progress` is null if the frame is already rendered and is only delivered to the files.
  FrameSink(CommandFrame& frame, ProgressDisplay* progress) : frame_(frame), progress_(progress) {}

  void tile_finished(const FilmTile& tile) override {
    write(tile);
    // With a noise threshold, the number of samples is unknown. But buckets finish one by one, so
    // the fraction of finished pixels shows the progress.
    if (progress_ && frame_.job_->is_tiled()) progress_->add_fraction(tile_fraction(tile));
  }
  void tile_loaded(const FilmTile& tile, uint64_t samples) override {
    write(tile);
    resumed_samples_ += samples;
    if (progress_) progress_->add_resumed(samples, tile_fraction(tile));
  }
  void samples_loaded(uint64_t count) override {
    resumed_samples_ += count;
    if (progress_) progress_->add_resumed(count, 0);
  }
  uint64_t resumed_samples() const { return resumed_samples_; }
  void write(const FilmTile& tile) {
    frame_.outputs_->tile_finished(tile);
    if (frame_.pictures_) frame_.pictures_->add(tile);
    if (frame_.viewer_) frame_.viewer_->add(tile);
  }
  void samples_finished(uint64_t count) override {
    if (!progress_) return;
    if (!begun_.load(std::memory_order_relaxed) && !begun_.exchange(true)) {
      RenderTimes& times = frame_.report_.times;
      const double since_s = frame_.run_.wall.seconds();
      times.first_sample_s = frame_.run_.first ? process_age_seconds().value_or(since_s) : since_s;
      times.first_sample_cpu_s = process_cpu_seconds() - frame_.run_.cpu_before_s;
    }
    progress_->add(count);
  }
  void picture_changed(const JobProgress& now, const LivePicture& picture) override {
    if (!progress_) return;
    frame_.on_picture_changed(now, picture);
    if (frame_.expected_s_) progress_->expect(*frame_.expected_s_);
  }
  void interrupted() override { frame_.checkpoint_.save(*frame_.job_); }
  bool needs_picture() const override {
    if (frame_.checkpoint_.is_due()) return true;
    if (!progress_ || (!frame_.snapshots_ && !frame_.viewer_)) return false;
    const double elapsed = frame_.clock_->seconds();
    return (frame_.snapshots_ && frame_.snapshots_->is_due(elapsed)) ||
           (frame_.viewer_ && frame_.viewer_->is_due(elapsed));
  }
  std::optional<uint64_t> next_picture_at() const override {
    return progress_ && frame_.snapshots_ ? frame_.snapshots_->next_sample_count() : std::nullopt;
  }
  PixelStop stop_cause() const override { return frame_.stop_.cause(); }

 private:
  double tile_fraction(const FilmTile& tile) const {
    return double(tile.rect().area()) / (double(frame_.plan_.crop.area()) * frame_.part_of_frame());
  }

  CommandFrame& frame_;
  ProgressDisplay* const progress_;
  std::atomic<bool> begun_{false};
  std::atomic<uint64_t> resumed_samples_{0};
};

}  // namespace emberline
