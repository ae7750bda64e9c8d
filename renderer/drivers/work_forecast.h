// A prediction of the work of a whole frame, based on its samples so far.
#pragma once

namespace emberline {

struct WorkForecast {
  double samples = 0;  // of all pixels at the end of the frame
  double work = 1;     // work of the whole frame, as a multiple of the work so far
};

}  // namespace emberline
