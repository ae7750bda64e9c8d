// A fixture for sessions with small frames of the committed scenes, and references for these
// frames.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "io/image/input.h"
#include "renderer/app/commands.h"
#include "renderer/film/filter.h"
#include "support/edits.h"
#include "support/session_owner.h"
#include "unit/output_folder.h"

namespace emberline {

class SessionFixture : public OutputFolder {
 protected:
  static std::string scene(const std::string& name) {
    return std::string(EMBERLINE_SCENES) + "/" + name + ".glb";
  }

  static ViewSettings settings(const std::string& driver, std::optional<uint32_t> spp = {}) {
    ViewSettings result;
    result.render.driver = driver;
    result.render.width = 48;
    result.render.height = 32;
    result.render.spp = spp;
    result.render.max_depth = 4;
    result.render.threads = 2;
    result.render.bucket_size = 16;
    return result;
  }

  // Returns the output of `render` with these options as R G B A, with rows from the top.
  std::vector<float> rendered(RenderOptions options) const {
    options.outputs = {path("rendered.exr")};
    EXPECT_EQ(run_render(options), 0);
    return rgba_of(options.outputs.front());
  }

  static std::vector<float> rgba_of(const std::string& file) {
    const FloatImage image = read_float_image(file);
    std::vector<float> rgba;
    const size_t channels = size_t(image.channels());
    for (size_t i = 0; i < image.values.size(); i += channels) {
      for (const char* name : {"R", "G", "B", "A"}) {
        rgba.push_back(image.values[i + size_t(image.find_channel(name))]);
      }
    }
    return rgba;
  }

  static void expect_same_bits(const std::vector<float>& a, const std::vector<float>& b,
                               const std::string& what) {
    ASSERT_EQ(a.size(), b.size()) << what;
    for (size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(std::memcmp(&a[i], &b[i], sizeof(float)), 0)
          << what << ": value " << i << ": " << a[i] << " against " << b[i];
    }
  }

  static testing::AssertionResult finishes(test::SessionOwner& owner) {
    if (owner.wait(120, [&] { return owner.finished(); })) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "not finished; problem: " << owner.session.problem();
  }

  // An edit of the camera and one of a material of the Cornell box.
  static SceneEdits some_edits(float amount = 1.0f) {
    SceneEdits edits;
    edits.camera.look_from = Vec3d(278 + 10 * double(amount), 273, -700);
    edits.camera.look_at = Vec3d(278, 273, 200);
    edits.camera.fov_y_degrees = 39.0;
    test::material(edits, 0).base_color = Rgb(0.2f, 0.4f * amount, 0.6f);
    return edits;
  }
};

}  // namespace emberline
