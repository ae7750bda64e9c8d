// The files a frame is written to while it renders.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/display.h"
#include "io/exr_writer.h"
#include "renderer/app/render_options.h"
#include "renderer/core/rect.h"
#include "renderer/drivers/frame_driver.h"

namespace emberline {

struct OutputSettings {
  int width = 0, height = 0;
  Rect window;
  int tile_size = 64;
  AovSet aovs;
  std::vector<std::pair<std::string, std::string>> attributes;
  DisplaySettings display;
  bool transparent = false;  // PNG gets an alpha channel
};

// Passes finished tiles on to every file, and the count of samples to the progress display.
class FrameOutputs final : public FrameObserver {
 public:
  // Opens the files at once, so that a path that cannot be written is known before the render and
  // not after it. Throws RenderError for an unwritable path, UsageError for an unknown display.
  FrameOutputs(const std::vector<std::string>& paths, const OutputSettings& settings);

  void on_samples(std::function<void(uint64_t)> callback) { on_samples_ = std::move(callback); }

  void tile_finished(const FilmTile& tile) override;
  void samples_finished(uint64_t count) override;

  // Completes and renames the files. Throws RenderError.
  void finish();

  // What the film held at most, for the report.
  uint64_t film_bytes() const { return film_bytes_.load(); }
  std::string display_description() const;

 private:
  std::vector<std::unique_ptr<ExrWriter>> exrs_;
  std::vector<std::unique_ptr<DisplayImageWriter>> images_;
  std::shared_ptr<const DisplayTransform> transform_;
  std::function<void(uint64_t)> on_samples_;
  std::atomic<uint64_t> film_bytes_{0};
};

// Throws UsageError for what is wrong with the names alone: an unknown suffix, one file named
// twice, an input that would be overwritten, a frame larger than the format holds.
void check_output_paths(const RenderOptions& options, const Rect& window);

}  // namespace emberline
