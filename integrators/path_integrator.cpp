#include "integrators/path_integrator.h"

#include "integrators/path_batch.h"
#include "samplers/pixel_samples.h"

namespace emberline {

void PathIntegrator::estimate(const SampleBatch& batch, PixelSamples& samples,
                              std::span<SampleValue> values) const {
  const bool glass = batch.scene.passes_light();
  if (batch.light_values || batch.layer_values) {
    if (glass) {
      PathBatch<true, true>(settings_, batch, samples).trace(values);
    } else {
      PathBatch<false, true>(settings_, batch, samples).trace(values);
    }
  } else if (glass) {
    PathBatch<true, false>(settings_, batch, samples).trace(values);
  } else {
    PathBatch<false, false>(settings_, batch, samples).trace(values);
  }
}

}  // namespace emberline
