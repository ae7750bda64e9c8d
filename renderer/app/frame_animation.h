// The frames of a sequence as an animated GIF.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/core/load_progress.h"
#include "renderer/output/scaled_picture.h"

namespace emberline {

inline constexpr double kAnimationFps = 24;
inline constexpr int kMinAnimationFps = 1, kMaxAnimationFps = 50;  // players slow down above 50

bool is_gif(std::string_view path);

// Collects frames one after another. Frames are scaled down so that no side exceeds `max_side`.
class FrameAnimation {
 public:
  // All frames have the size of `window`, or of the first frame if it is empty.
  explicit FrameAnimation(int max_side, const Rect& window = {})
      : max_side_(max_side), window_(window) {}

  // Begins a frame with these pixels. A frame that was not ended is dropped. Throws InputError,
  // which names `path`, for a frame of another size, and LimitError if the animation
  // exceeds the budget of `progress`.
  void begin(const Rect& window, const std::string& path, const LoadProgress& progress);
  // Adds linear R G B A to the frame, over black.
  void add(const Rect& band, std::span<const float> rgba) { frame_->add(band, rgba, 4); }
  void end(const DisplayTransform& transform);

  size_t size() const { return frames_.size(); }
  int width() const { return frames_.front().width; }
  int height() const { return frames_.front().height; }
  // There must be a frame. A frame's time is rounded to hundredths of a second. Throws RenderError,
  // which names `path`.
  std::vector<unsigned char> encode(double fps, const std::string& path) const;

 private:
  const int max_side_;
  Rect window_;
  std::optional<ScaledPicture> frame_;
  std::vector<ByteImage> frames_;
};

}  // namespace emberline
