// A fixture for tests of the command. It has a temporary folder and a small scene, and checks what
// must hold for every run.
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

// Adds a parallelogram with the corners a, a + u, a + u + v and a + v. Its front faces u x v.
void add_quad(GltfBuilder& gltf, std::array<float, 3> a, std::array<float, 3> u,
              std::array<float, 3> v, int material);

// A scene of two quads: a matte floor, and a lamp above the floor. The camera "main" sees both.
// Light reaches every pixel after one or two bounces.
GltfBuilder lamp_scene();

// lamp_scene() without the lamp.
GltfBuilder unlit_scene();

class CommandTest : public ::testing::Test {
 protected:
  // Returns a path in the test's folder, which is also the working folder of its runs.
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string scene();  // writes lamp_scene() to scene.glb and returns its path

  RunResult run(const Words& arguments, RunOptions options = {}) const {
    if (options.folder.empty()) options.folder = folder_.path();
    return test::run(arguments, options);
  }
  // Returns `render SCENE -o out.exr --size 16x16 --spp 1`, followed by `more`.
  Words render_words(const Words& more = {});

  // Runs the command. Expects success and an empty stdout.
  RunResult render(const Words& arguments, const RunOptions& options = {});
  // Runs the command. Expects `exit_code`, an empty stdout, and one line on stderr that starts with
  // "emberline: error:" and contains each of `parts`. The run must not be ended by a signal, must
  // not hang, and must leave the same file names in the folder as before.
  void expect_failure(const Words& arguments, int exit_code, const Words& parts,
                      const RunOptions& options = {});

  nlohmann::json read_json(const std::string& name) const;
  std::vector<std::string> files() const;  // the sorted names of all files in the folder
  void write(const std::string& name, const std::string& text) const {
    write_text(path(name), text);
  }

  TempFolder folder_;
};

}  // namespace emberline::test
