// How large the error of the whole window is, for the report: what no stopping rule goes by.
#pragma once

#include "renderer/drivers/adaptive/pixel_statistics.h"

namespace emberline {

// Expected RMS error of the window as it is displayed (sRGB, [0, 1]), over pixels and channels:
// from each pixel's own two streams, at its own mean. One pixel's difference says little, but the
// mean of thousands of squares is sure; pooled over neighbours first, as a decision about a pixel
// needs it, noise beside a highlight would be weighed by the steep curve of the shadow next to it,
// and what is next to a lamp as clipped. Where there is no second stream, as if samples were
// independent. Finite. The same for any threads.
double frame_error(const PixelStatistics& pixels);

}  // namespace emberline
