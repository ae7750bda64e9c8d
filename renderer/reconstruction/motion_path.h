// Follows what the pixels of a frame show through the frames of a sequence.
#pragma once

#include <span>
#include <vector>

namespace emberline {

// The layer `velocity` of some rows of a frame: the motion of each pixel, in pixels per frame to
// the right and up.
struct VelocityRows {
  int width = 0, frame_height = 0;
  int y0 = 0;  // the first row
  std::span<const float> right, up;
};

// For each pixel of some rows, the position in some frame of what the pixel shows, in pixels of the
// whole frame. NaN if that left the frame, or is more than kMotionReach rows from where it was in
// the frame.
class MotionPath {
 public:
  // The positions in the frame itself, of rows [begin, end).
  MotionPath(int width, int frame_height, int begin, int end);

  // Continues the path from the frame that it has reached to the next frame, or to the frame
  // before. Positions are between pixels, where velocities are interpolated bilinearly. A step back
  // looks for the position whose velocity leads here, by fixed-point iteration. `here` and `there`
  // must include all rows of these frames within kMotionReach + kVelocityReach of the path's rows,
  // or, of the frame itself, the path's rows. Runs in parallel.
  void step_forward(const VelocityRows& here);
  void step_back(const VelocityRows& here, const VelocityRows& there);

  std::span<const float> x() const { return x_; }
  std::span<const float> y() const { return y_; }

 private:
  template <typename Step>
  void move(const Step& step);

  int width_, frame_height_, begin_, end_;
  std::vector<float> x_, y_;
};

inline constexpr int kMotionReach = 64;
inline constexpr int kVelocityReach = 1;

}  // namespace emberline
