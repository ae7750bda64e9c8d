#include "integrators/path_integrator.h"

#include "integrators/path_glass.h"
#include "integrators/path_loop.h"
#include "integrators/recorders/all.h"
#include "integrators/recorders/hooks.h"

namespace emberline {

// All four path loops of the program: scenes without glass and batches without recorders pay for
// neither.
void PathIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                              std::span<SampleValue> values) const {
  const bool glass = batch.scene.passes_light();
  if (AllRecorders::wanted(batch)) {
    if (glass) {
      PathLoop<PathGlass, AllRecorders>(settings_, batch, samples, values).trace();
    } else {
      PathLoop<NoGlass, AllRecorders>(settings_, batch, samples, values).trace();
    }
  } else if (glass) {
    PathLoop<PathGlass, NoRecorder>(settings_, batch, samples, values).trace();
  } else {
    PathLoop<NoGlass, NoRecorder>(settings_, batch, samples, values).trace();
  }
}

}  // namespace emberline
