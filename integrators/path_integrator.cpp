// `path`: unidirectional path tracing with next-event estimation. Light samples and one BSDF sample
// per vertex are combined by the balance heuristic (Veach & Guibas 1995, "Optimally Combining
// Sampling Techniques for Monte Carlo Rendering").
//
// `direct` is the same integrator with a depth limit of 1.
#include "integrators/integrator_kinds.h"
#include "integrators/path_glass.h"
#include "integrators/path_loop.h"
#include "integrators/recorders/all.h"
#include "integrators/recorders/hooks.h"

namespace emberline {
namespace {

class PathIntegrator final : public Integrator {
 public:
  explicit PathIntegrator(const IntegratorSettings& settings) : settings_(settings) {}

  // Picks one of four instances of the path loop, so that scenes without glass do not pay for
  // glass, and batches without recorders do not pay for recorders.
  void estimate(const SampleBatch& batch, PixelSamples& samples,
                std::span<SampleValue> values) const override {
    const bool glass = batch.scene.is_transmissive();
    if (AllRecorders::is_enabled(batch)) {
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

 private:
  IntegratorSettings settings_;
};

}  // namespace

std::unique_ptr<Integrator> create_path(const IntegratorSettings& settings) {
  return std::make_unique<PathIntegrator>(settings);
}

}  // namespace emberline
