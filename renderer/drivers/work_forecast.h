// How much work a frame needs in all, as far as its samples so far can tell.
#pragma once

namespace emberline {

struct WorkForecast {
  double samples = 0;  // of all pixels at the end of the frame
  double work = 1;     // time of the whole frame over the time so far
};

}  // namespace emberline
