// Builds scenes for tests. They are built in code so that a test shows all its numbers.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>

#include "renderer/core/constants.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_description.h"
#include "renderer/scene/build_scene.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace emberline::test {

// Returns a material with ideal diffuse reflection of `albedo`, without a dielectric coat.
inline MaterialDescription lambert(const Rgb& albedo) {
  MaterialDescription m;
  m.base_color = albedo;
  m.metallic = 0.0f;
  m.roughness = 1.0f;
  m.specular = 0.0f;
  return m;
}

inline MaterialDescription emitter(const Rgb& radiance) {
  MaterialDescription m = lambert(Rgb(0.0f));
  m.emission = radiance;
  return m;
}

inline MaterialDescription metal(const Rgb& color, float roughness) {
  MaterialDescription m;
  m.base_color = color;
  m.metallic = 1.0f;
  m.roughness = roughness;
  return m;
}

class SceneBuilderForTests {
 public:
  SceneDescription description;

  SceneBuilderForTests() { description.file = "test scene"; }

  int add_material(const MaterialDescription& m) {
    description.materials.push_back(m);
    return int(description.materials.size()) - 1;
  }

  int add_mesh(MeshDescription mesh) {
    description.meshes.push_back(std::move(mesh));
    return int(description.meshes.size()) - 1;
  }

  void place(int mesh, const Mat44d& to_world = Mat44d()) {
    description.instances.push_back({"instance", mesh, to_world});
  }

  // The corners must be counter-clockwise as seen from the front.
  void add_quad(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d, int material) {
    MeshDescription mesh;
    mesh.name = "quad";
    for (const Vec3f* corner : {&a, &b, &c, &d}) mesh.positions.push_back(*corner);
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.uv_sets = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    mesh.material = material;
    place(add_mesh(std::move(mesh)));
  }

  // Adds a horizontal square with sides of 2 h at height y. It faces +Y if `up`, and -Y otherwise.
  void add_floor(float h, float y, int material, bool up = true) {
    if (up) {
      add_quad({-h, y, h}, {h, y, h}, {h, y, -h}, {-h, y, -h}, material);
    } else {
      add_quad({-h, y, -h}, {h, y, -h}, {h, y, h}, {-h, y, h}, material);
    }
  }

  // Returns a closed box.
  static MeshDescription box(const Vec3f& low, const Vec3f& high, int material) {
    MeshDescription mesh;
    mesh.name = "box";
    mesh.material = material;
    for (int i = 0; i < 8; ++i) {
      mesh.positions.emplace_back((i & 1 ? high : low).x, (i & 2 ? high : low).y,
                                  (i & 4 ? high : low).z);
    }
    mesh.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    return mesh;
  }
  void add_box(const Vec3f& low, const Vec3f& high, int material) {
    place(add_mesh(box(low, high, material)));
  }

  // Returns a latitude-longitude sphere of `rings` x 2 `rings` faces. The faces are flat unless
  // `smooth`, and they face inwards if `inward`.
  static MeshDescription sphere(float radius, int rings, int material, bool inward = false,
                                bool smooth = false) {
    MeshDescription mesh;
    mesh.name = "sphere";
    mesh.material = material;
    const int columns = 2 * rings;
    for (int r = 0; r <= rings; ++r) {
      const double theta = kPiD * r / rings;
      for (int c = 0; c < columns; ++c) {
        const double phi = 2 * kPiD * c / columns;
        const Vec3f n(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                      float(std::sin(theta) * std::sin(phi)));
        mesh.positions.push_back(n * radius);
        if (smooth) mesh.normals.push_back(inward ? -n : n);
      }
    }
    const auto at = [&](int r, int c) { return uint32_t(r * columns + c % columns); };
    for (int r = 0; r < rings; ++r) {
      for (int c = 0; c < columns; ++c) {
        const uint32_t a = at(r, c), b = at(r, c + 1), d = at(r + 1, c), e = at(r + 1, c + 1);
        // Each pole has one vertex per column, and all of them are at the same place.
        if (r > 0) mesh.triangles.push_back(inward ? std::array{a, d, b} : std::array{a, b, d});
        if (r + 1 < rings) {
          mesh.triangles.push_back(inward ? std::array{b, d, e} : std::array{b, e, d});
        }
      }
    }
    return mesh;
  }

  void set_environment(const Rgb& radiance) {
    EnvironmentDescription e;
    e.constant = radiance;
    description.environment = e;
  }

  void set_environment(std::shared_ptr<const Image> image) {
    EnvironmentDescription e;
    e.file = "test";
    e.image = std::move(image);
    description.environment = e;
  }

  void add_point_light(const Vec3d& position, const Rgb& intensity) {
    PunctualLightDescription light;
    light.intensity = intensity;
    light.to_world = Mat44d();
    for (int c = 0; c < 3; ++c) light.to_world[3][c] = position[c];
    description.lights.push_back(light);
  }

  std::unique_ptr<Scene> build(const SceneBuildOptions& options = {}) const {
    return build_scene(description, options);
  }
};

inline CameraDescription perspective(const Vec3d& from, const Vec3d& at, double fov_degrees) {
  CameraDescription camera;
  camera.name = "test camera";
  camera.fov_y = fov_degrees * kPiD / 180;
  camera.to_world = look_at_matrix(from, at);
  return camera;
}

inline CameraDescription orthographic(const Vec3d& from, const Vec3d& at, double half_height) {
  CameraDescription camera = perspective(from, at, 1);
  camera.orthographic = true;
  camera.y_mag = half_height;
  return camera;
}

inline Mat44d translation(double x, double y, double z) {
  Mat44d m;
  m[3][0] = x;
  m[3][1] = y;
  m[3][2] = z;
  return m;
}

inline Mat44d scaling(double x, double y, double z) {
  return {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1};
}
inline Mat44d scaling(double s) { return scaling(s, s, s); }

}  // namespace emberline::test
