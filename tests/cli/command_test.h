// Fixture for tests of the command: a temporary folder with a small scene, and expectations that
// hold for every run.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "cli/picture.h"
#include "cli/process.h"
#include "support/gltf_builder.h"

namespace emberline::test {

using Words = std::vector<std::string>;

inline Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// Adds a parallelogram with corners a, a + u, a + u + v, a + v; its front is towards u x v.
void add_quad(GltfBuilder& gltf, std::array<float, 3> a, std::array<float, 3> u,
              std::array<float, 3> v, int material);

// Three quads: a matte floor, and a lamp above it. The camera "main" sees all of them. Light
// reaches every pixel after one or two bounces.
GltfBuilder lamp_scene();

// lamp_scene() without the lamp.
GltfBuilder unlit_scene();

class CommandTest : public ::testing::Test {
 protected:
  // A path in the test's folder, which is also the working folder of its runs.
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string scene();  // writes lamp_scene() to scene.glb and returns its path

  RunResult run(const Words& arguments, RunOptions options = {}) const {
    if (options.folder.empty()) options.folder = folder_.path();
    return test::run(arguments, options);
  }
  // Returns `render SCENE -o out.exr --size 16x16 --spp 1`, followed by `more`.
  Words render_words(const Words& more = {});

  // Runs and expects success with an empty stdout.
  RunResult render(const Words& arguments, const RunOptions& options = {});
  // Expects `exit_code` and one line on stderr that starts with "emberline: error:" and contains
  // each of `parts`. Also expects the same files in the folder as before, and no signal, hang or
  // .part file.
  void expect_failure(const Words& arguments, int exit_code, const Words& parts,
                      const RunOptions& options = {});

  nlohmann::json read_json(const std::string& name) const;
  std::vector<std::string> files() const;  // names in the folder, sorted
  void write(const std::string& name, const std::string& text) const {
    write_text(path(name), text);
  }

  TempFolder folder_;
};

}  // namespace emberline::test
