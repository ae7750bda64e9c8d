#include "integrators/integrator.h"

#include "integrators/integrator_kinds.h"
#include "renderer/core/names.h"

namespace emberline {
namespace {

template <DebugView kView>
std::unique_ptr<Integrator> create_view(const IntegratorSettings&) {
  return create_debug(kView);
}

std::unique_ptr<Integrator> create_direct(const IntegratorSettings& settings) {
  IntegratorSettings direct = settings;
  direct.max_depth = 1;
  return create_path(direct);
}

constexpr IntegratorEntry kIntegrators[] = {
    {"path", "full path tracing, up to `max-depth`", create_path, false, true, true},
    {"direct", "direct light only; the same as path with `max-depth` 1", create_direct, false,
     true},
    {"ambient_occlusion", "ambient occlusion, without lights and materials",
     create_ambient_occlusion},
    {"normal", "shading normals", create_view<DebugView::kNormal>},
    {"uv", "texture coordinates", create_view<DebugView::kUv>, true},
    {"albedo", "directional albedo", create_view<DebugView::kAlbedo>},
    {"depth", "depth along the viewing axis", create_view<DebugView::kDepth>},
    {"material_id", "a colour per material", create_view<DebugView::kMaterialId>},
    {"guide",
     "the direction from which guided paths expect light, as a colour; grey without a guide",
     create_view<DebugView::kGuide>, false, false, true},
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
