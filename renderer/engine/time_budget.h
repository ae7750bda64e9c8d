// `time-budget`: decides how many samples fit into a given time.
//
// The pace of the first samples (seconds per unit of work) decides how much work is planned. The
// plan is corrected twice, after three fifths of the time and shortly before its end. Work is
// counted in rays, as in drivers/adaptive/pixel_statistics.h; only the pace is read from a clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "renderer/drivers/frame.h"

namespace emberline {

// Returns the work of tracing these rays.
double work_of(const RayCounters& rays);

// Returns the seconds since the frame began to render.
using BudgetClock = std::function<double()>;

// Plans the work of a frame that has one driver.
class FrameBudget {
 public:
  // `work` is the work that an earlier run has done.
  FrameBudget(double seconds, BudgetClock clock, double work)
      : seconds_(seconds), clock_(std::move(clock)), last_work_(work) {}
  // Call when the driver has finished its planned work. Returns the factor by which the work so far
  // must grow, or nullopt if the frame ends now.
  std::optional<double> next_factor(double work);

 private:
  double seconds_;
  BudgetClock clock_;
  double last_work_, last_s_ = 0, pace_ = 0;
  size_t stage_ = 0;
  bool has_probed_ = false;
};

// The cost of one sample of every pixel of a tile, from several short measurements.
class TileCost {
 public:
  void add(double work, double seconds);
  double work() const { return count_ > 0 ? work_ / count_ : 0; }
  double seconds() const { return count_ > 0 ? seconds_ / count_ : 0; }
  // Returns the least measured seconds per work. A pause of the thread can only make a measurement
  // longer.
  double pace() const { return pace_; }

 private:
  double work_ = 0, seconds_ = 0, pace_ = 0;
  int count_ = 0;
};

// Returns, for each tile, the seconds that a thread without pauses needs for one sample of every
// pixel.
std::vector<double> tile_seconds(std::span<const TileCost> costs);
// Returns the factor by which pauses of threads lengthened the measurements. It is above 1 on a
// busy machine.
double tile_pauses(std::span<const TileCost> costs);

// Gives each tile of a tiled driver a number of samples per pixel. Thread-safe.
class TileBudget {
 public:
  // `costs` is the result of tile_seconds(). `seconds_per_work` is a first estimate of the pace of
  // all threads together. The constructor starts the time of the tiles. Every tile gets at least
  // `least` samples per pixel, even if the time does not suffice.
  TileBudget(double seconds, BudgetClock clock, std::vector<double> costs, double seconds_per_work,
             uint32_t least);

  // Returns the index of the tile that is rendered as the n-th, counted from 0. Expensive tiles
  // come first. At the end, when only cheap tiles are left, counts can still be corrected, and no
  // thread works much longer than the others. Tiles of similar cost are spread over the whole
  // frame, so that the pace of the first tiles is that of the frame.
  size_t tile_at(size_t n) const { return order_[n]; }
  // Call this instead of begin() for a tile that already has its samples.
  void skip(size_t tile);
  // Call when the tile begins. Returns its number of samples per pixel.
  uint32_t begin(size_t tile);
  void end(size_t tile);

 private:
  struct Tile {
    size_t index;
    double work, began_s;
  };
  void plan();
  bool correct();

  std::mutex mutex_;
  const double seconds_;
  const BudgetClock clock_;
  const double began_s_;
  const std::vector<double> costs_;
  const std::vector<size_t> order_;
  const double seconds_per_work_, least_;
  double samples_ = 1;      // samples per pixel of tiles that have not begun; at least least_
  double left_ = 0;         // costs of the tiles that have not begun
  double all_ = 0;          // costs of all tiles
  double finished_ = 0;     // work of the finished tiles
  double rounding_ = 0;     // sum of the rounding errors of the counts so far
  size_t corrections_ = 0;  // made so far
  std::vector<Tile> begun_;
};

}  // namespace emberline
