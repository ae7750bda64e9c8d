#include "cli/picture.h"

#include <ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <bit>

namespace emberline::test {
namespace {

Rect half_open(const Imath::Box2i& box) {
  return {box.min.x, box.min.y, box.max.x + 1, box.max.y + 1};
}

}  // namespace

ExrPicture read_exr(const std::string& path) {
  Imf::InputFile file(path.c_str());
  const Imf::Header& header = file.header();
  ExrPicture picture;
  picture.data = half_open(header.dataWindow());
  picture.display = half_open(header.displayWindow());
  if (header.hasTileDescription()) picture.tile_size = int(header.tileDescription().xSize);
  for (auto i = header.begin(); i != header.end(); ++i) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&i.attribute())) {
      picture.attributes[i.name()] = text->value();
    }
  }
  const size_t width = size_t(picture.data.width());
  Imf::FrameBuffer buffer;
  for (auto i = header.channels().begin(); i != header.channels().end(); ++i) {
    constexpr const char* kTypes[] = {"uint", "half", "float"};
    picture.types[i.name()] = kTypes[i.channel().type];
    std::vector<float>& values = picture.channels[i.name()];
    values.assign(size_t(picture.data.area()), 0.0f);
    // In OpenEXR, coordinates start at the corner of the display window. OpenEXR converts uint
    // values to floats of the same value.
    buffer.insert(i.name(), Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(),
                                             sizeof(float), sizeof(float) * width));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  return picture;
}

std::string first_difference(const ExrPicture& a, const ExrPicture& b) {
  if (a.types != b.types) return "the channels";
  const Rect common = a.data.intersect(b.data);
  for (const auto& [name, type] : a.types) {
    if (name == "time") continue;
    for (int y = common.y0; y < common.y1; ++y) {
      for (int x = common.x0; x < common.x1; ++x) {
        const auto bits_a = std::bit_cast<uint32_t>(a.at(name, x, y));
        const auto bits_b = std::bit_cast<uint32_t>(b.at(name, x, y));
        if (bits_a == bits_b) continue;
        return name + " of pixel " + std::to_string(x) + "," + std::to_string(y) + ": " +
               std::to_string(a.at(name, x, y)) + " and " + std::to_string(b.at(name, x, y));
      }
    }
  }
  return "";
}

}  // namespace emberline::test
