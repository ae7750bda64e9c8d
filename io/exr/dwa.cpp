// OpenEXR's C++ interface only writes whole files. Therefore each tile is written to memory as a
// separate file, and its chunk is extracted.
#include "io/exr/dwa.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <cstring>

namespace emberline {
namespace {

class MemoryStream final : public Imf::OStream {
 public:
  MemoryStream() : OStream("tile") {}
  void write(const char bytes[], int count) override {
    if (bytes_.size() < at_ + size_t(count)) bytes_.resize(at_ + size_t(count));
    std::memcpy(bytes_.data() + at_, bytes, size_t(count));
    at_ += size_t(count);
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t at) override { at_ = size_t(at); }
  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<uint8_t> bytes_;
  size_t at_ = 0;
};

}  // namespace

void encode_dwa_tile(int width, int height, std::span<const EncodedPlane> planes, bool wide,
                     std::vector<uint8_t>& code) {
  Imf::Header header(width, height, 1.0f, Imath::V2f(0.0f), 1.0f, Imf::RANDOM_Y,
                     wide ? Imf::DWAB_COMPRESSION : Imf::DWAA_COMPRESSION);
  header.setTileDescription(Imf::TileDescription(unsigned(width), unsigned(height)));
  Imf::FrameBuffer buffer;
  for (const EncodedPlane& plane : planes) {
    const Imf::PixelType type = plane.type == ChannelType::kHalf   ? Imf::HALF
                                : plane.type == ChannelType::kUint ? Imf::UINT
                                                                   : Imf::FLOAT;
    const size_t bytes = type == Imf::HALF ? 2 : 4;
    header.channels().insert(plane.channel, Imf::Channel(type));
    // OpenEXR only reads from this memory.
    auto* const values = reinterpret_cast<char*>(const_cast<uint8_t*>(plane.values));
    buffer.insert(plane.channel, Imf::Slice(type, values, bytes, bytes * size_t(width)));
  }
  MemoryStream stream;
  Imf::TiledOutputFile file(stream, header, 0);
  file.setFrameBuffer(buffer);
  // The chunk follows the header and the offset table. It has the tile's coordinates and level, the
  // size of the data, and the data.
  constexpr size_t kChunkHeaderBytes = 5 * sizeof(int32_t);
  const size_t begin = size_t(stream.tellp()) + kChunkHeaderBytes;
  file.writeTile(0, 0);
  code.assign(stream.bytes().begin() + ptrdiff_t(begin), stream.bytes().end());
}

}  // namespace emberline
