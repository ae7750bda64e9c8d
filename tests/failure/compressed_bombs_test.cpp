// Compressed views can decode to much more than their size. The memory budget refuses such views
// before anything is decoded.
#include "failure/bad_input.h"

#include <nlohmann/json.hpp>
#include "support/compressed_gltf.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::GltfBuilder;

// Encodes a grid that takes one or two bits a vertex, with constant attributes that take no space.
std::vector<uint8_t> draco_bomb(int side, int attributes) {
  draco::Mesh mesh;
  const auto count = uint32_t(side * side);
  mesh.set_num_points(count);
  const auto add = [&](draco::GeometryAttribute::Type type, int components) {
    draco::GeometryAttribute attribute;
    attribute.Init(type, nullptr, uint8_t(components), draco::DT_FLOAT32, false,
                   int64_t(sizeof(float)) * components, 0);
    return mesh.AddAttribute(attribute, true, count);
  };
  const int position = add(draco::GeometryAttribute::POSITION, 3);
  for (int i = 0; i < attributes; ++i) {
    const int constant = add(draco::GeometryAttribute::GENERIC, 64);
    const std::vector<float> zeros(64, 0.0f);
    for (uint32_t p = 0; p < count; ++p) {
      mesh.attribute(constant)->SetAttributeValue(draco::AttributeValueIndex(p), zeros.data());
    }
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const float p[3] = {float(x), float(y), 0.0f};
      const auto index = draco::AttributeValueIndex(uint32_t(y * side + x));
      mesh.attribute(position)->SetAttributeValue(index, p);
      if (x + 1 == side || y + 1 == side) continue;
      const auto corner = [&](int dx, int dy) {
        return draco::PointIndex(uint32_t((y + dy) * side + x + dx));
      };
      mesh.AddFace({corner(0, 0), corner(1, 0), corner(0, 1)});
      mesh.AddFace({corner(1, 0), corner(1, 1), corner(0, 1)});
    }
  }
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 11);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::GENERIC, 8);
  draco::EncoderBuffer encoded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &encoded).ok());
  return {encoded.data(), encoded.data() + encoded.size()};
}

TEST(CompressedBombs, DracoAttributesOfZeroBytes) {
  constexpr int kSide = 64, kAttributes = 20;
  const std::vector<uint8_t> stream = draco_bomb(kSide, kAttributes);
  GltfBuilder gltf;
  const int indices = gltf.push(
      "accessors",
      {{"componentType", 5125}, {"count", 6 * (kSide - 1) * (kSide - 1)}, {"type", "SCALAR"}});
  const int positions =
      gltf.push("accessors", {{"componentType", 5126}, {"count", kSide * kSide}, {"type", "VEC3"}});
  const json draco = {{"bufferView", gltf.add_view(stream)}, {"attributes", {{"POSITION", 0}}}};
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", positions}}},
                                    {"indices", indices},
                                    {"extensions", {{"KHR_draco_mesh_compression", draco}}}}));
  // The attributes take 4,096 vertices x 20 attributes x 64 numbers, twice: 42 MB. The mesh alone
  // takes 2 MB.
  ASSERT_LT(stream.size(), 20000u);
  const std::string message = test::rejection_message(gltf, uint64_t(16) << 20);
  EXPECT_NE(message.find("KHR_draco_mesh_compression"), std::string::npos) << message;
  EXPECT_NE(message.find("memory"), std::string::npos) << message;
  EXPECT_EQ(test::rejection_message(gltf, uint64_t(512) << 20), "no error");
}

TEST(CompressedBombs, ViewsOfOneMeshoptStream) {
  GltfBuilder gltf = test::meshopt_triangle(false);
  const int first =
      test::add_meshopt_view(gltf, test::encode_vertices(std::vector<float>(256 * 1024, 0.0f), 64));
  const json view = gltf.root["bufferViews"][size_t(first)];
  for (int i = 0; i < 300; ++i) gltf.root["bufferViews"].push_back(view);
  gltf.root["buffers"][1]["byteLength"] = 1 << 20;
  const std::string message = test::rejection_message(gltf, uint64_t(64) << 20);
  EXPECT_NE(message.find("#/bufferViews/"), std::string::npos) << message;
  EXPECT_NE(message.find("memory"), std::string::npos) << message;
}

}  // namespace
}  // namespace emberline
