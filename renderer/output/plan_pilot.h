// The pilot of a planned frame: a cheap frame that measures the noise.
#pragma once

#include "renderer/output/render_options.h"

namespace emberline {

// Returns the options of the pilot: an adaptive frame whose error estimates decide the sample
// counts (RenderJob::planned_counts()). It has other samples than the frame.
RenderOptions pilot_of(const RenderOptions& planned);

}  // namespace emberline
