// The pilot of a planned frame: a cheap frame that measures the noise.
#pragma once

#include "renderer/drivers/sample_plan.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

// Returns the options of the pilot: an adaptive frame whose error estimates decide the sample
// counts. It has other samples than the frame.
RenderOptions pilot_of(const RenderOptions& planned);

// Returns the sample counts of the frame. The job must have rendered the whole pilot. Throws
// RenderError if the pilot has no error estimates.
SamplePlan planned_samples(const RenderJob& pilot, const RenderOptions& planned);

}  // namespace emberline
