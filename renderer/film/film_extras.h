// What a film keeps beside its channels.
#pragma once

namespace emberline {

// What a driver wants accumulated for its own decisions, beside the channels.
struct FilmExtras {
  bool squares = false;  // of the radiance: the variance of a sample
  bool rays = false;     // traced for a pixel: what its samples cost
  // Room for set_sample_variance(), if the `variance` channel is asked for: 16 bytes a pixel.
  bool sample_variance = false;
  // What each of so many groups gave: 24 bytes a pixel for each, and 24 more. -1: not kept apart.
  int light_groups = -1;
  // Lists of so many ids for each of so many kinds: CryptomatteSums.
  int cryptomattes = 0, cryptomatte_levels = 0;
};

}  // namespace emberline
