// Draco and meshopt streams, written with their own encoders.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include "io/gltf.h"
#include "renderer/core/errors.h"
#include "support/gltf_builder.h"

namespace emberline {
namespace {

using nlohmann::json;
using test::GltfBuilder;
using test::TempFolder;

SceneDescription load(const GltfBuilder& gltf) {
  const TempFolder folder;
  return load_gltf(gltf.write_glb(folder / "a.glb"), {});
}

std::string message_of(const GltfBuilder& gltf) {
  try {
    load(gltf);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// ---- Draco
// -----------------------------------------------------------------------------------------

// A unit square of two triangles with positions, UVs and colours.
GltfBuilder draco_square(int method, bool with_metadata = false) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int uv = builder.AddAttribute(draco::GeometryAttribute::TEX_COORD, 2, draco::DT_FLOAT32);
  const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8);
  const float corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const int faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  for (int f = 0; f < 2; ++f) {
    float p[3][3], t[3][2];
    uint8_t c[3][4];
    for (int k = 0; k < 3; ++k) {
      const float* corner = corners[faces[f][k]];
      for (int a = 0; a < 3; ++a) p[k][a] = a < 2 ? corner[a] : 0.0f;
      for (int a = 0; a < 2; ++a) t[k][a] = corner[a] * 0.5f;
      for (int a = 0; a < 4; ++a) c[k][a] = uint8_t(a < 2 ? corner[a] * 51 : 255.0f);
    }
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(uint32_t(f)), p[0], p[1], p[2]);
    builder.SetAttributeValuesForFace(uv, draco::FaceIndex(uint32_t(f)), t[0], t[1], t[2]);
    builder.SetAttributeValuesForFace(color, draco::FaceIndex(uint32_t(f)), c[0], c[1], c[2]);
  }
  std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  if (with_metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("tool", "by hand");
    mesh->AddMetadata(std::move(metadata));
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  draco::EncoderBuffer encoded;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &encoded).ok());

  GltfBuilder gltf;
  const auto accessor = [&](int type, int count, const char* shape, bool normalized) {
    return gltf.push(
        "accessors",
        {{"componentType", type}, {"count", count}, {"type", shape}, {"normalized", normalized}});
  };
  const int view = gltf.add_view(encoded.data(), encoded.size());
  const int points = int(mesh->num_points());
  gltf.add_mesh_node(gltf.add_mesh(
      {{"attributes",
        {{"POSITION", accessor(5126, points, "VEC3", false)},
         {"TEXCOORD_0", accessor(5126, points, "VEC2", false)},
         {"COLOR_0", accessor(5121, points, "VEC4", true)}}},
       {"indices", accessor(5125, 6, "SCALAR", false)},
       {"extensions",
        {{"KHR_draco_mesh_compression",
          {{"bufferView", view},
           {"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}, {"COLOR_0", 2}}}}}}}}));
  gltf.root["extensionsUsed"] = gltf.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return gltf;
}

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
  EXPECT_NE(message_of(fewer).find("announces 2 faces"), std::string::npos) << message_of(fewer);
  GltfBuilder attribute = good;
  attribute.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["TEXCOORD_0"] = 7;
  EXPECT_NE(message_of(attribute).find("attributes/TEXCOORD_0"), std::string::npos);
  GltfBuilder shape = good;
  shape.root["accessors"][1]["type"] = "VEC3";
  EXPECT_NE(message_of(shape).find("attributes/TEXCOORD_0"), std::string::npos);
}

// A face count of 2^32 - 1 in the header must not be believed before anything is allocated.
TEST(GltfDraco, AbsurdCountsAreRefusedBeforeDecoding) {
  GltfBuilder gltf = draco_square(draco::MESH_SEQUENTIAL_ENCODING);
  // Header of 11 bytes, then the faces as a varint of one byte: make it five bytes long.
  ASSERT_EQ(gltf.bin[11], 2);
  gltf.bin.erase(gltf.bin.begin() + 11);
  const std::vector<uint8_t> huge = {0xff, 0xff, 0xff, 0xff, 0x0f};
  gltf.bin.insert(gltf.bin.begin() + 11, huge.begin(), huge.end());
  gltf.root["bufferViews"][0]["byteLength"] = gltf.bin.size();
  gltf.root["accessors"][3]["count"] = 4294967295u;
  EXPECT_NE(message_of(gltf).find("announces 4294967295 faces"), std::string::npos)
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
        message_of(changed);  // any InputError or none; anything else fails the test
      }
    }
  }
}

// ---- meshopt
// ---------------------------------------------------------------------------------------

struct MeshoptView {
  std::vector<uint8_t> encoded;
  size_t count, stride;
  std::string mode;
  std::string filter;
};

template <class T>
MeshoptView encode_vertices(const std::vector<T>& values, size_t stride,
                            const std::string& filter = "") {
  MeshoptView view;
  view.count = values.size() * sizeof(T) / stride;
  view.stride = stride;
  view.mode = "ATTRIBUTES";
  view.filter = filter;
  view.encoded.resize(meshopt_encodeVertexBufferBound(view.count, stride));
  meshopt_encodeVertexVersion(0);
  view.encoded.resize(meshopt_encodeVertexBuffer(view.encoded.data(), view.encoded.size(),
                                                 values.data(), view.count, stride));
  return view;
}

MeshoptView encode_indices(const std::vector<uint32_t>& indices, bool sequence) {
  MeshoptView view;
  view.count = indices.size();
  view.stride = 2;
  view.mode = sequence ? "INDICES" : "TRIANGLES";
  meshopt_encodeIndexVersion(1);
  view.encoded.resize(sequence ? meshopt_encodeIndexSequenceBound(indices.size(), 100)
                               : meshopt_encodeIndexBufferBound(indices.size(), 100));
  view.encoded.resize(sequence
                          ? meshopt_encodeIndexSequence(view.encoded.data(), view.encoded.size(),
                                                        indices.data(), indices.size())
                          : meshopt_encodeIndexBuffer(view.encoded.data(), view.encoded.size(),
                                                      indices.data(), indices.size()));
  return view;
}

// Adds the stream in buffer 0 and a view of the fallback buffer 1, which has no data.
int add_meshopt_view(GltfBuilder& gltf, const MeshoptView& stream,
                     const std::string& extension = "EXT_meshopt_compression") {
  const int raw = gltf.add_view(stream.encoded);
  const json source = gltf.root["bufferViews"][size_t(raw)];
  json description = {{"buffer", 0},
                      {"byteOffset", source["byteOffset"]},
                      {"byteLength", source["byteLength"]},
                      {"byteStride", stream.stride},
                      {"count", stream.count},
                      {"mode", stream.mode}};
  if (!stream.filter.empty()) description["filter"] = stream.filter;
  json view = {{"buffer", 1},
               {"byteLength", stream.count * stream.stride},
               {"extensions", {{extension, description}}}};
  if (stream.mode == "ATTRIBUTES") view["byteStride"] = stream.stride;
  gltf.root["bufferViews"][size_t(raw)] = view;
  gltf.root["buffers"] = {
      json::object(),
      {{"byteLength", 100000}, {"extensions", {{extension, {{"fallback", true}}}}}}};
  gltf.root["extensionsRequired"] = {extension};
  return raw;
}

int add_meshopt_accessor(GltfBuilder& gltf, int view, int type, size_t count,
                         const std::string& shape, bool normalized = false) {
  return gltf.push("accessors", {{"bufferView", view},
                                 {"componentType", type},
                                 {"count", count},
                                 {"type", shape},
                                 {"normalized", normalized}});
}

GltfBuilder meshopt_triangle(bool sequence,
                             const std::string& extension = "EXT_meshopt_compression") {
  GltfBuilder gltf;
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const int p = add_meshopt_view(gltf, encode_vertices(positions, 12), extension);
  const int i = add_meshopt_view(gltf, encode_indices({0, 1, 2}, sequence), extension);
  const int pa = add_meshopt_accessor(gltf, p, 5126, 3, "VEC3");
  const int ia = add_meshopt_accessor(gltf, i, 5123, 3, "SCALAR");
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", pa}}}, {"indices", ia}}));
  return gltf;
}

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
  // Octahedral normals in 8 bits: +z, +x, and a slanted one.
  const float normals[12] = {0, 0, 1, 0, 1, 0, 0, 0, 0.6f, 0, 0.8f, 0};
  std::vector<uint8_t> octahedral(3 * 4);
  meshopt_encodeFilterOct(octahedral.data(), 3, 4, 8, normals);
  const int n = add_meshopt_view(gltf, encode_vertices(octahedral, 4, "OCTAHEDRAL"));
  gltf.primitive()["attributes"]["NORMAL"] = add_meshopt_accessor(gltf, n, 5120, 3, "VEC3", true);
  // Exponential UVs.
  const float uvs[6] = {0.5f, 0.25f, 3.0f, -1.5f, 0.0f, 100.0f};
  std::vector<uint32_t> exponential(6);
#if MESHOPTIMIZER_VERSION > 180  // Debian 12 has 0.18
  meshopt_encodeFilterExp(exponential.data(), 3, 8, 20, uvs, meshopt_EncodeExpSharedVector);
#else
  meshopt_encodeFilterExp(exponential.data(), 3, 8, 20, uvs);
#endif
  const int t = add_meshopt_view(gltf, encode_vertices(exponential, 8, "EXPONENTIAL"));
  gltf.primitive()["attributes"]["TEXCOORD_0"] = add_meshopt_accessor(gltf, t, 5126, 3, "VEC2");
  // Quaternion rotations of instances: none, 90 degrees about z.
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
  EXPECT_NEAR(scene.instances[1].to_world[0][1], 1.0, 1e-3);  // x goes to y
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
  broken("count", 4000000000u, "cannot be in");
  broken("byteLength", 10, "corrupt");
  broken("byteLength", 1000000, "outside the buffer");
  broken("byteStride", 6, "not allowed for ATTRIBUTES");
  broken("byteStride", 300, "whole number from 1 to 256");
  broken("mode", "POINTS", "unknown meshopt mode");
  broken("mode", "INDICES", "not allowed for INDICES");
  broken("filter", "COLOR", "unknown meshopt filter");
  broken("filter", "QUATERNION", "not allowed");
  broken("buffer", 1, "outside the buffer");
  GltfBuilder header = good;
  header.bin[0] = 0xf7;
  EXPECT_NE(message_of(header).find("corrupt or of a newer version"), std::string::npos);
  // A view without compression cannot live in the fallback buffer.
  GltfBuilder plain = good;
  plain.root["bufferViews"][0].erase("extensions");
  EXPECT_NE(message_of(plain).find("outside the buffer of 0 bytes"), std::string::npos);
}

}  // namespace
}  // namespace emberline
