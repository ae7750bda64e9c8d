// What the progressive drivers share: the film of the whole window, and the workers that carry out
// one slice of a schedule after another over it.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "renderer/drivers/frame_driver.h"

namespace emberline {

// Carries out slices. Between two calls of run() no worker is at work, so that drivers decide and
// observers look at a film that stands still.
class SliceRunner {
 public:
  SliceRunner(const Frame& frame, FilmTile& film, FrameObserver& observer, std::stop_token stop);

  // Writes the `part`-th part of a slice into an empty list; called from worker threads.
  using Expand = std::function<void(size_t part, std::vector<PixelWork>& list)>;

  // Carries out the slice's parts, in order as workers become free. No pixel may be in two parts.
  // False if a stop was requested before all was done. Rethrows what an observer throws.
  bool run(size_t parts, const Expand& expand);

  // The same, but ends with the parts that are under way when the observer wants the picture:
  // `parts`, not 0, becomes the number of those that are done, always the first ones.
  bool run_until_wanted(size_t& parts, const Expand& expand);

  // Those of the last slice's parts that a stop request may have ended before all was done: at most
  // one of each worker.
  std::span<const size_t> cut_short() const { return cut_short_; }

  // How many samples the next slice is to bring, at least 1, if a picture is wanted at some number
  // of them (FrameObserver::picture_wanted_at).
  std::optional<uint64_t> samples_until_wanted() const;

  // Draws the following slices' samples from another seed than the frame's.
  void set_seed(uint32_t seed) { seed_ = seed; }

  // Of all slices so far, but for min_samples, which is the driver's to say.
  const FrameCounters& counters() const { return counters_; }

 private:
  size_t carry_out(size_t parts, const Expand& expand, bool until_wanted);

  const Frame& frame_;
  FilmTile& film_;
  FrameObserver& observer_;
  std::stop_token stop_;
  uint32_t seed_;
  std::mutex mutex_;
  FrameCounters counters_;
  std::vector<size_t> cut_short_;
};

// What a film holds of a pixel, in bytes, and deliver_film() on top where it fills in.
uint64_t film_bytes_per_pixel(const AovSet& aovs, const FilmExtras& extras);

// Makes the film ready for the window. Throws RenderError if there is not the memory for it.
void reset_film(const Rect& window, FilmTile* film);

// Hands the film to the observer as finished tiles of size x size pixels, aligned as the bucket
// driver's. Pixels without samples are shown as `picture` has them.
// With `all_shown`, so are all pixels.
void deliver_film(const FramePicture& picture, int tile_size, FrameObserver& observer,
                  bool all_shown = false);

}  // namespace emberline
