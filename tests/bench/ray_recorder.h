// Embree's own time for a frame: records every ray that the renderer hands to Embree, in order and
// per thread, and traces the same rays again with nothing around them.
//
// The linker puts the recorder between renderer and Embree (-Wl,--wrap, see CMakeLists.txt): not a
// line of the renderer knows of it, and the program that people run is not touched. In the
// benchmarks of frames it costs one predicted branch per ray while it does not record.
#pragma once

#include <cstdint>
#include <memory>

namespace emberline::bench {

struct ReplayRun {
  double cpu_s = 0;   // all threads together
  double wall_s = 0;  // from the common start to the end of the last
};

class RayRecorder {
 public:
  RayRecorder();  // starts recording
  ~RayRecorder();
  RayRecorder(const RayRecorder&) = delete;
  RayRecorder& operator=(const RayRecorder&) = delete;

  void stop();  // once the frame is done

  uint64_t rays() const;
  int threads() const;  // that brought any
  static uint64_t bytes_per_ray();

  // Traces every list again on a thread of its own, in its order, with the arguments, the filters
  // and the floating-point mode of the renderer, all lists at once.
  ReplayRun replay() const;
  // The same without the call into Embree: reading the list and setting up the ray. To be
  // subtracted.
  ReplayRun replay_without_embree() const;
  // Traces once more and compares: how many rays find something else than they did in the frame.
  uint64_t differences() const;

  struct Lists;

 private:
  std::unique_ptr<Lists> lists_;
};

}  // namespace emberline::bench
