#include "cli/command_test.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

namespace emberline::test {

void add_quad(GltfBuilder& gltf, std::array<float, 3> a, std::array<float, 3> u,
              std::array<float, 3> v, int material) {
  std::vector<float> positions;
  for (const auto& [s, t] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    for (size_t c = 0; c < 3; ++c) {
      positions.push_back(a[c] + float(s) * u[c] + float(t) * v[c]);
    }
  }
  const int uv = gltf.add_accessor<float>("VEC2", {0, 1, 1, 1, 1, 0, 0, 0});
  nlohmann::json primitive = {
      {"attributes",
       {{"POSITION", gltf.add_accessor<float>("VEC3", positions)}, {"TEXCOORD_0", uv}}},
      {"indices", gltf.add_accessor<uint16_t>("SCALAR", {0, 1, 2, 0, 2, 3})}};
  if (material >= 0) primitive["material"] = material;
  gltf.add_mesh_node(gltf.add_mesh(primitive));
}

GltfBuilder unlit_scene() {
  GltfBuilder gltf;
  const int matte = gltf.push(
      "materials",
      {{"name", "matte"},
       {"pbrMetallicRoughness", {{"baseColorFactor", {0.7, 0.5, 0.3, 1}}, {"metallicFactor", 0}}}});
  add_quad(gltf, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, matte);
  gltf.push("cameras", {{"name", "main"},
                        {"type", "perspective"},
                        {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}});
  // The camera looks along -Z and slightly downwards.
  const int node = gltf.push("nodes", {{"camera", 0},
                                       {"translation", {0, 1, 4}},
                                       {"rotation", {-0.0998334166, 0, 0, 0.9950041653}}});
  gltf.add_to_scene(node);
  return gltf;
}

GltfBuilder lamp_scene() {
  GltfBuilder gltf = unlit_scene();
  const int lamp = gltf.push("materials", {{"name", "lamp"}, {"emissiveFactor", {1, 0.9, 0.8}}});
  add_quad(gltf, {-0.5f, 1.2f, -0.5f}, {1, 0, 0}, {0, 0, 1}, lamp);
  return gltf;
}

std::string CommandTest::scene() {
  const std::string file = path("scene.glb");
  if (!std::filesystem::exists(file)) lamp_scene().write_glb(file);
  return file;
}

Words CommandTest::render_words(const Words& more) {
  return Words{"render", scene(), "-o", path("out.exr"), "--size", "16x16", "--spp", "1"} + more;
}

RunResult CommandTest::render(const Words& arguments, const RunOptions& options) {
  const RunResult result = run(arguments, options);
  EXPECT_EQ(result.exit_code, 0) << result.describe();
  EXPECT_EQ(result.out, "") << result.describe();
  return result;
}

void CommandTest::expect_failure(const Words& arguments, int exit_code, const Words& parts,
                                 const RunOptions& options) {
  std::string command = "emberline";
  for (const std::string& word : arguments) command += " '" + word + "'";
  SCOPED_TRACE(command);
  const std::vector<std::string> before = files();
  const RunResult result = run(arguments, options);
  EXPECT_EQ(result.exit_code, exit_code) << result.describe();
  EXPECT_FALSE(result.hung);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(files(), before) << "files came or went";
  ASSERT_EQ(result.error_lines().size(), 1u) << result.describe();
  EXPECT_TRUE(result.err.starts_with("emberline: error: ")) << result.err;
  for (const std::string& part : parts) {
    EXPECT_NE(result.err.find(part), std::string::npos) << "\"" << part << "\": " << result.err;
  }
}

nlohmann::json CommandTest::read_json(const std::string& name) const {
  std::ifstream file(path(name));
  nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  EXPECT_FALSE(json.is_discarded()) << name;
  return json;
}

std::vector<std::string> CommandTest::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.path())) {
    names.push_back(entry.path().lexically_relative(folder_.path()).string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace emberline::test
