// Builds scenes with light groups, and compares their frames.
#pragma once

#include <vector>

#include "renderer/scene/editable_scene.h"
#include "renderer/scene/light_groups.h"
#include "support/edits.h"
#include "support/render.h"

namespace emberline::test {

// A scene whose lights are set by `baseline`, and the groups of these lights.
struct GroupedScene {
  explicit GroupedScene(SceneDescription description, const SceneEdits& baseline = {})
      : scene(std::move(description)), groups((scene.set(baseline), scene.original()), baseline) {}
  EditableScene scene;
  LightGroups groups;
};

// These functions turn off one light group, or all light groups except one.
inline void turn_off(SceneEdits& edits, const LightGroup& group) {
  light(edits, group.kind, group.target.index).on = false;
}
inline SceneEdits all_off_except(const LightGroups& groups, int group_on) {
  SceneEdits edits;
  for (int g = 0; g < groups.size(); ++g) {
    if (g != group_on) turn_off(edits, groups.list()[size_t(g)]);
  }
  return edits;
}

// Returns the mean difference between the pixels of two frames, divided by its standard error, for
// each quarter of the frame and each channel. Pixels are independent. If the frames have the same
// expectation, the differences are positive as often as negative, and only 1 in 15,000 of the
// returned values exceeds 4. This is because a sum of such terms, divided by the root of the sum of
// their squares, has no heavier tails than the normal distribution.
inline std::vector<double> deviations(const std::vector<Rgb>& a, const std::vector<Rgb>& b,
                                      int width) {
  const size_t height = a.size() / size_t(width);
  double sums[4][3] = {}, squares[4][3] = {};
  for (size_t i = 0; i < a.size(); ++i) {
    const size_t x = i % size_t(width), y = i / size_t(width);
    const size_t quarter = 2 * (2 * y / height) + 2 * x / size_t(width);
    for (int c = 0; c < 3; ++c) {
      const double difference = double(a[i][c]) - double(b[i][c]);
      sums[quarter][c] += difference;
      squares[quarter][c] += square(difference);
    }
  }
  std::vector<double> result;
  for (int q = 0; q < 4; ++q) {
    for (int c = 0; c < 3; ++c) {
      result.push_back(squares[q][c] > 0 ? sums[q][c] / std::sqrt(squares[q][c]) : 0.0);
    }
  }
  return result;
}

inline std::vector<Rgb> rgb_of(const RenderedImage& image) {
  std::vector<Rgb> pixels;
  for (size_t i = 0; i < image.values.size(); i += image.channels.size()) {
    pixels.emplace_back(image.values[i], image.values[i + 1], image.values[i + 2]);
  }
  return pixels;
}

inline std::vector<Rgb> rgb_of(const std::vector<float>& rgba) {
  std::vector<Rgb> pixels;
  for (size_t i = 0; i < rgba.size(); i += 4) {
    pixels.emplace_back(rgba[i], rgba[i + 1], rgba[i + 2]);
  }
  return pixels;
}

inline std::vector<Rgb> light_of(const RenderedImage& image, int group) {
  std::vector<Rgb> pixels;
  for (size_t i = 0; i < size_t(image.crop.area()); ++i) {
    pixels.push_back(image.light(i, group));
  }
  return pixels;
}

}  // namespace emberline::test
