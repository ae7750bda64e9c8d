// Measures Embree's own time for a frame: records every ray that the renderer passes to Embree, in
// order and per thread, and traces the same rays again in a bare loop.
//
// The linker puts the recorder between renderer and Embree (-Wl,--wrap, see CMakeLists.txt), so
// neither the renderer's sources nor the released program are affected. In the whole-frame
// benchmarks the recorder costs one predicted branch per ray while it does not record.
#pragma once

#include <cstdint>
#include <memory>

namespace emberline::bench {

struct ReplayRun {
  double cpu_s = 0;   // all threads together
  double wall_s = 0;  // from the common start to the end of the last thread
};

class RayRecorder {
 public:
  RayRecorder();  // starts recording
  ~RayRecorder();
  RayRecorder(const RayRecorder&) = delete;
  RayRecorder& operator=(const RayRecorder&) = delete;

  void stop();  // to be called after the frame

  uint64_t rays() const;
  int threads() const;  // number of threads that recorded any rays
  static uint64_t bytes_per_ray();

  // Traces the lists of all threads again at the same time, each list in order on its own thread,
  // with the renderer's arguments, filters and floating-point mode.
  ReplayRun replay() const;
  // Does the same without calling Embree: reads the lists and sets up the rays. Its time is to be
  // subtracted from that of replay().
  ReplayRun replay_without_embree() const;
  // Traces all rays once more, and returns how many give a different result than in the frame.
  uint64_t differences() const;

  struct Lists;

 private:
  std::unique_ptr<Lists> lists_;
};

}  // namespace emberline::bench
