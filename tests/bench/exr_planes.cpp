#include "bench/exr_planes.h"

#include <ImathBox.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>

namespace emberline::bench {

ExrPlanes read_exr_planes(const std::string& path) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i window = file.header().dataWindow();
  ExrPlanes frame;
  frame.width = window.max.x - window.min.x + 1;
  frame.height = window.max.y - window.min.y + 1;
  Imf::FrameBuffer buffer;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
    std::vector<float>& plane = frame.planes[c.name()];
    plane.resize(size_t(frame.width) * size_t(frame.height));
    buffer.insert(c.name(), Imf::Slice::Make(Imf::FLOAT, plane.data(), window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return frame;
}

RgbImage picture_of(const ExrPlanes& frame) {
  RgbImage image = {frame.width, frame.height, {}};
  for (size_t i = 0; i < size_t(frame.width) * size_t(frame.height); ++i) {
    for (const char* c : {"R", "G", "B"}) image.rgb.push_back(frame.planes.at(c)[i]);
  }
  return image;
}

void write_exr_planes(const std::string& path, int width, int height,
                      std::span<const NamedPlane> planes) {
  Imf::Header header(width, height);
  Imf::FrameBuffer buffer;
  for (const auto& [name, plane] : planes) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, plane.data(), header.dataWindow()));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

}  // namespace emberline::bench
