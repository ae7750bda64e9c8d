// Compares tangents by the MikkTSpace convention with geometry whose frame is known.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/gltf/geometry/tangents.h"
#include "io/gltf/gltf_file.h"
#include "support/embedded_images.h"

namespace emberline {
namespace {

using test::GltfBuilder;
using test::TempFolder;

void expect_near(const Vec4f& tangent, const Vec4f& expected) {
  for (int c = 0; c < 4; ++c) EXPECT_NEAR(tangent[c], expected[c], 1e-6f) << tangent;
}

// A unit square in the XY plane with normal +Z, as two triangles.
MeshDescription square(const std::vector<Vec2f>& uv) {
  MeshDescription mesh;
  mesh.positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(1, 1, 0), Vec3f(0, 1, 0)};
  mesh.normals.assign(4, Vec3f(0, 0, 1));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.uv_sets = {uv};
  return mesh;
}

TextureRef texture() {
  TextureRef ref;
  ref.image = 0;
  return ref;
}

TEST(GltfTangents, AnUprightImageHasTangentRightAndBitangentUp) {
  // v grows downwards: the square's top edge (y = 1) has v = 0.
  MeshDescription mesh = square({Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0), Vec2f(0, 0)});
  generate_tangents(mesh, texture());
  ASSERT_EQ(mesh.tangents.size(), 4u);
  for (const Vec4f& t : mesh.tangents) {
    expect_near(t, Vec4f(1, 0, 0, 1));
    const Vec3f bitangent = cross(Vec3f(0, 0, 1), Vec3f(t.x, t.y, t.z)) * t.w;
    EXPECT_NEAR(bitangent.y, 1.0f, 1e-6f);
  }
}

TEST(GltfTangents, MirroredAndTurnedImages) {
  MeshDescription mirrored = square({Vec2f(1, 1), Vec2f(0, 1), Vec2f(0, 0), Vec2f(1, 0)});
  generate_tangents(mirrored, texture());
  // u grows to the left; up in the image is still +y = cross(n, t) * w.
  for (const Vec4f& t : mirrored.tangents) expect_near(t, Vec4f(-1, 0, 0, -1));

  // The image is rotated: u grows upwards, and its top points to -x.
  MeshDescription turned = square({Vec2f(0, 1), Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 1)});
  for (Vec2f& uv : turned.uv_sets[0]) uv.y = 1.0f - uv.y;
  generate_tangents(turned, texture());
  for (const Vec4f& t : turned.tangents) expect_near(t, Vec4f(0, 1, 0, 1));
}

TEST(GltfTangents, TheTextureTransformTurnsTheFrame) {
  MeshDescription mesh = square({Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0), Vec2f(0, 0)});
  TextureRef ref = texture();
  ref.uv_transform = {-1, 0, 1, 0, 1, 0};  // mirrors u
  generate_tangents(mesh, ref);
  for (const Vec4f& t : mesh.tangents) expect_near(t, Vec4f(-1, 0, 0, -1));
}

// Two squares share an edge. The right square is mirrored, as on the seam of a symmetric model.
TEST(GltfTangents, HandednessSplitsSharedVertices) {
  MeshDescription mesh;
  mesh.positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(2, 0, 0),
                    Vec3f(0, 1, 0), Vec3f(1, 1, 0), Vec3f(2, 1, 0)};
  mesh.normals.assign(6, Vec3f(0, 0, 1));
  mesh.colors.assign(6, Vec4f(0.5f));
  mesh.uv_sets = {{Vec2f(0, 1), Vec2f(1, 1), Vec2f(0, 1), Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 0)}};
  mesh.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  generate_tangents(mesh, texture());
  ASSERT_EQ(mesh.positions.size(), 8u);
  EXPECT_EQ(mesh.tangents.size(), 8u);
  EXPECT_EQ(mesh.normals.size(), 8u);
  EXPECT_EQ(mesh.colors.size(), 8u);
  EXPECT_EQ(mesh.uv_sets[0].size(), 8u);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const uint32_t v : mesh.triangles[i]) {
      expect_near(mesh.tangents[v], i < 2 ? Vec4f(1, 0, 0, 1) : Vec4f(-1, 0, 0, -1));
    }
  }
}

// Corners of different vertices share one tangent if they agree in position, normal and UV. It is
// weighted by their angles, here 90 degrees for the first triangle and 45 for the second.
TEST(GltfTangents, CornersShareByValueAndWeighByAngle) {
  MeshDescription mesh;
  const Vec3f o(0.0f);
  mesh.positions = {o, Vec3f(1, 0, 0), Vec3f(0, 1, 0), o, Vec3f(0, 1, 0), Vec3f(-1, 1, 0)};
  mesh.normals.assign(6, Vec3f(0, 0, 1));
  // In the first triangle u grows along +X, and in the second along +Y. At corner o both have the
  // same UV.
  mesh.uv_sets = {{Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, -1), Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, -1)}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  generate_tangents(mesh, texture());
  const Vec3f expected = normalize(Vec3f(1, 0, 0) * 90.0f + Vec3f(0, 1, 0) * 45.0f);
  ASSERT_EQ(mesh.tangents.size(), 6u);
  expect_near(mesh.tangents[0], Vec4f(expected.x, expected.y, expected.z, 1));
  expect_near(mesh.tangents[3], Vec4f(expected.x, expected.y, expected.z, 1));
  expect_near(mesh.tangents[1], Vec4f(1, 0, 0, 1));
}

TEST(GltfTangents, AlwaysUnitAndPerpendicularOnASphere) {
  MeshDescription mesh;
  const int rings = 16, segments = 24;
  mesh.uv_sets.resize(1);
  for (int r = 0; r <= rings; ++r) {
    for (int s = 0; s <= segments; ++s) {
      const double theta = M_PI * r / rings, phi = 2.0 * M_PI * s / segments;
      const Vec3f p(float(std::sin(theta) * std::cos(phi)), float(std::cos(theta)),
                    float(-std::sin(theta) * std::sin(phi)));
      mesh.positions.push_back(p);
      mesh.normals.push_back(normalize(p));
      mesh.uv_sets[0].push_back(Vec2f(float(s) / segments, float(r) / rings));
    }
  }
  for (uint32_t r = 0; r < rings; ++r) {
    for (uint32_t s = 0; s < segments; ++s) {
      const uint32_t a = r * (segments + 1) + s, b = a + segments + 1;
      if (r > 0) mesh.triangles.push_back({a, b, a + 1});
      if (r + 1 < rings) mesh.triangles.push_back({a + 1, b, b + 1});
    }
  }
  generate_tangents(mesh, texture());
  for (const auto& triangle : mesh.triangles) {
    for (const uint32_t v : triangle) {
      const Vec4f& t = mesh.tangents[v];
      const Vec3f tangent(t.x, t.y, t.z);
      EXPECT_NEAR(dot(tangent, tangent), 1.0f, 1e-5f);
      EXPECT_NEAR(dot(tangent, mesh.normals[v]), 0.0f, 1e-5f);
      EXPECT_EQ(t.w, 1.0f);
      // u grows eastwards, which is around +Y and counter-clockwise as seen from above.
      const Vec3f east = cross(Vec3f(0, 1, 0), mesh.positions[v]);
      if (dot(east, east) > 0.04f) {
        EXPECT_GT(dot(tangent, normalize(east)), 0.97f);
      }
    }
  }
}

TEST(GltfTangents, ZeroUvAreaStillGivesAFrame) {
  MeshDescription mesh = square(std::vector<Vec2f>(4, Vec2f(0.25f)));
  generate_tangents(mesh, texture());
  for (const Vec4f& t : mesh.tangents) {
    EXPECT_NEAR(Vec3f(t.x, t.y, t.z).length(), 1.0f, 1e-6f);
    EXPECT_NEAR(t.z, 0.0f, 1e-6f);
  }
  // A face without UV area takes the frame of its neighbours and does not break it.
  MeshDescription mixed = square({Vec2f(0, 1), Vec2f(1, 1), Vec2f(1, 0), Vec2f(0, 1)});
  generate_tangents(mixed, texture());
  EXPECT_EQ(mixed.positions.size(), 4u);
  expect_near(mixed.tangents[0], Vec4f(1, 0, 0, 1));
}

GltfBuilder normal_mapped_triangle() {
  GltfBuilder gltf;
  const int mesh = gltf.add_triangle();
  const int image = test::add_texture(gltf, test::small_png());
  gltf.push("materials", {{"normalTexture", {{"index", image}, {"scale", 0.5}}}});
  gltf.primitive(mesh)["material"] = 0;
  auto& attributes = gltf.primitive(mesh)["attributes"];
  attributes["NORMAL"] = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  attributes["TEXCOORD_0"] = gltf.add_accessor<float>("VEC2", {0, 1, 1, 1, 0, 0});
  return gltf;
}

TEST(GltfTangents, MadeOnlyWhereANormalMapNeedsThem) {
  const TempFolder folder;
  GltfBuilder gltf = normal_mapped_triangle();
  SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
  EXPECT_EQ(scene.materials[0].normal_scale, 0.5f);
  ASSERT_EQ(scene.meshes[0].tangents.size(), 3u);
  expect_near(scene.meshes[0].tangents[0], Vec4f(1, 0, 0, 1));
  gltf.root["materials"][0].erase("normalTexture");
  scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
  EXPECT_TRUE(scene.meshes[0].tangents.empty());
}

TEST(GltfTangents, SuppliedOnesAreKeptUnlessNormalsAreMissing) {
  const TempFolder folder;
  GltfBuilder gltf = normal_mapped_triangle();
  auto& attributes = gltf.primitive()["attributes"];
  attributes["TANGENT"] = gltf.add_accessor<float>("VEC4", {0, 2, 0, -1, 0, 1, 0, -1, 0, 0, 0, 1});
  SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
  ASSERT_EQ(scene.meshes[0].tangents.size(), 3u);
  expect_near(scene.meshes[0].tangents[0], Vec4f(0, 1, 0, -1));
  // A zero tangent is replaced by some tangent in the plane.
  EXPECT_NEAR(scene.meshes[0].tangents[2].z, 0.0f, 1e-6f);

  attributes.erase("NORMAL");
  scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
  EXPECT_TRUE(scene.meshes[0].normals.empty());
  ASSERT_EQ(scene.meshes[0].tangents.size(), 3u);
  expect_near(scene.meshes[0].tangents[0], Vec4f(1, 0, 0, 1));
}

// The triangle above without its normal map. In its second UV set, which is rotated, u grows
// upwards.
GltfBuilder layered_triangle(const nlohmann::json& extensions) {
  GltfBuilder gltf = normal_mapped_triangle();
  gltf.primitive()["attributes"]["TEXCOORD_1"] =
      gltf.add_accessor<float>("VEC2", {0, 0, 0, 1, 1, 0});
  gltf.root["materials"][0] = {{"extensions", extensions}};
  return gltf;
}

std::vector<Vec4f> tangents_of(const GltfBuilder& gltf, const GltfOptions& options = {}) {
  const TempFolder folder;
  return load_gltf(gltf.write_glb(folder / "a.glb"), options).meshes.at(0).tangents;
}

TEST(GltfTangents, AClearCoatsNormalMapNeedsThemInItsLayout) {
  const nlohmann::json slot = {{"index", 0}, {"texCoord", 1}};
  GltfBuilder gltf =
      layered_triangle({{"KHR_materials_clearcoat", {{"clearcoatNormalTexture", slot}}}});
  std::vector<Vec4f> tangents = tangents_of(gltf);
  ASSERT_EQ(tangents.size(), 3u);
  EXPECT_NEAR(tangents[0].y, 1.0f, 1e-6f);
  // The normal map of the base takes precedence.
  gltf.root["materials"][0]["normalTexture"] = {{"index", 0}};
  tangents = tangents_of(gltf);
  expect_near(tangents.at(0), Vec4f(1, 0, 0, 1));
  // A coat without a normal map needs no tangents.
  EXPECT_TRUE(tangents_of(layered_triangle({{"KHR_materials_clearcoat", {{"clearcoatFactor", 1}}}}))
                  .empty());
}

TEST(GltfTangents, AnisotropyNeedsThem) {
  const auto with = [](const nlohmann::json& anisotropy) {
    return layered_triangle({{"KHR_materials_anisotropy", anisotropy}});
  };
  // Without a texture, anisotropy uses the tangents of the first UV set, or those in the file.
  GltfBuilder plain = with({{"anisotropyStrength", 0.5}});
  expect_near(tangents_of(plain).at(0), Vec4f(1, 0, 0, 1));
  plain.primitive()["attributes"]["TANGENT"] =
      plain.add_accessor<float>("VEC4", {0, 2, 0, -1, 0, 1, 0, -1, 0, 1, 0, 1});
  expect_near(tangents_of(plain).at(0), Vec4f(0, 1, 0, -1));
  const nlohmann::json slot = {{"index", 0}, {"texCoord", 1}};
  const std::vector<Vec4f> tangents =
      tangents_of(with({{"anisotropyStrength", 0.5}, {"anisotropyTexture", slot}}));
  ASSERT_EQ(tangents.size(), 3u);
  EXPECT_NEAR(tangents[0].y, 1.0f, 1e-6f);
  // With zero strength, anisotropy needs no tangents, unless the caller requests them for edits.
  EXPECT_TRUE(tangents_of(with({{"anisotropyRotation", 0.5}})).empty());
  expect_near(tangents_of(with({{"anisotropyRotation", 0.5}}), {.tangents = true}).at(0),
              Vec4f(1, 0, 0, 1));
}

TEST(GltfTangents, AnisotropyWithoutCoordinatesHasSomeDirection) {
  GltfBuilder gltf = layered_triangle({{"KHR_materials_anisotropy", {{"anisotropyStrength", 1}}}});
  gltf.primitive()["attributes"].erase("TEXCOORD_0");
  const TempFolder folder;
  const SceneDescription scene = load_gltf(gltf.write_glb(folder / "a.glb"), {});
  ASSERT_EQ(scene.meshes[0].tangents.size(), 3u);
  for (const Vec4f& t : scene.meshes[0].tangents) {
    EXPECT_NEAR(Vec3f(t.x, t.y, t.z).length(), 1.0f, 1e-6f);
    EXPECT_NEAR(t.z, 0.0f, 1e-6f);
  }
  ASSERT_EQ(scene.coverage.approximated.size(), 1u);
  EXPECT_NE(scene.coverage.approximated[0].find("anisotropy on mesh 0/0"), std::string::npos);
}

}  // namespace
}  // namespace emberline
