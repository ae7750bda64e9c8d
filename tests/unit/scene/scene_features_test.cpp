// Law 3: a scene stores and lists only what its placed meshes need.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/scenes.h"

namespace emberline {
namespace {

using test::lambert;
using test::SceneBuilderForTests;

std::shared_ptr<const Image> pixel(int channels, std::byte value) {
  auto image = std::make_shared<Image>();
  image->width = image->height = 1;
  image->channels = channels;
  image->texels.assign(size_t(channels), value);
  return image;
}

bool lists(const Scene& scene, const std::string& word) {
  return std::ranges::any_of(scene.features(), [&](const std::string& feature) {
    return feature.find(word) != std::string::npos;
  });
}

MaterialDescription everything() {
  MaterialDescription m;
  m.base_color_texture.image = 0;
  m.normal_texture.image = 0;
  m.emission = Rgb(1.0f);
  m.alpha_mode = AlphaMode::kMask;
  m.metallic = 0.0f;  // metals do not transmit light
  m.transmission = 1.0f;
  return m;
}

TEST(SceneFeatures, ListOnlyPlacedObjects) {
  SceneBuilderForTests b;
  b.description.images = {pixel(4, std::byte{0x10})};
  b.set_environment(Rgb(1.0f));
  b.add_floor(1, 0, b.add_material(lambert(Rgb(0.5f))));
  const int unworn = b.add_material(everything());
  // Adds a mesh that no node places, and a placed mesh without triangles.
  MeshDescription unplaced = SceneBuilderForTests::sphere(1, 4, unworn);
  MeshDescription empty;
  empty.material = unworn;
  b.add_mesh(unplaced);
  b.place(b.add_mesh(empty));
  const auto scene = b.build();
  for (const char* word : {"texture", "normal map", "emission", "alpha", "transmission"}) {
    EXPECT_FALSE(lists(*scene, word)) << word;
  }
  EXPECT_TRUE(scene->lights().triangles().empty());

  b.place(b.add_mesh(unplaced));
  const auto worn = b.build();
  for (const char* word :
       {"textures (1 image)", "normal map", "emission", "alpha coverage (mask)", "transmission"}) {
    EXPECT_TRUE(lists(*worn, word)) << word;
  }
  EXPECT_GE(worn->memory().texture_bytes, scene->memory().texture_bytes + 4);
}

// If the texture is opaque despite the alpha mode, no ray needs to test it.
TEST(SceneFeatures, CoverageOnlyWhereSomethingIsClear) {
  for (const bool clear : {false, true}) {
    SceneBuilderForTests b;
    b.description.images = {pixel(4, std::byte(clear ? 0x10 : 0xff))};
    MaterialDescription m;
    m.base_color_texture.image = 0;
    m.alpha_mode = AlphaMode::kBlend;
    b.add_floor(1, 0, b.add_material(m));
    b.set_environment(Rgb(1.0f));
    const auto scene = b.build();
    EXPECT_EQ(lists(*scene, "alpha coverage (blend)"), clear);
    EXPECT_EQ(scene->has_coverage(), clear);
  }
}

// `emberline info` lists the same features as a render, except those that need the BVH: its size,
// and emitters flush with another surface.
TEST(SceneFeatures, AreTheSameWithoutTheBvh) {
  SceneBuilderForTests b;
  b.description.images = {pixel(4, std::byte{0x10})};
  const int mesh = b.add_mesh(SceneBuilderForTests::sphere(1, 4, b.add_material(everything())));
  for (int i = 0; i < 3; ++i) b.place(mesh, test::translation(3 * i, 0, 0));
  SceneBuildOptions listing;
  listing.bvh = false;
  const auto listed = b.build(listing), built = b.build();
  EXPECT_EQ(listed->memory().bvh_bytes, 0u);
  EXPECT_GT(built->memory().bvh_bytes, 0u);
  ASSERT_EQ(listed->features().size(), built->features().size());
  for (size_t i = 0; i < built->features().size(); ++i) {
    EXPECT_TRUE(built->features()[i].starts_with(listed->features()[i])) << listed->features()[i];
  }
}

// Texture coordinates that no material uses are dropped, unless they are to be displayed.
TEST(SceneFeatures, UnusedTextureCoordinatesAreDropped) {
  SceneBuilderForTests b;
  b.set_environment(Rgb(1.0f));
  MeshDescription mesh = SceneBuilderForTests::sphere(1, 16, b.add_material(lambert(Rgb(0.5f))));
  const size_t bytes = mesh.positions.size() * sizeof(Vec2f);
  mesh.uv_sets = {std::vector<Vec2f>(mesh.positions.size(), Vec2f(0.25f, 0.75f))};
  b.place(b.add_mesh(mesh));
  SceneBuildOptions showing;
  showing.unread_uv = true;
  const auto kept = b.build(showing), plain = b.build();
  EXPECT_GE(kept->memory().geometry_bytes, plain->memory().geometry_bytes + bytes);
  SurfaceHit hit;
  ASSERT_TRUE(kept->intersect({Vec3f(0.1f, 0.2f, 5), Vec3f(0, 0, -1)}, {}, &hit));
  SurfaceInteraction surface;
  kept->interaction(hit, 0, &surface);
  EXPECT_NEAR(surface.attributes.uv[0].x, 0.25f, 1e-6);
  EXPECT_NEAR(surface.attributes.uv[0].y, 0.75f, 1e-6);
}

}  // namespace
}  // namespace emberline
