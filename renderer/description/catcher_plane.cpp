#include "renderer/description/catcher_plane.h"

#include <fmt/format.h>

#include <cmath>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"

namespace emberline {
namespace {

constexpr const char* kName = "catcher plane";
// The following lengths are in radii of the scene.
constexpr double kExtent = 100.0;  // only a sun below 1.2 degrees casts longer shadows
constexpr double kMaxDistance = 1000.0;
constexpr double kGap = 1e-4;  // below the lowest point

// A square with corners at +-1 that faces +Y.
MeshDescription unit_square(int material) {
  MeshDescription square;
  square.name = kName;
  square.material = material;
  square.positions = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  return square;
}

MaterialDescription grey() {
  MaterialDescription material;
  material.name = kName;
  material.base_color = Rgb(kCatcherPlaneAlbedo);
  material.metallic = 0.0f;
  material.specular = 0.0f;
  return material;
}

}  // namespace

void add_catcher_plane(std::optional<double> height, SceneDescription& scene) {
  WorldBounds bounds = framed_bounds(scene);
  if (!scene.rest_bounds) scene.rest_bounds = bounds;
  if (bounds.isEmpty()) bounds.extendBy(Vec3d(0.0));
  const double radius = bounds.radius() > 0.0 ? bounds.radius() : 1.0;
  const double y = height.value_or(bounds.min.y - kGap * radius);
  const Vec3d center = bounds.center();
  if (std::abs(y - center.y) > kMaxDistance * radius) {
    throw UsageError(
        "`catcher-plane`: the height {} is far away from the scene, whose heights are {:.6g} to "
        "{:.6g}",
        y, bounds.min.y, bounds.max.y);
  }
  if (y > bounds.max.y) {
    log_warning(fmt::format(
        "`catcher-plane`: the plane at height {} is above the scene, whose heights are {:.6g} to "
        "{:.6g}",
        y, bounds.min.y, bounds.max.y));
  }
  scene.materials.push_back(grey());
  scene.meshes.push_back(unit_square(int(scene.materials.size()) - 1));
  InstanceDescription& plane = scene.instances.emplace_back();
  plane.name = kName;
  plane.mesh = int(scene.meshes.size()) - 1;
  plane.to_world[0][0] = plane.to_world[2][2] = kExtent * radius;
  plane.to_world[3][0] = center.x;
  plane.to_world[3][1] = y;
  plane.to_world[3][2] = center.z;
  NodeDescription& node = scene.nodes.emplace_back();
  node.name = kName;
  plane.node = node.root = int(scene.nodes.size()) - 1;
  node.has_mesh = node.in_scene = node.catches_shadows = true;
}

}  // namespace emberline
