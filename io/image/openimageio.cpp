// The image library: wraps OpenImageIO in our interface. It is a separate library, so it may use
// only headers of the program.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>
#include <utility>

#include "io/exr/dwa.h"
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
    for (const oiio::ParamValue& attribute : s.extra_attribs) {
      const std::string name(attribute.name());
      const bool ours = name.starts_with("emberline") || name.starts_with("cryptomatte/");
      if (attribute.type() != oiio::TypeDesc::STRING || !ours) continue;
      // get_string() truncates long text.
      layout_.text_attributes.emplace_back(name,
                                           *static_cast<const char* const*>(attribute.data()));
    }
    layout_.view = view_of(s);
    constexpr oiio::TypeDesc kChromaticities(oiio::TypeDesc::FLOAT, 8);
    if (const auto* primaries = s.find_attribute("chromaticities", kChromaticities)) {
      std::memcpy(layout_.chromaticities.emplace().data(), primaries->data(),
                  sizeof(Chromaticities));
    }
    layout_.channel_names.resize(size_t(std::max(0, s.nchannels)));
    for (int c = 0; c < s.nchannels; ++c) {
      layout_.channel_types.push_back(sample_type(s.channelformat(c)));
    }
    parts_ = {{s, 0, 0}};
    return format == "openexr" ? catch_errors([&] { return join_parts(); }) : "";
  }
  ~Decoder() override {
    if (input_) input_->close();
  }

  std::string attribute(const char* name) const override {
    return std::string(parts_.front().spec.get_string_attribute(name));
  }
  std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                   size_t row) override {
    return catch_errors([&] { return read_pixels(pixels, first, last, type, out, row); });
  }

 private:
  // A part of an EXR, or the whole image.
  struct Part {
    oiio::ImageSpec spec;
    int subimage = 0;
    int first = 0;  // index of the part's first channel among the image's channels
  };

  static ImagePart image_part(const oiio::ImageSpec& s, int first) {
    return {std::string(s.get_string_attribute("oiio:subimagename")),
            {s.channelnames.begin(), s.channelnames.end()},
            first,
            s.get_string_attribute("textureformat") == "CubeFace Environment"};
  }

  // Joins a later part with the first part if it has the same windows and tiles and none of its
  // channel names occurs twice.
  std::string join_parts() {
    constexpr int kMaxParts = 4096;
    const oiio::ImageSpec first = parts_.front().spec;  // a copy, since `parts_` may reallocate
    layout_.parts = {image_part(first, 0)};
    for (int i = 1; i < kMaxParts && input_->seek_subimage(i, 0); ++i) {
      const oiio::ImageSpec s = input_->spec();
      const auto place = [](const oiio::ImageSpec& spec) {
        return std::array{spec.x,          spec.y,           spec.width,      spec.height,
                          spec.full_x,     spec.full_y,      spec.full_width, spec.full_height,
                          spec.tile_width, spec.tile_height, spec.depth,      int(spec.deep)};
      };
      const bool matches_first =
          place(s) == place(first) && s.nchannels > 0 &&
          std::ranges::none_of(s.channelnames, [&](const std::string& name) {
            return std::ranges::find(layout_.channel_names, name) != layout_.channel_names.end();
          });
      const bool is_read = matches_first && parts_.back().first + s.nchannels <= kMaxChannels;
      layout_.parts.push_back(image_part(s, is_read ? layout_.channels() : -1));
      if (!is_read) continue;
      parts_.push_back({s, i, layout_.channels()});
      layout_.bytes += uint64_t(s.image_bytes(true));
      for (int c = 0; c < s.nchannels; ++c) {
        layout_.channel_names.push_back(s.channelnames[size_t(c)]);
        layout_.channel_types.push_back(sample_type(s.channelformat(c)));
      }
    }
    input_->geterror();  // discards the error of seeking past the last part
    return input_->seek_subimage(0, 0) ? "" : library_message(input_->geterror());
  }

  static ExrView view_of(const oiio::ImageSpec& s) {
    ExrView view;
    const auto* to_camera = s.find_attribute("worldToCamera", oiio::TypeMatrix);
    const auto* to_ndc = s.find_attribute("worldToNDC", oiio::TypeMatrix);
    if (to_camera && to_ndc) {
      ExrView::Matrices& camera = view.camera.emplace();
      std::memcpy(camera.world_to_camera.data(), to_camera->data(), sizeof camera.world_to_camera);
      std::memcpy(camera.world_to_ndc.data(), to_ndc->data(), sizeof camera.world_to_ndc);
    }
    if (const auto* rate = s.find_attribute("framesPerSecond", oiio::TypeRational)) {
      const auto* const parts = static_cast<const int*>(rate->data());
      view.frames_per_second = {parts[0], uint32_t(parts[1])};
    }
    if (const auto* code = s.find_attribute("smpte:TimeCode", oiio::TypeTimeCode)) {
      view.time_code = *static_cast<const uint32_t*>(code->data());
    }
    return view;
  }

  std::string read_pixels(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                          size_t row) const {
    const oiio::TypeDesc target_type = oiio_type(type);
    const auto stride = oiio::stride_t(row),
               pixel = oiio::stride_t(size_t(last - first) * target_type.size());
    for (const Part& part : parts_) {
      const oiio::ImageSpec& s = part.spec;
      const int begin = std::max(first, part.first);
      const int end = std::min(last, part.first + s.nchannels);
      if (begin >= end) continue;
      std::byte* const to = out + size_t(begin - first) * target_type.size();
      const int y0 = s.y + pixels.y0, y1 = s.y + pixels.y1;
      const bool done =
          layout_.tile_width > 0
              ? input_->read_tiles(part.subimage, 0, s.x + pixels.x0, s.x + pixels.x1, y0, y1, s.z,
                                   s.z + 1, begin - part.first, end - part.first, target_type, to,
                                   pixel, stride)
              : input_->read_scanlines(part.subimage, 0, y0, y1, s.z, begin - part.first,
                                       end - part.first, target_type, to, pixel, stride);
      if (!done) return library_message(input_->geterror());
    }
    return "";
  }

  static constexpr int kMaxChannels = 4096;  // the limit in image/input.cpp

  std::vector<Part> parts_;
  std::unique_ptr<SourceProxy> proxy_;
  std::unique_ptr<oiio::ImageInput> input_;  // after the proxy, so that it is destroyed first
};

class OpenImageIo final : public ImageLibrary {
 public:
  std::unique_ptr<ImageDecoder> open(const std::string& format, const ByteSource& source,
                                     std::string& error) const override {
    return open_decoder<Decoder>(error, format, source);
  }

  std::string encode_dwa(int width, int height, std::span<const EncodedPlane> planes, bool wide,
                         std::vector<uint8_t>& code) const override {
    return catch_errors([&] {
      encode_dwa_tile(width, height, planes, wide, code);
      return "";
    });
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
