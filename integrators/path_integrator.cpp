#include "integrators/path_integrator.h"

#include "integrators/path_batch.h"

namespace emberline {

void PathIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                              std::span<SampleValue> values, RayCounters& counters) const {
  const bool glass = batch.scene.has_transmission();
  if (batch.light_values) {
    if (glass) {
      PathBatch<true, true>(settings_, batch, samples, counters).trace(values);
    } else {
      PathBatch<false, true>(settings_, batch, samples, counters).trace(values);
    }
  } else if (glass) {
    PathBatch<true, false>(settings_, batch, samples, counters).trace(values);
  } else {
    PathBatch<false, false>(settings_, batch, samples, counters).trace(values);
  }
}

}  // namespace emberline
