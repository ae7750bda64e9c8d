// Scenes in motion, and what they are at one time, by formulas of their own.
#pragma once

#include <cmath>
#include <functional>

#include "support/glass_scenes.h"
#include "support/scenes.h"

namespace emberline::test {

// About +Z, counter-clockwise.
inline Mat44d turned(double radians) {
  Mat44d m;
  m[0][0] = m[1][1] = std::cos(radians);
  m[0][1] = std::sin(radians);
  m[1][0] = -m[0][1];
  return m;
}

// A room of things that turn by up to a quarter of a turn and go straight meanwhile.
class MovingScene {
 public:
  using Pose = std::function<Mat44d(double)>;
  static constexpr int kSteps = 3;

  SceneBuilderForTests at(double time) const { return build({time}); }
  SceneBuilderForTests at_all_times() const {
    std::vector<double> times;
    for (int i = 0; i < kSteps; ++i) times.push_back(double(i) / (kSteps - 1));
    return build(times);
  }
  CameraDescription view_at(double time) const { return look({time}); }
  CameraDescription view() const { return look({0, .5, 1}); }

 private:
  static CameraDescription look(const std::vector<double>& times) {
    CameraDescription camera = perspective({0, .6, 3}, {0, .4, 0}, 50);
    camera.lens_radius = .03;
    camera.focus_distance = 3;
    const Mat44d first = camera.to_world;
    const auto pose = [&](double t) {
      return turned(.1 * t) * first * translation(.2 * t, .1 * t, -.2 * t);
    };
    camera.to_world = pose(times[0]);
    for (size_t i = 1; i < times.size(); ++i) camera.motion.push_back(pose(times[i]));
    return camera;
  }

  static void place(SceneBuilderForTests& b, MeshDescription mesh, const Pose& pose,
                    const std::vector<double>& times) {
    b.place(b.add_mesh(std::move(mesh)), pose(times[0]));
    for (size_t i = 1; i < times.size(); ++i) {
      b.description.instances.back().motion.push_back(pose(times[i]));
    }
  }

  static SceneBuilderForTests build(const std::vector<double>& times) {
    SceneBuilderForTests b;
    b.add_floor(3, -.3f, b.add_material(lambert(Rgb(.6f))));
    const auto ball = [&](float radius, const MaterialDescription& m) {
      return SceneBuilderForTests::sphere(radius, 8, b.add_material(m), false, true);
    };
    place(
        b, ball(.3f, glass(1.5f, .2f)),
        [](double t) { return turned(t) * translation(-.8 + .3 * t, .2, .3); }, times);
    MaterialDescription card = lambert(Rgb(.8f));
    card.alpha_mode = AlphaMode::kBlend;
    card.alpha = .6f;
    card.double_sided = true;
    place(
        b, ball(.3f, card),
        [](double t) { return scaling(.8 + .4 * t) * translation(.1, .2 + .3 * t, -.4); }, times);
    place(
        b, ball(.25f, metal(Rgb(.9f), 0)),
        [](double t) { return turned(-t) * translation(.8, .2, .2 + .4 * t); }, times);
    place(
        b, ball(.08f, emitter(Rgb(20.0f))),
        [](double t) { return translation(-.3 + .8 * t, 1.2, .3 - .5 * t); }, times);
    add_wave(b, times);
    PunctualLightDescription light;
    const auto lamp = [](double t) {
      return PunctualLightStep{Rgb(float(3 - 2 * t)), translation(1 - 2 * t, 1.5, 1)};
    };
    static_cast<PunctualLightStep&>(light) = lamp(times[0]);
    for (size_t i = 1; i < times.size(); ++i) light.motion.push_back(lamp(times[i]));
    b.description.lights.push_back(light);
    b.set_environment(Rgb(.3f));
    return b;
  }

  // A sheet whose vertices go up and down, in straight lines from the first time to the last.
  static void add_wave(SceneBuilderForTests& b, const std::vector<double>& times) {
    MaterialDescription cloth = lambert(Rgb(.5f));
    cloth.double_sided = true;
    MeshDescription sheet;
    sheet.material = b.add_material(cloth);
    constexpr uint32_t kCells = 8;
    const auto vertices = [](double t) {
      std::vector<Vec3f> p;
      for (uint32_t i = 0; i <= kCells; ++i) {
        for (uint32_t j = 0; j <= kCells; ++j) {
          const double x = double(i) / kCells, z = double(j) / kCells;
          p.emplace_back(float(2 * x - 1), float(.9 + .2 * (t - .5) * std::sin(7 * x + 5 * z)),
                         float(-1 + z));
        }
      }
      return p;
    };
    sheet.positions = vertices(times[0]);
    for (size_t i = 1; i < times.size(); ++i) sheet.motion.push_back({vertices(times[i]), {}, {}});
    for (uint32_t i = 0; i < kCells; ++i) {
      for (uint32_t j = 0; j < kCells; ++j) {
        const uint32_t a = i * (kCells + 1) + j, c = a + kCells + 1;
        sheet.triangles.push_back({a, a + 1, c});
        sheet.triangles.push_back({a + 1, c + 1, c});
      }
    }
    b.place(b.add_mesh(std::move(sheet)));
  }
};

}  // namespace emberline::test
