// A moving scene, and the same scene at a single time, for which separate code computes the state.
#pragma once

#include <cmath>
#include <functional>

#include "support/glass_scenes.h"
#include "support/scenes.h"

namespace emberline::test {

// Returns a counter-clockwise rotation about +Z.
inline Mat44d turned(double radians) {
  Mat44d m;
  m[0][0] = m[1][1] = std::cos(radians);
  m[0][1] = std::sin(radians);
  m[1][0] = -m[0][1];
  return m;
}

template <class Value>
std::shared_ptr<const TimeCurve<Value>> over_time(std::vector<float> times,
                                                  std::vector<Value> values) {
  return std::make_shared<const TimeCurve<Value>>(
      TimeCurve<Value>{std::move(times), std::move(values)});
}

inline std::shared_ptr<const VisibilityTimes> visible_from(bool visible_at_open,
                                                           std::vector<float> toggle_times) {
  return std::make_shared<const VisibilityTimes>(
      VisibilityTimes{visible_at_open, std::move(toggle_times)});
}

// A floor with objects that move along straight lines. Some of them turn by up to a quarter turn or
// change their size. The scene also has lamps that change, and an object that appears and
// disappears.
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
  CameraDescription view_at(double time) const { return camera_at({time}); }
  CameraDescription view() const { return camera_at({0, .5, 1}); }

 private:
  static CameraDescription camera_at(const std::vector<double>& times) {
    CameraDescription camera = perspective({0, .6, 3}, {0, .4, 0}, 50);
    camera.lens_radius = .03;
    camera.focus_distance = 3;
    const Mat44d first = camera.to_world;
    const auto pose = [&](double t) {
      return turned(.1 * t) * first * translation(.2 * t, .1 * t, -.2 * t);
    };
    camera.to_world = pose(times[0]);
    const auto zoom = over_time<double>({0, 1}, {.9, .7});
    camera.fov_y = zoom->at(float(times[0]));
    if (times.size() > 1) camera.zoom = zoom;
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
    const auto visibility = visible_from(false, {.125f, .75f});
    if (times.size() > 1 || visibility->at(float(times[0]))) {
      place(
          b, ball(.25f, metal(Rgb(.9f), 0)),
          [](double t) { return turned(-t) * translation(.8, .2, .2 + .4 * t); }, times);
      if (times.size() > 1) b.description.instances.back().visibility = visibility;
    }
    place(
        b, ball(.08f, blinking(times)),
        [](double t) { return translation(-.3 + .8 * t, 1.2, .3 - .5 * t); }, times);
    add_wave(b, times);
    add_point_light(b, times);
    add_spot(b, times);
    b.set_environment(Rgb(.3f));
    return b;
  }

  // Returns the material of a lamp that is white at first. Then it turns red and fades.
  static MaterialDescription blinking(const std::vector<double>& times) {
    MaterialDescription lamp = emitter(Rgb(20.0f));
    const auto share =
        over_time<Rgb>({0, .25f, .25f, 1}, {Rgb(1.0f), Rgb(1.0f), {1, .2f, .2f}, {.5f, .1f, .1f}});
    if (times.size() > 1) {
      lamp.emission_scale = share;
    } else {
      lamp.emission *= share->at(float(times[0]));
    }
    return lamp;
  }

  static void add_point_light(SceneBuilderForTests& b, const std::vector<double>& times) {
    PunctualLightDescription light;
    const auto at = [](double t) { return translation(1 - 2 * t, 1.5, 1); };
    light.to_world = at(times[0]);
    light.intensity = Rgb(3.0f);
    for (size_t i = 1; i < times.size(); ++i) light.motion.push_back(at(times[i]));
    const auto share = over_time<Rgb>({0, 1}, {Rgb(1.0f), Rgb(1 / 3.0f)});
    if (times.size() > 1) {
      light.share = share;
    } else {
      light.intensity *= share->at(float(times[0]));
    }
    b.description.lights.push_back(light);
  }

  // Adds a spot light. Its cone opens, and it turns off before the end.
  static void add_spot(SceneBuilderForTests& b, const std::vector<double>& times) {
    PunctualLightDescription light;
    light.type = PunctualType::kSpot;
    light.to_world = look_at_matrix({-1, 2, 1}, {0, 0, 0});
    light.intensity = Rgb(4.0f);
    light.inner_cone = .3f;
    light.outer_cone = .8f;
    const auto cones = over_time<Vec2f>({0, 1}, {{.1f, .2f}, {.3f, .8f}});
    const auto visibility = visible_from(true, {.875f});
    if (times.size() > 1) {
      light.cones = cones;
      light.visibility = visibility;
    } else {
      light.inner_cone = cones->at(float(times[0])).x;
      light.outer_cone = cones->at(float(times[0])).y;
      if (!visibility->at(float(times[0]))) return;
    }
    b.description.lights.push_back(light);
  }

  // Adds a sheet. Its vertices move up or down along straight lines, from the first time to the
  // last.
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
