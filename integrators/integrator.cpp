#include "integrators/integrator.h"

#include "integrators/ambient_occlusion_integrator.h"
#include "integrators/debug_integrator.h"
#include "integrators/path_integrator.h"
#include "renderer/core/names.h"

namespace emberline {
namespace {

template <DebugView kView>
std::unique_ptr<Integrator> create_debug(const IntegratorSettings&) {
  return std::make_unique<DebugIntegrator>(kView);
}

constexpr IntegratorEntry kIntegrators[] = {
    {"path", "path tracing: all light, to `max-depth`",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       return std::make_unique<PathIntegrator>(settings);
     },
     false, true},
    {"direct", "direct light only: path with a depth of 1",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       IntegratorSettings direct = settings;
       direct.max_depth = 1;
       return std::make_unique<PathIntegrator>(direct);
     },
     false, true},
    {"ambient_occlusion", "openness of the hemisphere, ignoring lights and materials",
     [](const IntegratorSettings& settings) -> std::unique_ptr<Integrator> {
       return std::make_unique<AmbientOcclusionIntegrator>(settings);
     }},
    {"normal", "shading normals", create_debug<DebugView::kNormal>},
    {"uv", "texture coordinates", create_debug<DebugView::kUv>, true},
    {"albedo", "directional albedo", create_debug<DebugView::kAlbedo>},
    {"depth", "depth along the viewing axis", create_debug<DebugView::kDepth>},
    {"material_id", "a colour per material", create_debug<DebugView::kMaterialId>},
};

}  // namespace

std::span<const IntegratorEntry> integrator_table() { return kIntegrators; }

const IntegratorEntry& find_integrator(std::string_view name) {
  return find_named(kIntegrators, "`integrator`", "integrator", name);
}

std::unique_ptr<Integrator> create_integrator(std::string_view name,
                                              const IntegratorSettings& settings) {
  return find_integrator(name).create(settings);
}

}  // namespace emberline
