// The image library: OpenImageIO, and nothing of ours but the interface.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include "io/image_library.h"

namespace emberline {
namespace {

namespace oiio = OIIO;

// Its message as one line.
std::string one_line(std::string text) {
  for (char& c : text) {
    if (uint8_t(c) < 0x20) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.empty() ? "unknown reason" : text.substr(0, 200);
}

constexpr std::pair<SampleType, oiio::TypeDesc::BASETYPE> kTypes[] = {
    {SampleType::kUint8, oiio::TypeDesc::UINT8},
    {SampleType::kUint16, oiio::TypeDesc::UINT16},
    {SampleType::kUint32, oiio::TypeDesc::UINT32},
    {SampleType::kHalf, oiio::TypeDesc::HALF},
    {SampleType::kFloat, oiio::TypeDesc::FLOAT}};

SampleType sample_type(oiio::TypeDesc type) {
  for (const auto& [ours, theirs] : kTypes) {
    if (theirs == type.basetype) return ours;
  }
  return SampleType::kOther;
}

oiio::TypeDesc oiio_type(SampleType type) {
  for (const auto& [ours, theirs] : kTypes) {
    if (ours == type) return theirs;
  }
  return oiio::TypeDesc::FLOAT;
}

// Bytes that are read where they lie. OpenImageIO's own for memory (2.4, 3.1) takes an offset just
// below zero for one of the buffer.
class SourceProxy final : public oiio::Filesystem::IOProxy {
 public:
  explicit SourceProxy(const ByteSource& source) : IOProxy("", Read), source_(source) {}
  const char* proxytype() const override { return "file"; }
  size_t size() const override { return size_t(source_.size); }
  size_t pread(void* bytes, size_t count, int64_t offset) override {
    return offset < 0 ? 0 : source_.read(uint64_t(offset), count, bytes);
  }
  // In order and on one thread. Readers of HDR ask for single bytes.
  size_t read(void* bytes, size_t count) override {
    size_t got = 0;
    while (got < count) {
      if (m_pos < begin_ || m_pos >= begin_ + int64_t(buffer_.size())) {
        buffer_.resize(kBuffer);
        begin_ = m_pos;
        buffer_.resize(pread(buffer_.data(), kBuffer, begin_));
        if (buffer_.empty()) break;
      }
      const size_t at = size_t(m_pos - begin_), part = std::min(count - got, buffer_.size() - at);
      std::memcpy(static_cast<std::byte*>(bytes) + got, buffer_.data() + at, part);
      got += part;
      m_pos += int64_t(part);
    }
    return got;
  }

 private:
  static constexpr size_t kBuffer = size_t(64) << 10;

  const ByteSource& source_;
  std::vector<std::byte> buffer_;
  int64_t begin_ = 0;
};

class Decoder final : public ImageDecoder {
 public:
  // Empty if all is well.
  std::string open(const std::string& format, const ByteSource& source) {
    proxy_ = std::make_unique<SourceProxy>(source);
    input_ = oiio::ImageInput::create(format);
    if (!input_ || !input_->supports("ioproxy") || !input_->set_ioproxy(proxy_.get())) {
      oiio::geterror();  // or it would greet the next caller
      return "this OpenImageIO cannot read " + format;
    }
    oiio::ImageSpec hints, opened;
    hints["oiio:UnassociatedAlpha"] = 1;
    const std::string error = caught([&] {
      return input_->open("image." + format, opened, hints) ? "" : one_line(input_->geterror());
    });
    if (!error.empty()) return error;
    const oiio::ImageSpec& s = input_->spec();
    layout_ = {.x = s.x,
               .y = s.y,
               .width = s.width,
               .height = s.height,
               .depth = s.depth,
               .full_x = s.full_x,
               .full_y = s.full_y,
               .full_width = s.full_width,
               .full_height = s.full_height,
               .tile_width = std::max(0, s.tile_width),
               .tile_height = std::max(0, s.tile_height),
               .deep = s.deep,
               .channel_names = {s.channelnames.begin(), s.channelnames.end()},
               .channel_types = {},
               .type = sample_type(s.format),
               .type_name = s.format.c_str(),
               .alpha_channel = s.alpha_channel,
               .premultiplied = s.get_int_attribute("oiio:UnassociatedAlpha") == 0,
               .orientation = s.get_int_attribute("Orientation", 1),
               .bytes = uint64_t(s.image_bytes(true)),
               .texts = {}};
    for (const oiio::ParamValue& attribute : s.extra_attribs) {
      const std::string name(attribute.name());
      if (attribute.type() != oiio::TypeDesc::STRING || !name.starts_with("emberline")) continue;
      layout_.texts.emplace_back(name, attribute.get_string());
    }
    layout_.channel_names.resize(size_t(std::max(0, s.nchannels)));
    for (int c = 0; c < s.nchannels; ++c) {
      layout_.channel_types.push_back(sample_type(s.channelformat(c)));
    }
    return "";
  }
  ~Decoder() override {
    if (input_) input_->close();
  }

  const ImageLayout& layout() const override { return layout_; }
  std::string attribute(const char* name) const override {
    return std::string(input_->spec().get_string_attribute(name));
  }
  std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                   size_t row) override {
    return caught([&] { return read_pixels(pixels, first, last, type, out, row); });
  }

 private:
  // An exception's words, but for a lack of memory.
  template <typename Work>
  static std::string caught(const Work& work) {
    try {
      return work();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      return one_line(error.what());
    }
  }

  std::string read_pixels(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                          size_t row) const {
    const oiio::ImageSpec& s = input_->spec();
    const oiio::TypeDesc as = oiio_type(type);
    const int y0 = s.y + pixels.y0, y1 = s.y + pixels.y1;
    const auto stride = oiio::stride_t(row);
    const bool done =
        layout_.tile_width > 0
            ? input_->read_tiles(0, 0, s.x + pixels.x0, s.x + pixels.x1, y0, y1, s.z, s.z + 1,
                                 first, last, as, out, oiio::AutoStride, stride)
            : input_->read_scanlines(0, 0, y0, y1, s.z, first, last, as, out, oiio::AutoStride,
                                     stride);
    return done ? "" : one_line(input_->geterror());
  }

  ImageLayout layout_;
  std::unique_ptr<SourceProxy> proxy_;
  std::unique_ptr<oiio::ImageInput> input_;  // after what it reads, so that it goes first
};

class OpenImageIo final : public ImageLibrary {
 public:
  std::unique_ptr<ImageDecoder> open(const std::string& format, const ByteSource& source,
                                     std::string& error) const override {
    return open_decoder<Decoder>(error, format, source);
  }

  std::string encode_gif(std::span<const ByteImage> pictures, double picture_s,
                         std::vector<unsigned char>& encoded) const override {
    oiio::Filesystem::IOVecOutput sink(encoded);
    const std::unique_ptr<oiio::ImageOutput> output = oiio::ImageOutput::create("gif");
    if (!output) return "OpenImageIO has no gif writer";
    // A picture's duration is kept in hundredths of a second.
    const int rate[2] = {100, std::max(1, int(picture_s * 100 + 0.5))};
    bool done = output->set_ioproxy(&sink);
    for (const ByteImage& picture : pictures) {
      oiio::ImageSpec spec(picture.width, picture.height, 3, oiio::TypeDesc::UINT8);
      spec.attribute("FramesPerSecond", oiio::TypeRational, rate);
      spec.attribute("oiio:Movie", 1);
      const auto mode = &picture == &pictures.front() ? oiio::ImageOutput::Create
                                                      : oiio::ImageOutput::AppendSubimage;
      done = done && output->open("picture.gif", spec, mode) &&
             output->write_image(oiio::TypeDesc::UINT8, picture.values.data());
    }
    return done && output->close() ? "" : one_line(output->geterror());
  }
};

}  // namespace

extern "C" const ImageLibrary* emberline_image_library(const char* version) {
  static const OpenImageIo library;
  return std::string_view(version) == EMBERLINE_VERSION ? &library : nullptr;
}

}  // namespace emberline
