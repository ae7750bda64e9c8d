#include "io/gltf/geometry/draco.h"

#include <draco/compression/config/compression_shared.h>
#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <optional>
#include <utility>

#include "io/gltf/document/accessor.h"
#include "renderer/core/errors.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

// Limit on the number of faces per byte of the stream, and also on the number of vertices per byte.
// With this limit, a face or vertex takes at least 1/32 bit. The value is our choice: Draco has no
// minimum (its entropy coder approaches zero for regular meshes), but real meshes need at least one
// bit per face.
constexpr uint64_t kMaxPerByte = 256;

// The counts in the header of a Draco stream. They are read first, because Draco allocates memory
// for that many elements before it reads the data. The layout follows the Draco bitstream
// specification 2.2, "Decode header", "Decode metadata" and "Decode connectivity data".
// peek_counts() returns nothing if the stream ends before the counts.
struct DracoCounts {
  uint8_t method = 0;
  uint64_t faces = 0, points = 0;
};
std::optional<DracoCounts> peek_counts(ByteSpan encoded, const std::string& place) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  char magic[5];
  uint8_t major = 0, minor = 0, type = 0, method = 0;
  uint16_t flags = 0;
  if (!buffer.Decode(magic, sizeof(magic)) || std::string_view(magic, 5) != "DRACO" ||
      !buffer.Decode(&major) || !buffer.Decode(&minor) || !buffer.Decode(&type) ||
      !buffer.Decode(&method) || !buffer.Decode(&flags)) {
    return {};
  }
  if (major != 2 || minor != 2) {
    throw InputError(place, "Draco bitstream version {}.{} is not supported, glTF uses 2.2", major,
                     minor);
  }
  if (type != draco::TRIANGULAR_MESH) {
    throw InputError(place, "the Draco data is not a triangle mesh");
  }
  buffer.set_bitstream_version(uint16_t(major << 8 | minor));
  if (flags & METADATA_FLAG_MASK) {
    draco::GeometryMetadata metadata;
    draco::MetadataDecoder decoder;
    if (!decoder.DecodeGeometryMetadata(&buffer, &metadata)) return {};
  }
  uint32_t face_count = 0, point_count = 0;
  if (method == draco::MESH_EDGEBREAKER_ENCODING) {
    uint8_t traversal = 0;
    if (!buffer.Decode(&traversal) || !draco::DecodeVarint(&point_count, &buffer) ||
        !draco::DecodeVarint(&face_count, &buffer)) {
      return {};
    }
  } else if (!draco::DecodeVarint(&face_count, &buffer) ||
             !draco::DecodeVarint(&point_count, &buffer)) {
    return {};
  }
  return DracoCounts{method, face_count, point_count};
}

// A Draco decoder that reserves memory for the attributes. It does this after it has read their
// descriptions and before it decodes their values. The stream's size does not limit this memory,
// since values may take no bits and there may be any number of attributes.
template <class MeshDecoder>
class BudgetedDecoder final : public MeshDecoder {
 public:
  BudgetedDecoder(MemoryReservation& memory, const std::string& place)
      : memory_(memory), place_(place) {}

 protected:
  bool DecodeAllAttributes() override {
    uint64_t bytes_per_point = 0;
    for (int i = 0; i < this->point_cloud()->num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *this->point_cloud()->attribute(i);
      // Each component is stored twice, as a quantised int32 and as a value. Each attribute also
      // has one index per point.
      const int64_t component = draco::DataTypeLength(attribute.data_type()) + 4;
      bytes_per_point += uint64_t(attribute.num_components()) * uint64_t(component) + 4;
    }
    memory_.add(bytes_of(this->point_cloud()->num_points(), bytes_per_point), place_);
    return MeshDecoder::DecodeAllAttributes();
  }

 private:
  MemoryReservation& memory_;
  const std::string& place_;
};

template <class MeshDecoder>
std::unique_ptr<draco::Mesh> decode_mesh(ByteSpan encoded, MemoryReservation& memory,
                                         const std::string& place) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  auto mesh = std::make_unique<draco::Mesh>();
  const draco::Status status = BudgetedDecoder<MeshDecoder>(memory, place)
                                   .Decode(draco::DecoderOptions(), &buffer, mesh.get());
  if (status.ok()) return mesh;
  throw InputError(place, "cannot decode the Draco data: " + shortened(status.error_msg_string()));
}

constexpr std::pair<draco::DataType, int> kComponentTypes[] = {
    {draco::DT_INT8, 5120},   {draco::DT_UINT8, 5121},  {draco::DT_INT16, 5122},
    {draco::DT_UINT16, 5123}, {draco::DT_UINT32, 5125}, {draco::DT_FLOAT32, 5126}};

// Returns glTF's code for the component type, or 0 if glTF has none.
int component_type(draco::DataType type) {
  for (const auto& [theirs, number] : kComponentTypes) {
    if (theirs == type) return number;
  }
  return 0;
}

std::vector<float> read_attribute(const draco::Mesh& mesh, const DracoRequest& request,
                                  const std::string& place) {
  const std::string attribute_place = place + "/attributes/" + request.name;
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(request.unique_id);
  if (!attribute) {
    throw InputError(attribute_place, "the Draco data has no attribute {}", request.unique_id);
  }
  const int type = component_type(attribute->data_type());
  if (type == 0 || attribute->num_components() != request.components) {
    throw InputError(attribute_place, "the Draco attribute and its accessor have different types");
  }
  const size_t components = size_t(request.components);
  const int64_t component_size = draco::DataTypeLength(attribute->data_type());
  std::vector<float> values(size_t(mesh.num_points()) * components);
  for (uint32_t i = 0; i < mesh.num_points(); ++i) {
    const draco::AttributeValueIndex index = attribute->mapped_index(draco::PointIndex(i));
    if (index.value() >= attribute->size()) {
      throw InputError(attribute_place, "the Draco data is corrupt");
    }
    const uint8_t* bytes = attribute->GetAddress(index);
    for (size_t c = 0; c < components; ++c) {
      values[i * components + c] =
          read_component(bytes + int64_t(c) * component_size, type, request.normalized);
    }
  }
  return values;
}

}  // namespace

DracoPrimitive decode_draco(ByteSpan encoded, const std::vector<DracoRequest>& requests,
                            uint64_t declared_indices, const std::string& place,
                            const LoadProgress& progress) {
  const std::optional<DracoCounts> counts = peek_counts(encoded, place);
  if (!counts) throw InputError(place, "the Draco data is truncated or corrupt");
  const auto [method, faces, points] = *counts;
  const uint64_t max_count = encoded.size() * kMaxPerByte;
  if (faces > max_count || points > max_count || faces * 3 > declared_indices) {
    throw InputError(
        place,
        "the Draco data declares {} faces and {} vertices, too many for {} indices and {} bytes",
        faces, points, declared_indices, encoded.size());
  }
  // The approximate memory of the faces, the corner table and the traversal stacks.
  MemoryReservation memory(progress.budget(), MemoryPart::kGeometry, faces * 128 + points * 32,
                           place);
  std::unique_ptr<draco::Mesh> mesh;
  try {
    mesh = method == draco::MESH_EDGEBREAKER_ENCODING
               ? decode_mesh<draco::MeshEdgebreakerDecoder>(encoded, memory, place)
               : decode_mesh<draco::MeshSequentialDecoder>(encoded, memory, place);
  } catch (const std::bad_alloc&) {
    throw InputError(place, "the Draco data needs more memory than is available");
  } catch (const std::length_error&) {
    throw InputError(place, "the Draco data is corrupt");
  }

  DracoPrimitive primitive;
  primitive.vertex_count = mesh->num_points();
  primitive.indices.reserve(size_t(mesh->num_faces()) * 3);
  for (uint32_t f = 0; f < mesh->num_faces(); ++f) {
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(f))) {
      if (point.value() >= mesh->num_points()) throw InputError(place, "the Draco data is corrupt");
      primitive.indices.push_back(point.value());
    }
  }
  for (const DracoRequest& request : requests) {
    primitive.attributes[request.name] = read_attribute(*mesh, request, place);
  }
  return primitive;
}

}  // namespace emberline
