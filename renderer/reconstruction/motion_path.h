// Follows the surface points that a frame's pixels show through the frames of a sequence.
#pragma once

#include <span>
#include <vector>

namespace emberline {

// The layer `velocity` of some rows of a frame: the motion of each pixel, in pixels per frame to
// the right and up. To this, the layer `specular_velocity` is added, if there is one.
struct VelocityRows {
  int width = 0, frame_height = 0;
  int y0 = 0;  // the first row
  std::span<const float> right, up;
  std::span<const float> specular_right = {}, specular_up = {};
};

// For each pixel of some rows of a frame, the position of the surface point that the pixel shows,
// in the frame that the path has reached. Positions are in pixels of the whole frame. They are NaN
// if the point has left the frame or has moved by more than kMotionReach rows.
class MotionPath {
 public:
  // Starts in the frame itself, with the pixels of rows [begin, end).
  MotionPath(int width, int frame_height, int begin, int end);

  // Move the path to the next or to the previous frame. `here` belongs to the frame that the path
  // has reached, and `there` to the previous frame. Positions lie between pixels, so velocities are
  // interpolated bilinearly. step_back() searches by fixed-point iteration for the position whose
  // velocity leads to the current one. Both arguments must include all rows within kMotionReach +
  // kVelocityReach of the path's rows. In the frame in which the path starts, the path's rows are
  // enough. Run in parallel.
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
