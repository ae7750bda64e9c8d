#include "support/compressed_gltf.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace emberline::test {

GltfBuilder draco_square(int method, bool with_metadata) {
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
  if (!encoder.EncodeMeshToBuffer(*mesh, &encoded).ok()) throw std::runtime_error("Draco");

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

int add_meshopt_view(GltfBuilder& gltf, const MeshoptView& stream, const std::string& extension) {
  const int raw = gltf.add_view(stream.encoded);
  const nlohmann::json source = gltf.root["bufferViews"][size_t(raw)];
  nlohmann::json description = {{"buffer", 0},
                                {"byteOffset", source["byteOffset"]},
                                {"byteLength", source["byteLength"]},
                                {"byteStride", stream.stride},
                                {"count", stream.count},
                                {"mode", stream.mode}};
  if (!stream.filter.empty()) description["filter"] = stream.filter;
  nlohmann::json view = {{"buffer", 1},
                         {"byteLength", stream.count * stream.stride},
                         {"extensions", {{extension, description}}}};
  if (stream.mode == "ATTRIBUTES") view["byteStride"] = stream.stride;
  gltf.root["bufferViews"][size_t(raw)] = view;
  gltf.root["buffers"] = {
      nlohmann::json::object(),
      {{"byteLength", 100000}, {"extensions", {{extension, {{"fallback", true}}}}}}};
  gltf.root["extensionsRequired"] = {extension};
  return raw;
}

int add_meshopt_accessor(GltfBuilder& gltf, int view, int type, size_t count,
                         const std::string& shape, bool normalized) {
  return gltf.push("accessors", {{"bufferView", view},
                                 {"componentType", type},
                                 {"count", count},
                                 {"type", shape},
                                 {"normalized", normalized}});
}

GltfBuilder meshopt_triangle(bool sequence, const std::string& extension) {
  GltfBuilder gltf;
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const int p = add_meshopt_view(gltf, encode_vertices(positions, 12), extension);
  const int i = add_meshopt_view(gltf, encode_indices({0, 1, 2}, sequence), extension);
  const int pa = add_meshopt_accessor(gltf, p, 5126, 3, "VEC3");
  const int ia = add_meshopt_accessor(gltf, i, 5123, 3, "SCALAR");
  gltf.add_mesh_node(gltf.add_mesh({{"attributes", {{"POSITION", pa}}}, {"indices", ia}}));
  return gltf;
}

}  // namespace emberline::test
