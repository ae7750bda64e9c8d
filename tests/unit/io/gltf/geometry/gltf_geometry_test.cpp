// Tests accessors and primitives: component types, normalisation, strides, sparse data, modes and
// repairs.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "renderer/core/log.h"
#include "support/loaded_gltf.h"

namespace emberline {
namespace {

using test::GltfBuilder;
using test::load;
using test::message_of;
using Triangle = std::array<uint32_t, 3>;

// Expects that integer positions which are not normalised are used as coordinates.
template <class T>
void expect_integer_positions() {
  GltfBuilder gltf;
  const int p = gltf.add_accessor<T>("VEC3", {0, 0, 0, 100, 0, 0, 0, 120, 3});
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}}));
  gltf.root["extensionsUsed"] = gltf.root["extensionsRequired"] = {"KHR_mesh_quantization"};
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.meshes.at(0).positions[1], Vec3f(100, 0, 0));
  EXPECT_EQ(scene.meshes.at(0).positions[2], Vec3f(0, 120, 3));
  EXPECT_EQ(scene.coverage.used, std::vector<std::string>{"KHR_mesh_quantization"});
}

TEST(GltfGeometry, IntegerPositionsKeepTheirValues) {
  expect_integer_positions<int8_t>();
  expect_integer_positions<uint8_t>();
  expect_integer_positions<int16_t>();
  expect_integer_positions<uint16_t>();
  expect_integer_positions<uint32_t>();
}

// Section 3.11 of the specification: f = c / 255, c / 65535, max(c / 127, -1) or max(c / 32767,
// -1).
TEST(GltfGeometry, NormalisedIntegersSpanTheUnitRange) {
  const auto uv_of = [](auto values) {
    GltfBuilder gltf;
    const int mesh = gltf.add_triangle();
    using T = typename decltype(values)::value_type;
    gltf.primitive(mesh)["attributes"]["TEXCOORD_0"] = gltf.add_accessor<T>("VEC2", values, true);
    return load(gltf).meshes.at(0).uv_sets.at(0);
  };
  EXPECT_EQ(uv_of(std::vector<uint8_t>{0, 51, 255, 0, 0, 0})[0], Vec2f(0.0f, 0.2f));
  EXPECT_EQ(uv_of(std::vector<uint8_t>{0, 51, 255, 0, 0, 0})[1], Vec2f(1.0f, 0.0f));
  EXPECT_EQ(uv_of(std::vector<uint16_t>{13107, 65535, 0, 0, 0, 0})[0], Vec2f(0.2f, 1.0f));
  EXPECT_EQ(uv_of(std::vector<int8_t>{127, -127, -128, 0, 0, 0})[0], Vec2f(1.0f, -1.0f));
  EXPECT_EQ(uv_of(std::vector<int8_t>{127, -127, -128, 0, 0, 0})[1], Vec2f(-1.0f, 0.0f));
  EXPECT_EQ(uv_of(std::vector<int16_t>{32767, -32767, -32768, 0, 0, 0})[0], Vec2f(1.0f, -1.0f));
  EXPECT_EQ(uv_of(std::vector<int16_t>{32767, -32767, -32768, 0, 0, 0})[1], Vec2f(-1.0f, 0.0f));
}

TEST(GltfGeometry, IndicesOfEveryWidthAndWithoutIndices) {
  const auto triangles_with = [](auto indices) {
    using T = typename decltype(indices)::value_type;
    GltfBuilder gltf;
    const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const int i = gltf.add_accessor<T>("SCALAR", indices);
    gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}}));
    return load(gltf).meshes.at(0).triangles;
  };
  const std::vector<Triangle> expected = {{0, 1, 2}, {2, 1, 3}};
  EXPECT_EQ(triangles_with(std::vector<uint8_t>{0, 1, 2, 2, 1, 3}), expected);
  EXPECT_EQ(triangles_with(std::vector<uint16_t>{0, 1, 2, 2, 1, 3}), expected);
  EXPECT_EQ(triangles_with(std::vector<uint32_t>{0, 1, 2, 2, 1, 3}), expected);
  // Two remaining indices make no triangle.
  EXPECT_EQ(triangles_with(std::vector<uint8_t>{0, 1, 2, 2, 1, 3, 0, 1}), expected);

  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}}));
  EXPECT_EQ(load(gltf).meshes.at(0).triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(GltfGeometry, InterleavedAttributesWithOffsets) {
  GltfBuilder gltf;
  struct Vertex {
    float position[3];
    int8_t normal[4];
    uint16_t uv[2];
    uint8_t color[4];
  };
  const std::vector<Vertex> vertices = {{{0, 0, 0}, {0, 0, 127, 0}, {0, 0}, {255, 0, 0, 255}},
                                        {{1, 0, 0}, {0, 0, 127, 0}, {65535, 0}, {0, 255, 0, 255}},
                                        {{0, 1, 0}, {0, 0, 127, 0}, {0, 65535}, {0, 0, 255, 51}}};
  const int view = gltf.add_view(vertices, sizeof(Vertex));
  const auto accessor = [&](size_t offset, int type, const std::string& shape, bool normalized) {
    return gltf.push("accessors", {{"bufferView", view},
                                   {"byteOffset", offset},
                                   {"componentType", type},
                                   {"count", 3},
                                   {"type", shape},
                                   {"normalized", normalized}});
  };
  gltf.add_mesh_node(
      gltf.add_mesh({{"attributes",
                      {{"POSITION", accessor(offsetof(Vertex, position), 5126, "VEC3", false)},
                       {"NORMAL", accessor(offsetof(Vertex, normal), 5120, "VEC3", true)},
                       {"TEXCOORD_0", accessor(offsetof(Vertex, uv), 5123, "VEC2", true)},
                       {"COLOR_0", accessor(offsetof(Vertex, color), 5121, "VEC4", true)}}}}));
  const SceneDescription scene = load(gltf);
  const MeshDescription& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions[2], Vec3f(0, 1, 0));
  EXPECT_EQ(mesh.normals[1], Vec3f(0, 0, 1));
  EXPECT_EQ(mesh.uv_sets.at(0)[1], Vec2f(1, 0));
  EXPECT_EQ(mesh.uv_sets.at(0)[2], Vec2f(0, 1));
  EXPECT_EQ(mesh.colors[2], Vec4f(0, 0, 1, 0.2f));
}

TEST(GltfGeometry, VertexColoursOfThreeAndFourComponents) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  auto& attributes = gltf.primitive(mesh)["attributes"];
  attributes["COLOR_0"] = gltf.add_accessor<float>("VEC3", {0.5f, 0, 0, 0, 0.25f, 0, 0, 0, 1});
  EXPECT_EQ(load(gltf).meshes.at(0).colors[1], Vec4f(0, 0.25f, 0, 1));
  attributes["COLOR_0"] =
      gltf.add_accessor<uint16_t>("VEC4", {65535, 0, 0, 13107, 0, 0, 0, 0, 0, 0, 0, 0}, true);
  EXPECT_EQ(load(gltf).meshes.at(0).colors[0], Vec4f(1, 0, 0, 0.2f));
}

// Each vertex is counted once, and only if a triangle uses it.
TEST(GltfGeometry, NonFiniteAttributesAreCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<std::string> warnings;
  const auto repaired = [&](const GltfBuilder& gltf) {
    warnings.clear();
    set_log_sink([&](LogKind, std::string_view message) { warnings.emplace_back(message); });
    const SceneDescription scene = load(gltf);
    set_log_sink(nullptr);
    return scene.repairs.non_finite_attributes;
  };
  {
    GltfBuilder gltf;
    const int mesh = gltf.add_triangle();
    EXPECT_EQ(repaired(gltf), 0u);
    EXPECT_TRUE(warnings.empty());
    gltf.primitive(mesh)["attributes"]["COLOR_0"] =
        gltf.add_accessor<float>("VEC4", {nan, 1, inf, 1, 1, 1, 1, -inf, 2, 2, 2, 1});
    EXPECT_EQ(repaired(gltf), 2u);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("2 vertices"), std::string::npos) << warnings[0];
    const std::vector<Vec4f> colors = {{0, 1, 1, 1}, {1, 1, 1, 0}, {1, 1, 1, 1}};
    EXPECT_EQ(load(gltf).meshes.at(0).colors, colors);
  }
  {
    GltfBuilder gltf;
    const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 9, 9, 9});
    const int n = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, nan, 1, 0, 0, 1, nan, 0, 0});
    const int uv = gltf.add_accessor<float>("VEC2", {0, 0, inf, 0, 0, -inf, nan, nan});
    const int i = gltf.add_accessor<uint8_t>("SCALAR", {0, 1, 2});
    gltf.add_mesh_node(gltf.add_mesh(
        {{"attributes", {{"POSITION", p}, {"NORMAL", n}, {"TEXCOORD_0", uv}}}, {"indices", i}}));
    EXPECT_EQ(repaired(gltf), 2u);
  }
}

// Sections 3.7.2.1 and 3.7.2.2 of the specification clamp colours of any type, morphed or not.
TEST(GltfGeometry, VertexColoursAreClamped) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  auto& attributes = gltf.primitive(mesh)["attributes"];
  attributes["COLOR_0"] =
      gltf.add_accessor<float>("VEC4", {4, 0.5f, -1, 3, 3.4e38f, 1, 0, 1, 0, 0, 0, 2});
  const std::vector<Vec4f> clamped = {{1, 0.5f, 0, 1}, {1, 1, 0, 1}, {0, 0, 0, 1}};
  EXPECT_EQ(load(gltf).meshes.at(0).colors, clamped);
  attributes["COLOR_0"] =
      gltf.add_accessor<uint8_t>("VEC4", {255, 1, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0});
  EXPECT_EQ(load(gltf).meshes.at(0).colors[0], Vec4f(1, 1, 0, 0));
  // A morph target is added before the colour is clamped.
  attributes["COLOR_0"] = gltf.add_accessor<float>("VEC3", {2, 1, 0, 2, 1, 0, 2, 1, 0});
  gltf.primitive(mesh)["targets"] = {
      {{"COLOR_0", gltf.add_accessor<float>("VEC3", {-1.5f, 1, 0.5f, 0, 0, 0, 0, 0, 0})}}};
  for (const double weight : {0.0, 1.0}) {
    gltf.root["meshes"][size_t(mesh)]["weights"] = {weight};
    EXPECT_EQ(load(gltf).meshes.at(0).colors[0],
              weight > 0 ? Vec4f(0.5f, 1, 0.5f, 1) : Vec4f(1, 1, 0, 1));
    EXPECT_EQ(load(gltf).meshes.at(0).colors[1], Vec4f(1, 1, 0, 1));
  }
}

TEST(GltfGeometry, SparseAccessorsReplaceElements) {
  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int indices = gltf.add_view(std::vector<uint16_t>{0, 2});
  const int values = gltf.add_view(std::vector<float>{-1, 0, 0, 0, 7, 0});
  gltf.root["accessors"][size_t(p)]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
      {"values", {{"bufferView", values}}}};
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}}));
  EXPECT_EQ(load(gltf).meshes.at(0).positions,
            (std::vector<Vec3f>{Vec3f(-1, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 7, 0)}));
  gltf.bin[gltf.root["bufferViews"][size_t(indices)]["byteOffset"].get<size_t>()] = 3;
  EXPECT_NE(message_of(gltf).find("sparse index"), std::string::npos) << message_of(gltf);
}

TEST(GltfGeometry, SparseAccessorsMayStartFromZeros) {
  GltfBuilder gltf;
  const int indices = gltf.add_view(std::vector<uint8_t>{1, 2});
  const int values = gltf.add_view(std::vector<float>{1, 0, 0, 0, 1, 0});
  const int p =
      gltf.push("accessors", {{"componentType", 5126},
                              {"count", 3},
                              {"type", "VEC3"},
                              {"sparse",
                               {{"count", 2},
                                {"indices", {{"bufferView", indices}, {"componentType", 5121}}},
                                {"values", {{"bufferView", values}}}}}});
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}}));
  EXPECT_EQ(load(gltf).meshes.at(0).positions,
            (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)}));
}

// Section 3.7.2.1 defines the triangles of strips as p_i = {v_i, v_(i + (1 + i % 2)), v_(i + (2 - i
// % 2))}, and those of fans as p_i = {v_(i+1), v_(i+2), v_0}.
TEST(GltfGeometry, StripsAndFansUnroll) {
  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}, {"mode", 5}}));
  EXPECT_EQ(load(gltf).meshes.at(0).triangles,
            (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));

  GltfBuilder fan;
  const int q = fan.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
  fan.add_mesh_node(fan.add_mesh({{"attributes", {{"POSITION", q}}}, {"mode", 6}}));
  EXPECT_EQ(load(fan).meshes.at(0).triangles, (std::vector<Triangle>{{1, 2, 0}, {2, 3, 0}}));
}

TEST(GltfGeometry, PointsAndLinesAreReportedNotDrawn) {
  GltfBuilder gltf;
  gltf.add_triangle();
  for (int mode = 0; mode < 4; ++mode) {
    gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", 0}}}, {"mode", mode}}));
  }
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.coverage.ignored,
            (std::vector<std::string>{"primitive mode POINTS (has no surface)",
                                      "primitive mode LINES (has no surface)",
                                      "primitive mode LINE_LOOP (has no surface)",
                                      "primitive mode LINE_STRIP (has no surface)"}));
}

TEST(GltfGeometry, NormalsAreUnitOrZeroAndMissingOnesStayMissing) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  EXPECT_TRUE(load(gltf).meshes.at(0).normals.empty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  gltf.primitive(mesh)["attributes"]["NORMAL"] =
      gltf.add_accessor<float>("VEC3", {0, 0, 5, 0, 0, 0, nan, 0, 1});
  EXPECT_EQ(load(gltf).meshes.at(0).normals,
            (std::vector<Vec3f>{Vec3f(0, 0, 1), Vec3f(0.0f), Vec3f(0.0f)}));
}

TEST(GltfGeometry, BadTrianglesAreDroppedAndCounted) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {0,   0, 0, 1, 0,   0, 0, 1, 0, 2, 0, 0,  //
                                                  nan, 0, 0, 0, inf, 0, 1, 1, 0});
  const int i = gltf.add_accessor<uint8_t>("SCALAR", {0, 1, 2,    // good
                                                      0, 1, 3,    // collinear
                                                      0, 1, 1,    // repeated vertex
                                                      0, 1, 4,    // NaN
                                                      5, 1, 2,    // infinite
                                                      1, 6, 2});  // good
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}}));
  const SceneDescription scene = load(gltf);
  EXPECT_EQ(scene.repairs.degenerate_triangles, 2u);
  EXPECT_EQ(scene.repairs.non_finite_triangles, 2u);
  const MeshDescription& mesh = scene.meshes.at(0);
  // Non-finite vertices are removed, even if no triangle uses them.
  EXPECT_EQ(mesh.positions,
            (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(1, 1, 0)}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}}));
}

TEST(GltfGeometry, TinyAndHugeTrianglesAreNotDegenerate) {
  for (const float scale : {1e-15f, 1e-6f, 1.0f, 1e6f, 1e15f}) {
    GltfBuilder gltf;
    // The triangle is a sliver, a thousand times as long as wide.
    const int p =
        gltf.add_accessor<float>("VEC3", {0, 0, 0, scale, scale, 0, scale, scale * 1.001f, 0});
    gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", p}}}}));
    EXPECT_EQ(load(gltf).repairs.degenerate_triangles, 0u) << scale;
  }
}

TEST(GltfGeometry, VerticesThatNoTriangleUsesAreLeftOut) {
  GltfBuilder gltf;
  const int p = gltf.add_accessor<float>("VEC3", {9, 9, 9, 0, 0, 0, 1, 0, 0, 8, 8, 8, 0, 1, 0});
  const int uv = gltf.add_accessor<float>("VEC2", {9, 9, 1, 0, 2, 0, 8, 8, 3, 0});
  const int i = gltf.add_accessor<uint16_t>("SCALAR", {1, 2, 4});
  gltf.add_mesh_node(
      gltf.add_mesh({{"attributes", {{"POSITION", p}, {"TEXCOORD_0", uv}}}, {"indices", i}}));
  const SceneDescription scene = load(gltf);
  const MeshDescription& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)}));
  EXPECT_EQ(mesh.uv_sets.at(0), (std::vector<Vec2f>{Vec2f(1, 0), Vec2f(2, 0), Vec2f(3, 0)}));
}

TEST(GltfGeometry, AttributesMustAgreeInCountAndShape) {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  auto& attributes = gltf.primitive(mesh)["attributes"];
  attributes["NORMAL"] = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1});
  EXPECT_NE(
      message_of(gltf).find("#/meshes/0/primitives/0/attributes/NORMAL: found 2 elements for 3"),
      std::string::npos)
      << message_of(gltf);
  attributes["NORMAL"] = gltf.add_accessor<float>("VEC2", {0, 0, 1, 0, 0, 1});
  EXPECT_NE(message_of(gltf).find("attributes/NORMAL: accessor"), std::string::npos)
      << message_of(gltf);
}

}  // namespace
}  // namespace emberline
