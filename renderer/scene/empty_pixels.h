// Finds the pixels near which there is no surface. The camera rays of these pixels hit nothing and
// need not be traced.
//
// Every triangle is projected onto the film and widened by the pixel filter's reach and by a bound
// on the rounding errors. The remaining pixels are certainly empty; a pixel that a triangle
// narrowly misses counts as used. The map is a pure function of the scene, the camera and the
// frame, so all drivers, crops and replays skip the same rays.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace emberline {

class Camera;
class Scene;

class EmptyPixels {
 public:
  // `reach` is the maximum distance of a pixel's samples from its centre, in pixels
  // (PixelFilter::radius). Returns null if the map would save nothing: if hardly any pixels are
  // empty, or if projecting the triangles would take longer than tracing the rays. Also returns
  // null for motion, lenses, orthographic cameras and panoramas, because the map is made for a
  // single pinhole view. Uses all threads.
  static std::shared_ptr<const EmptyPixels> find(const Scene& scene, const Camera& camera,
                                                 int width, int height, float reach);

  // Returns whether a pixel of the frame is empty. Thread-safe.
  bool contains(int x, int y) const {
    return used_[size_t(y >> shift_) * size_t(columns_) + size_t(x >> shift_)] == 0;
  }

 private:
  class Projection;

  EmptyPixels(int width, int height);
  bool mark_all(const Scene& scene, const Projection& projection);
  bool is_worthwhile() const;

  // Cells are 2^shift_ pixels wide and high; a cell's value is 1 if it is not empty.
  int shift_ = 0, columns_ = 0, rows_ = 0;
  std::vector<uint8_t> used_;
};

}  // namespace emberline
