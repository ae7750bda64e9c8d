// Reads Draco and meshopt streams that their own encoders have written.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/gltf/document/meshopt.h"
#include "io/gltf/document/uri.h"
#include "renderer/core/errors.h"
#include "support/compressed_gltf.h"
#include "support/loaded_gltf.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::add_meshopt_accessor;
using test::add_meshopt_view;
using test::draco_square;
using test::encode_vertices;
using test::GltfBuilder;
using test::load;
using test::meshopt_triangle;
using test::message_of;

// ---- Draco ---------------------------------------------------------------------------------

TEST(GltfDraco, BothEncodingsWithAndWithoutMetadata) {
  for (const int method :
       {int(draco::MESH_SEQUENTIAL_ENCODING), int(draco::MESH_EDGEBREAKER_ENCODING)}) {
    for (const bool with_metadata : {false, true}) {
      const SceneDescription scene = load(draco_square(method, with_metadata));
      const MeshDescription& mesh = scene.meshes.at(0);
      ASSERT_EQ(mesh.triangles.size(), 2u);
      double area = 0.0;
      for (const auto& t : mesh.triangles) {
        const Vec3f n = cross(mesh.positions[t[1]] - mesh.positions[t[0]],
                              mesh.positions[t[2]] - mesh.positions[t[0]]);
        EXPECT_GT(n.z, 0.0f);
        area += 0.5 * n.z;
        for (const uint32_t v : t) {
          const Vec3f& p = mesh.positions[v];
          EXPECT_NEAR(mesh.uv_sets.at(0)[v].x, p.x * 0.5f, 1e-3f);
          EXPECT_NEAR(mesh.colors[v].x, p.x * 0.2f, 1e-3f);
          EXPECT_EQ(mesh.colors[v].w, 1.0f);
        }
      }
      EXPECT_NEAR(area, 1.0, 1e-3);
    }
  }
}

TEST(GltfDraco, BrokenStreamsAreErrors) {
  const GltfBuilder good = draco_square(draco::MESH_EDGEBREAKER_ENCODING);
  const std::string place = "#/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
  GltfBuilder truncated = good;
  truncated.root["bufferViews"][0]["byteLength"] = 20;
  EXPECT_NE(message_of(truncated).find(place), std::string::npos) << message_of(truncated);
  GltfBuilder magic = good;
  magic.bin[0] = 'X';
  EXPECT_NE(message_of(magic).find("truncated or corrupt"), std::string::npos);
  GltfBuilder version = good;
  version.bin[6] = 9;
  EXPECT_NE(message_of(version).find("2.9"), std::string::npos) << message_of(version);
  GltfBuilder fewer = good;
  fewer.root["accessors"][3]["count"] = 3;
  EXPECT_NE(message_of(fewer).find("declares 2 faces"), std::string::npos) << message_of(fewer);
  GltfBuilder attribute = good;
  attribute.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["TEXCOORD_0"] = 7;
  EXPECT_NE(message_of(attribute).find("attributes/TEXCOORD_0"), std::string::npos);
  GltfBuilder shape = good;
  shape.root["accessors"][1]["type"] = "VEC3";
  EXPECT_NE(message_of(shape).find("attributes/TEXCOORD_0"), std::string::npos);
}

// A face count of 2^32 - 1 in the header must be rejected before anything is allocated.
TEST(GltfDraco, AbsurdCountsAreRefusedBeforeDecoding) {
  GltfBuilder gltf = draco_square(draco::MESH_SEQUENTIAL_ENCODING);
  // After a header of 11 bytes, the face count is a varint of one byte. The test replaces it with
  // five bytes.
  ASSERT_EQ(gltf.bin[11], 2);
  gltf.bin.erase(gltf.bin.begin() + 11);
  const std::vector<uint8_t> huge = {0xff, 0xff, 0xff, 0xff, 0x0f};
  gltf.bin.insert(gltf.bin.begin() + 11, huge.begin(), huge.end());
  gltf.root["bufferViews"][0]["byteLength"] = gltf.bin.size();
  gltf.root["accessors"][3]["count"] = 4294967295u;
  EXPECT_NE(message_of(gltf).find("declares 4294967295 faces"), std::string::npos)
      << message_of(gltf);
}

TEST(GltfDraco, EveryByteChangedNeverCrashes) {
  for (const int method :
       {int(draco::MESH_SEQUENTIAL_ENCODING), int(draco::MESH_EDGEBREAKER_ENCODING)}) {
    const GltfBuilder good = draco_square(method);
    const size_t size = good.root["bufferViews"][0]["byteLength"].get<size_t>();
    for (size_t i = 0; i < size; ++i) {
      for (const int value : {0, 1, 0x7f, 0x80, 0xff}) {
        GltfBuilder changed = good;
        changed.bin[i] = uint8_t(value);
        message_of(changed);  // may throw an InputError; anything else fails the test
      }
    }
  }
}

// ---- meshopt -------------------------------------------------------------------------------

TEST(GltfMeshopt, AttributesAndBothIndexModes) {
  for (const bool sequence : {false, true}) {
    for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
      const SceneDescription scene = load(meshopt_triangle(sequence, extension));
      EXPECT_EQ(scene.meshes.at(0).positions,
                (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)}));
      EXPECT_EQ(scene.coverage.used, std::vector<std::string>{extension});
    }
  }
}

TEST(GltfMeshopt, Filters) {
  GltfBuilder gltf = meshopt_triangle(false);
  // Octahedral normals with 8 bits: +Z, +X and a slanted one.
  const float normals[12] = {0, 0, 1, 0, 1, 0, 0, 0, 0.6f, 0, 0.8f, 0};
  std::vector<uint8_t> octahedral(3 * 4);
  meshopt_encodeFilterOct(octahedral.data(), 3, 4, 8, normals);
  const int n = add_meshopt_view(gltf, encode_vertices(octahedral, 4, "OCTAHEDRAL"));
  gltf.primitive()["attributes"]["NORMAL"] = add_meshopt_accessor(gltf, n, 5120, 3, "VEC3", true);
  // UVs with the exponential filter.
  const float uvs[6] = {0.5f, 0.25f, 3.0f, -1.5f, 0.0f, 100.0f};
  std::vector<uint32_t> exponential(6);
#if MESHOPTIMIZER_VERSION > 180  // Debian 12 has 0.18
  meshopt_encodeFilterExp(exponential.data(), 3, 8, 20, uvs, meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(exponential.data(), 3, 8, 20, uvs);
#endif
  const int t = add_meshopt_view(gltf, encode_vertices(exponential, 8, "EXPONENTIAL"));
  gltf.primitive()["attributes"]["TEXCOORD_0"] = add_meshopt_accessor(gltf, t, 5126, 3, "VEC2");
  // The instances have rotations as quaternions: none, and 90 degrees about Z.
  const float h = std::sqrt(0.5f);
  const float quaternions[8] = {0, 0, 0, 1, 0, 0, h, h};
  std::vector<uint16_t> packed(8);
  meshopt_encodeFilterQuat(packed.data(), 2, 8, 16, quaternions);
  const int q = add_meshopt_view(gltf, encode_vertices(packed, 8, "QUATERNION"));
  gltf.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", add_meshopt_accessor(gltf, q, 5122, 2, "VEC4", true)}};

  const SceneDescription scene = load(gltf);
  const MeshDescription& mesh = scene.meshes.at(0);
  for (int v = 0; v < 3; ++v) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mesh.normals[size_t(v)][c], normals[v * 4 + c], 0.01f);
    for (int c = 0; c < 2; ++c)
      EXPECT_NEAR(mesh.uv_sets.at(0)[size_t(v)][c], uvs[v * 2 + c], 1e-3f);
  }
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_NEAR(scene.instances[1].to_world[0][1], 1.0, 1e-3);  // x maps to y
}

// ---- Attributes of version 1 and the COLOR filter. The streams come from meshoptimizer 1.3
// (levels 3 and 2), which decodes them to the same values.

using Bytes = std::vector<uint8_t>;

Bytes from_base64(const char* text) {
  return decode_data_uri(std::string("data:;base64,") + text, "test");
}

// The elements have 12 bytes. The first four are encoded as bytes, the next four as 16-bit integers
// and the last four as floats. The stream has literal, zero and packed bytes.
const char* const kForty =
    "oa2X6hUqquqqDeqq6qoNDeqqAAANAAIGCg4SFhoeIiYqLjI2Oj5CRkpOUlZaXmJmam5ydnp+"
    "goaKjpKWmgBYWFhYWFhYWFhYW"
    "FhYWFhYWFhYWFhYWFhYWFhYWFhYWFhYWFhYWFgVKqqqqqqqqqqqqgAAKg3d3d3d3d3d3d3d3d3d3d3d3d3dAAAAAAD6BgE"
    "D/vo"
    "GAQP++gYBA/76BgED/voGAQP++gYBA/76BgED/voGAQMAAAAAAAAAAAAAAAAAAAD//wAAAAAAASI=";

Bytes forty_elements() {
  Bytes elements(40 * 12, 0);
  for (size_t i = 0; i < 40; ++i) {
    uint8_t* out = elements.data() + i * 12;
    const uint16_t shorts[] = {uint16_t(i * 300), uint16_t(65535 - i * 7)};
    const float number = float(i % 5) * 0.25f;
    out[0] = uint8_t(i & 7);
    out[1] = uint8_t(i * i);
    std::memcpy(out + 4, shorts, 4);
    std::memcpy(out + 8, &number, 4);
  }
  return elements;
}

TEST(MeshoptV1, Attributes) {
  const Bytes encoded = from_base64(kForty);
  Bytes decoded(40 * 12);
  ASSERT_TRUE(decode_meshopt_v1(encoded, 40, 12, decoded.data()));
  EXPECT_EQ(decoded, forty_elements());
}

TEST(MeshoptV1, BlocksFollowEachOther) {
  const Bytes encoded = from_base64("oaopFaqqqqqqqqqqqqqqABAACBAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAQA=");
  Bytes expected(300 * 4, 0);
  for (size_t i = 0; i < 300; ++i) {
    expected[i * 4] = uint8_t(i < 256 ? 0 : i - 255);
    expected[i * 4 + 3] = i == 299 ? 9 : 1;
  }
  EXPECT_LE(min_meshopt_v1_size(300, 4), encoded.size());
  Bytes decoded(300 * 4);
  ASSERT_TRUE(decode_meshopt_v1(encoded, 300, 4, decoded.data()));
  EXPECT_EQ(decoded, expected);
}

TEST(MeshoptV1, DamagedStreamsAreRefusedOrDecodeInside) {
  const Bytes good = from_base64(kForty);
  Bytes decoded(41 * 12);
  for (size_t size = 0; size < good.size(); ++size) {
    const Bytes cut(good.begin(), good.begin() + std::ptrdiff_t(size));
    EXPECT_FALSE(decode_meshopt_v1(cut, 40, 12, decoded.data())) << size;
  }
  for (size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes changed = good;
      changed[i] = uint8_t(changed[i] ^ 1 << bit);
      decode_meshopt_v1(changed, 40, 12, decoded.data());
    }
  }
  EXPECT_FALSE(decode_meshopt_v1(good, 41, 12, decoded.data()));
  EXPECT_FALSE(decode_meshopt_v1(good, 40, 10, decoded.data()));
  for (const uint8_t channel : {uint8_t(3), uint8_t(0x10), uint8_t(0x11)}) {
    Bytes changed = good;
    changed.back() = channel;
    EXPECT_FALSE(decode_meshopt_v1(changed, 40, 12, decoded.data())) << int(channel);
  }
}

TEST(MeshoptV1, ColorFilter) {
  Bytes bytes = {64, 127, 193, 255, 127, 0, 127, 255, 128, 193, 0, 192};
  decode_meshopt_color(bytes.data(), 3, 4);
  EXPECT_EQ(bytes, (Bytes{254, 1, 0, 255, 0, 254, 0, 255, 65, 128, 191, 128}));
  const uint8_t wide[] = {0,   4, 255, 7,  1, 252, 255, 15,  255, 7, 0, 0,
                          255, 7, 255, 15, 0, 8,   1,   252, 0,   0, 0, 12};
  std::array<uint16_t, 12> words;
  std::memcpy(words.data(), wide, sizeof(wide));
  Bytes elements(wide, wide + sizeof(wide));
  decode_meshopt_color(elements.data(), 3, 8);
  std::memcpy(words.data(), elements.data(), elements.size());
  EXPECT_EQ(words, (std::array<uint16_t, 12>{65519, 16, 0, 65535, 0, 65519, 0, 65535, 16404, 32776,
                                             49147, 32776}));
  Bytes unmarked(4, 0);
  decode_meshopt_color(unmarked.data(), 1, 4);
  EXPECT_EQ(unmarked, Bytes(4, 0));
}

TEST(MeshoptV1, IsReadInAFile) {
  GltfBuilder gltf = meshopt_triangle(false, "KHR_meshopt_compression");
  // The triangle has positions, and colours that pass through the filter.
  const int p =
      add_meshopt_view(gltf,
                       {{161, 250, 234, 170, 0, 0, 255, 0, 127, 126, 0, 0, 127, 0, 0, 0, 0, 0, 0,
                         0,   0,   0,   0,   0, 0, 0,   0, 0,   0,   0, 0, 0,   0, 0, 1, 1, 0},
                        3,
                        12,
                        "ATTRIBUTES",
                        ""},
                       "KHR_meshopt_compression");
  const int c = add_meshopt_view(
      gltf,
      {{161, 255, 0, 126, 2, 0, 253, 125, 0, 131, 253, 0, 0, 125, 0,  0,   0,   0,   0,
        0,   0,   0, 0,   0, 0, 0,   0,   0, 0,   0,   0, 0, 0,   64, 127, 193, 255, 0},
       3,
       4,
       "ATTRIBUTES",
       "COLOR"},
      "KHR_meshopt_compression");
  json& attributes = gltf.primitive()["attributes"];
  attributes["POSITION"] = add_meshopt_accessor(gltf, p, 5126, 3, "VEC3");
  attributes["COLOR_0"] = add_meshopt_accessor(gltf, c, 5121, 3, "VEC4", true);
  const SceneDescription scene = load(gltf);
  const MeshDescription& mesh = scene.meshes.at(0);
  EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)}));
  EXPECT_NEAR(mesh.colors.at(0).x, 1.0f, 0.01f);
  EXPECT_NEAR(mesh.colors.at(2).z, 0.75f, 0.01f);
  EXPECT_NEAR(mesh.colors.at(2).w, 0.5f, 0.01f);
  gltf.root["bufferViews"][size_t(p)]["extensions"]["KHR_meshopt_compression"]["count"] = 1u << 20;
  EXPECT_NE(message_of(gltf).find("1048576 elements do not fit into 37"), std::string::npos)
      << message_of(gltf);
}

TEST(GltfMeshopt, BrokenStreamsAreErrors) {
  const GltfBuilder good = meshopt_triangle(false);
  const auto broken = [&](const char* member, const json& value, const char* expected) {
    GltfBuilder gltf = good;
    gltf.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][member] = value;
    const std::string message = message_of(gltf);
    EXPECT_NE(message.find("#/bufferViews/0"), std::string::npos) << message;
    EXPECT_NE(message.find(expected), std::string::npos) << message;
  };
  broken("count", 4, "byteStride is 48");
  broken("count", 4000000000u, "do not fit into");
  broken("byteLength", 10, "corrupt");
  broken("byteLength", 1000000, "outside the buffer");
  broken("byteStride", 6, "not allowed for ATTRIBUTES");
  broken("byteStride", 300, "whole number from 1 to 256");
  broken("mode", "POINTS", "unknown meshopt mode");
  broken("mode", "INDICES", "not allowed for INDICES");
  broken("filter", "SEPIA", "unknown meshopt filter");
  broken("filter", "COLOR", "not allowed");
  broken("filter", "QUATERNION", "not allowed");
  broken("buffer", 2, "index 2 is out of range");
  GltfBuilder header = good;
  header.bin[0] = 0xf7;
  EXPECT_NE(message_of(header).find("corrupt or of a newer version"), std::string::npos);
  // An uncompressed view cannot use the placeholder buffer.
  GltfBuilder nowhere = good;
  nowhere.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["buffer"] = 1;
  EXPECT_NE(message_of(nowhere).find("#/buffers/1: the buffer has neither"), std::string::npos);
  GltfBuilder plain = good;
  plain.root["bufferViews"][0].erase("extensions");
  EXPECT_NE(message_of(plain).find("#/buffers/1: the buffer has neither"), std::string::npos);
}

}  // namespace
}  // namespace emberline
