#include "integrators/integrator.h"

#include <string>

#include "integrators/ambient_occlusion_integrator.h"
#include "integrators/debug_integrator.h"
#include "integrators/path_integrator.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

template <DebugView kView>
std::unique_ptr<Integrator> create_debug(const IntegratorSettings&) {
  return std::make_unique<DebugIntegrator>(kView);
}

constexpr IntegratorEntry kIntegrators[] = {
    {"path", "path tracing: all light, to --max-depth",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       return std::make_unique<PathIntegrator>(settings);
     }},
    {"direct", "direct light only: path with a depth of 1",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       IntegratorSettings direct = settings;
       direct.max_depth = 1;
       return std::make_unique<PathIntegrator>(direct);
     }},
    {"ambient_occlusion", "openness of the hemisphere, ignoring lights and materials",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       return std::make_unique<AmbientOcclusionIntegrator>(settings);
     }},
    {"normal", "shading normals", create_debug<DebugView::kNormal>},
    {"uv", "texture coordinates", create_debug<DebugView::kUv>},
    {"albedo", "directional albedo", create_debug<DebugView::kAlbedo>},
    {"depth", "depth along the viewing axis", create_debug<DebugView::kDepth>},
    {"material_id", "a colour per material", create_debug<DebugView::kMaterialId>},
};

}  // namespace

std::span<const IntegratorEntry> integrator_table() { return kIntegrators; }

std::unique_ptr<Integrator> create_integrator(std::string_view name,
                                              const IntegratorSettings& settings) {
  std::string valid;
  for (const IntegratorEntry& entry : kIntegrators) {
    if (entry.name == name) return entry.create(settings);
    valid += (valid.empty() ? "" : ", ") + std::string(entry.name);
  }
  throw UsageError("--integrator: unknown integrator '" + std::string(name) +
                   "'; valid names are " + valid);
}

}  // namespace emberline
