// Sums that a film keeps in addition to those of its channels.
#pragma once

namespace emberline {

// Sums requested by drivers and outputs.
struct FilmExtras {
  bool squares = false;  // squares of the radiance, for the variance of a sample
  bool rays = false;     // rays traced for a pixel, as the cost of its samples
  // Reserves 16 bytes per pixel for set_sample_variance(), if the film has the `variance` channel.
  bool sample_variance = false;
  // Number of light groups, or -1 if light groups are not recorded. Each pixel takes 24 bytes for
  // each group, plus 24 bytes.
  int light_groups = -1;
  // Number of Cryptomatte kinds, and number of ids kept for each kind (CryptomatteSums).
  int cryptomattes = 0, cryptomatte_levels = 0;
};

}  // namespace emberline
