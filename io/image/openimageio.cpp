// The image library: wraps OpenImageIO in our interface. It is a separate library, so it may use
// only headers of the program.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include "io/image/library.h"

namespace emberline {
namespace {

namespace oiio = OIIO;

// Returns OpenImageIO's message as one line.
std::string library_message(std::string text) {
  for (char& c : text) {
    if (uint8_t(c) < 0x20) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.empty() ? "unknown reason" : text.substr(0, 200);
}

// Runs `work` and turns exceptions, except bad_alloc, into an error string.
template <typename Work>
std::string catch_errors(const Work& work) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return library_message(error.what());
  }
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

// Reads the source without making a copy. OpenImageIO's own memory proxy (2.4, 3.1) would accept an
// offset just below zero.
class SourceProxy final : public oiio::Filesystem::IOProxy {
 public:
  explicit SourceProxy(const ByteSource& source)
      : IOProxy("", Read), source_(source), cursor_(source) {}
  const char* proxytype() const override { return "file"; }
  size_t size() const override { return size_t(source_.size); }
  size_t pread(void* bytes, size_t count, int64_t offset) override {
    return offset < 0 ? 0 : source_.read(uint64_t(offset), count, bytes);
  }
  // OpenImageIO calls this in order, on one thread.
  size_t read(void* bytes, size_t count) override {
    cursor_.seek(uint64_t(m_pos));
    const size_t got = cursor_.take(bytes, count);
    m_pos += int64_t(got);
    return got;
  }

 private:
  const ByteSource& source_;
  ByteCursor cursor_;
};

class Decoder final : public ImageDecoder {
 public:
  // Returns an empty string or the error.
  std::string open(const std::string& format, const ByteSource& source) {
    proxy_ = std::make_unique<SourceProxy>(source);
    input_ = oiio::ImageInput::create(format);
    if (!input_ || !input_->supports("ioproxy") || !input_->set_ioproxy(proxy_.get())) {
      oiio::geterror();  // clears the error, which the next caller would otherwise get
      return "this build of OpenImageIO cannot read " + format;
    }
    oiio::ImageSpec hints, opened;
    hints["oiio:UnassociatedAlpha"] = 1;
    const std::string error = catch_errors([&] {
      return input_->open("image." + format, opened, hints) ? ""
                                                            : library_message(input_->geterror());
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
               .type = sample_type(s.format),
               .type_name = s.format.c_str(),
               .alpha_channel = s.alpha_channel,
               .premultiplied = s.get_int_attribute("oiio:UnassociatedAlpha") == 0,
               .orientation = s.get_int_attribute("Orientation", 1),
               .bytes = uint64_t(s.image_bytes(true))};
    layout_.channel_names.resize(size_t(std::max(0, s.nchannels)));
    for (int c = 0; c < s.nchannels; ++c) {
      layout_.channel_types.push_back(sample_type(s.channelformat(c)));
    }
    return "";
  }
  ~Decoder() override {
    if (input_) input_->close();
  }

  std::string attribute(const char* name) const override {
    return std::string(input_->spec().get_string_attribute(name));
  }
  std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                   size_t row) override {
    return catch_errors([&] { return read_pixels(pixels, first, last, type, out, row); });
  }

 private:
  std::string read_pixels(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                          size_t row) const {
    const oiio::ImageSpec& s = input_->spec();
    const oiio::TypeDesc target_type = oiio_type(type);
    const auto stride = oiio::stride_t(row),
               pixel = oiio::stride_t(size_t(last - first) * target_type.size());
    const int y0 = s.y + pixels.y0, y1 = s.y + pixels.y1;
    const bool done =
        layout_.tile_width > 0
            ? input_->read_tiles(0, 0, s.x + pixels.x0, s.x + pixels.x1, y0, y1, s.z, s.z + 1,
                                 first, last, target_type, out, pixel, stride)
            : input_->read_scanlines(0, 0, y0, y1, s.z, first, last, target_type, out, pixel,
                                     stride);
    return done ? "" : library_message(input_->geterror());
  }

  std::unique_ptr<SourceProxy> proxy_;
  std::unique_ptr<oiio::ImageInput> input_;  // after the proxy, so that it is destroyed first
};

class OpenImageIo final : public ImageLibrary {
 public:
  std::unique_ptr<ImageDecoder> open(const std::string& format, const ByteSource& source,
                                     std::string& error) const override {
    return open_decoder<Decoder>(error, format, source);
  }

  std::string encode_gif(std::span<const ByteImage> pictures, double frame_s,
                         std::vector<unsigned char>& encoded) const override {
    oiio::Filesystem::IOVecOutput sink(encoded);
    const std::unique_ptr<oiio::ImageOutput> output = oiio::ImageOutput::create("gif");
    if (!output) return "OpenImageIO has no gif writer";
    // GIF durations are in hundredths of a second.
    const int rate[2] = {100, std::max(1, int(frame_s * 100 + 0.5))};
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
    return done && output->close() ? "" : library_message(output->geterror());
  }
};

}  // namespace

extern "C" const ImageLibrary* emberline_image_library(const char* version) {
  static const OpenImageIo library;
  return std::string_view(version) == EMBERLINE_VERSION ? &library : nullptr;
}

}  // namespace emberline
