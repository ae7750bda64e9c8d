// The pixels of a frame that no surface comes near: their camera rays meet nothing and need not be
// traced.
//
// Every triangle is projected onto the film, with what the pixel filter reaches and what rounding
// may move it by around it. What is left over is empty for certain: where a ray passes by closely,
// its pixel counts as used. A pure function of scene, camera and frame, so that all drivers, crops
// and replays leave out the same rays.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace emberline {

class Camera;
class Scene;

class EmptyPixels {
 public:
  // `reach`: how far from a pixel's centre its samples lie, in pixels (PixelFilter::radius). Null
  // where nothing is gained: hardly a pixel is empty, or there are so many or so large triangles
  // that to project them takes longer than to trace rays past them; and where pixels see more than
  // one projection shows: what moves, lenses, orthographic cameras. Uses all threads.
  static std::shared_ptr<const EmptyPixels> find(const Scene& scene, const Camera& camera,
                                                 int width, int height, float reach);

  // Of a pixel of the frame. Thread-safe.
  bool contains(int x, int y) const {
    return used_[size_t(y >> shift_) * size_t(columns_) + size_t(x >> shift_)] == 0;
  }

 private:
  class Projection;

  EmptyPixels(int width, int height);
  bool mark_all(const Scene& scene, const Projection& projection);
  bool gains() const;

  // Cells of 2^shift_ pixels a side; what is not empty is 1.
  int shift_ = 0, columns_ = 0, rows_ = 0;
  std::vector<uint8_t> used_;
};

}  // namespace emberline
