#include "io/exr/decoder.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfEnvmapAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTiledInputPart.h>
#include <OpenEXR/ImfTimeCodeAttribute.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <stdexcept>
#include <string_view>
#include <tuple>
#include <utility>

#include "io/image/input.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Returns OpenEXR's message as one line, without the stream's name and the text before it.
std::string exr_message(std::string_view text) {
  constexpr std::string_view kStream = "\"image\". ";
  if (const size_t stream = text.find(kStream); stream != std::string_view::npos)
    text.remove_prefix(stream + kStream.size());
  std::string line(text.substr(0, 200));
  std::ranges::replace_if(
      line, [](char c) { return uint8_t(c) < 0x20; }, ' ');
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return line.empty() ? "unknown reason" : line;
}

// Runs `work` and turns exceptions, except bad_alloc, into an error string. OpenEXR wraps some
// bad_allocs in exceptions of its own.
template <typename Work>
std::string catch_exr_errors(const Work& work) {
  try {
    work();
    return "";
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    const std::string_view text = error.what();
    for (const char* part : {"bad_alloc", "Failed to allocate memory"}) {
      if (text.find(part) != std::string_view::npos) throw std::bad_alloc();
    }
    return exr_message(text);
  }
}

class SourceStream final : public Imf::IStream {
 public:
  explicit SourceStream(const ByteSource& source) : IStream("image"), cursor_(source) {}
  bool read(char bytes[], int count) override {
    if (count < 0 || cursor_.take(bytes, size_t(count)) < size_t(count))
      throw std::runtime_error("the file is truncated");
    return !cursor_.at_end();
  }
  uint64_t tellg() override { return cursor_.offset(); }
  void seekg(uint64_t offset) override { cursor_.seek(offset); }
  void clear() override {}

 private:
  ByteCursor cursor_;
};

SampleType sample_type(Imf::PixelType type) {
  return type == Imf::HALF   ? SampleType::kHalf
         : type == Imf::UINT ? SampleType::kUint32
                             : SampleType::kFloat;
}

// Splits "albedo.R" into "albedo." and "R".
std::pair<std::string, std::string> split_name(const std::string& name) {
  const size_t leaf = name.rfind('.') + 1;  // 0 if there is no layer
  return {name.substr(0, leaf), name.substr(leaf)};
}

// Returns the names sorted by layer. Within a layer, colours come first in the order red, green,
// blue, alpha, and coordinates in the order X, Y, Z. A Z without X is a depth, which comes after
// alpha.
std::vector<std::string> sorted_names(const Imf::ChannelList& channels) {
  constexpr std::array<std::string_view, 13> kFirst = {
      "r", "red", "g", "green", "b", "blue", "x", "y", "z", "a", "alpha", "depth", "zback"};
  std::vector<std::string> names;
  std::set<std::string> with_x;  // layers
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const auto& [layer, leaf] = split_name(names.emplace_back(c.name()));
    if (leaf == "X" || leaf == "x") with_x.insert(layer);
  }
  std::ranges::sort(names, {}, [&](const std::string& name) {
    const auto [layer, leaf] = split_name(name);
    std::string known = lower_case(leaf);
    if (known == "z" && !with_x.contains(layer)) known = "depth";
    return std::tuple(layer, std::ranges::find(kFirst, known) - kFirst.begin(), leaf);
  });
  return names;
}

template <typename Attribute>
const auto* find_value(const Imf::Header& header, const char* name) {
  const auto* const found = header.findTypedAttribute<Attribute>(name);
  return found ? &found->value() : nullptr;
}

ExrView view_of(const Imf::Header& header) {
  ExrView view;
  const auto* const to_camera = find_value<Imf::M44fAttribute>(header, "worldToCamera");
  const auto* const to_ndc = find_value<Imf::M44fAttribute>(header, "worldToNDC");
  if (to_camera && to_ndc) {
    ExrView::Matrices& camera = view.camera.emplace();
    std::copy_n(to_camera->getValue(), 16, camera.world_to_camera.begin());
    std::copy_n(to_ndc->getValue(), 16, camera.world_to_ndc.begin());
  }
  if (const auto* const rate = find_value<Imf::RationalAttribute>(header, "framesPerSecond"))
    view.frames_per_second = {rate->n, rate->d};
  if (const auto* const code = find_value<Imf::TimeCodeAttribute>(header, "timeCode"))
    view.time_code = code->timeAndFlags();
  return view;
}

// The placement of a part's pixels. Parts with equal placement can be joined.
ImageLayout placement_of(const Imf::Header& header) {
  const Imath::Box2i &data = header.dataWindow(), &full = header.displayWindow();
  const auto side = [](int min, int max) { return int(int64_t(max) - min + 1); };
  ImageLayout layout;
  layout.x = data.min.x;
  layout.y = data.min.y;
  layout.width = side(data.min.x, data.max.x);
  layout.height = side(data.min.y, data.max.y);
  layout.depth = 1;
  layout.full_x = full.min.x;
  layout.full_y = full.min.y;
  layout.full_width = side(full.min.x, full.max.x);
  layout.full_height = side(full.min.y, full.max.y);
  if (header.hasType() && Imf::isTiled(header.type()) && header.hasTileDescription()) {
    layout.tile_width = int(header.tileDescription().xSize);
    layout.tile_height = int(header.tileDescription().ySize);
  }
  layout.deep = header.hasType() && Imf::isDeepData(header.type());
  return layout;
}

bool is_same_placement(const ImageLayout& a, const ImageLayout& b) {
  const auto values = [](const ImageLayout& s) {
    return std::array{s.x,          s.y,           s.width,      s.height,
                      s.full_x,     s.full_y,      s.full_width, s.full_height,
                      s.tile_width, s.tile_height, int(s.deep)};
  };
  return values(a) == values(b);
}

// The name of a channel that does not have one value per pixel, or an empty string.
std::string subsampled_channel(const Imf::ChannelList& channels) {
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    if (c.channel().xSampling != 1 || c.channel().ySampling != 1) return c.name();
  }
  return "";
}

// OpenEXR's state for one thread.
struct OpenFile {
  explicit OpenFile(const ByteSource& source) : stream(source), file(stream, 0) {}

  SourceStream stream;
  Imf::MultiPartInputFile file;
  std::map<int, Imf::InputPart> rows;
  std::map<int, Imf::TiledInputPart> tiles;
};

class ExrDecoder final : public ImageDecoder {
 public:
  // Returns an empty string or the error.
  std::string open(const ByteSource& source, int rows_per_block, int threads) {
    source_ = &source;
    threads_ = threads;
    return catch_exr_errors([&] { read_headers(rows_per_block); });
  }
  std::string attribute(const char* name) const override {
    const auto found = std::ranges::find(layout_.text_attributes, name,
                                         &std::pair<std::string, std::string>::first);
    return found == layout_.text_attributes.end() ? "" : found->second;
  }
  std::string read(const Rect& pixels, int first, int last, SampleType type, std::byte* out,
                   size_t row) override;

 private:
  // A part whose channels are read.
  struct Part {
    int number = 0;
    int first = 0, end = 0;  // range of its channels in the image
    Imf::ChannelList channels;
  };
  // The first block of a part that cannot be read.
  struct Failure {
    size_t part = SIZE_MAX, block = 0;
    std::string error;
    auto operator<=>(const Failure&) const = default;
  };
  // A call of read().
  struct Request {
    Rect pixels;
    int first, last;  // channels of the image
    Imf::PixelType type;
    std::byte* out;  // address of channel `first` of the upper left pixel
    size_t row;
  };

  void read_headers(int rows_per_block);
  void add_part(int number, const Imf::Header& header);
  Failure read_blocks(OpenFile& file, size_t begin, size_t end, const Request& request) const;
  void read_block(OpenFile& file, int part, const Rect& block) const;
  Imf::FrameBuffer frame_buffer(const Part& part, const Request& request) const;
  int block_width() const { return layout_.tile_width > 0 ? layout_.tile_width : layout_.width; }
  int block_height() const {
    return layout_.tile_height > 0 ? layout_.tile_height : layout_.rows_per_block;
  }
  std::unique_ptr<OpenFile> take_file();

  static constexpr int kMaxParts = 4096;

  const ByteSource* source_ = nullptr;
  int threads_ = 1;
  std::vector<Part> parts_;
  std::set<std::string> names_;  // the channels of parts_
  std::mutex mutex_;
  std::vector<std::unique_ptr<OpenFile>> idle_;  // guarded by mutex_
};

void ExrDecoder::read_headers(int rows_per_block) {
  idle_.push_back(std::make_unique<OpenFile>(*source_));
  const Imf::MultiPartInputFile& file = idle_.front()->file;
  const Imf::Header& header = file.header(0);
  layout_ = placement_of(header);
  layout_.premultiplied = true;
  layout_.rows_per_block = rows_per_block;
  for (auto a = header.begin(); a != header.end(); ++a) {
    const std::string name = a.name();
    const auto* const text = dynamic_cast<const Imf::StringAttribute*>(&a.attribute());
    if (text && (name.starts_with("emberline") || name.starts_with("cryptomatte/")))
      layout_.text_attributes.emplace_back(name, text->value().c_str());
  }
  layout_.view = view_of(header);
  if (const auto* const c = find_value<Imf::ChromaticitiesAttribute>(header, "chromaticities")) {
    layout_.chromaticities = {c->red.x,  c->red.y,  c->green.x, c->green.y,
                              c->blue.x, c->blue.y, c->white.x, c->white.y};
  }
  if (const std::string name = subsampled_channel(header.channels()); !name.empty())
    throw std::runtime_error("the channel " + name + " is subsampled, which is not supported");
  for (int i = 0; i < std::min(file.parts(), kMaxParts); ++i) add_part(i, file.header(i));
  const auto is = [&](SampleType type) {
    return std::ranges::all_of(layout_.channel_types, [&](SampleType t) { return t == type; });
  };
  layout_.type = is(SampleType::kHalf)     ? SampleType::kHalf
                 : is(SampleType::kUint32) ? SampleType::kUint32
                                           : SampleType::kFloat;
  layout_.type_name = is(SampleType::kHalf) ? "half" : is(SampleType::kUint32) ? "uint" : "float";
}

// Adds the part's channels to the image if the part has the same placement as the first part, and
// if none of its channels has the name of an earlier channel.
void ExrDecoder::add_part(int number, const Imf::Header& header) {
  const Imf::ChannelList& channels = header.channels();
  const std::vector<std::string> names = sorted_names(channels);
  const int first = layout_.channels(), end = first + int(names.size());
  const bool is_read =
      number == 0 ||
      (!names.empty() && end <= kMaxChannels && Imf::isSupportedType(header.type()) &&
       is_same_placement(placement_of(header), layout_) && subsampled_channel(channels).empty() &&
       std::ranges::none_of(names, [&](const auto& name) { return names_.contains(name); }));
  const auto* const envmap = find_value<Imf::EnvmapAttribute>(header, "envmap");
  layout_.parts.push_back({header.hasName() ? header.name() : "", names, is_read ? first : -1,
                           envmap && *envmap == Imf::ENVMAP_CUBE});
  if (!is_read) return;
  parts_.push_back({number, first, end, channels});
  names_.insert(names.begin(), names.end());
  for (const std::string& name : names) {
    layout_.channel_names.push_back(name);
    layout_.channel_types.push_back(sample_type(channels[name].type));
  }
}

// Reads the blocks of rows, or the tiles, in parallel. OpenEXR's own threads are not used, because
// our limit on threads does not cover them.
std::string ExrDecoder::read(const Rect& pixels, int first, int last, SampleType type,
                             std::byte* out, size_t row) {
  const Request request = {pixels, first, last, type == SampleType::kHalf ? Imf::HALF : Imf::FLOAT,
                           out,    row};
  const int width = block_width(), height = block_height();
  // OpenEXR always fills whole tiles and whole rows of the frame buffer.
  const auto is_cut = [](int at, int step, int end) { return at % step != 0 && at != end; };
  if (pixels.x0 % width != 0 || is_cut(pixels.x1, width, layout_.width) ||
      (layout_.tile_height > 0 &&
       (pixels.y0 % height != 0 || is_cut(pixels.y1, height, layout_.height)))) {
    return "only whole tiles can be read";
  }
  const auto across = size_t((pixels.x1 + width - 1) / width - pixels.x0 / width);
  const auto down = size_t((pixels.y1 + height - 1) / height - pixels.y0 / height);
  const size_t blocks = across * down, tasks = std::min(blocks, size_t(threads_));
  std::vector<Failure> failures(tasks);
  parallel_tasks(tasks, [&](size_t task) {
    const size_t begin = blocks * task / tasks, end = blocks * (task + 1) / tasks;
    std::string error = catch_exr_errors([&] {
      std::unique_ptr<OpenFile> file = take_file();
      failures[task] = read_blocks(*file, begin, end, request);
      if (!failures[task].error.empty()) return;  // `file` is not reused: its position is unknown
      const std::lock_guard lock(mutex_);
      idle_.push_back(std::move(file));
    });
    if (!error.empty()) failures[task] = {0, begin, std::move(error)};
  });
  return std::ranges::min(failures).error;
}

std::unique_ptr<OpenFile> ExrDecoder::take_file() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      std::unique_ptr<OpenFile> file = std::move(idle_.back());
      idle_.pop_back();
      return file;
    }
  }
  auto file = std::make_unique<OpenFile>(*source_);
  // The file may have changed since its header was checked.
  for (const Part& part : parts_) {
    if (part.number >= file->file.parts() ||
        !is_same_placement(placement_of(file->file.header(part.number)), layout_) ||
        !(file->file.header(part.number).channels() == part.channels)) {
      throw std::runtime_error("the file changed while it was being read");
    }
  }
  return file;
}

// Reads blocks [begin, end) of each part. Stops at the first failure, and returns it.
ExrDecoder::Failure ExrDecoder::read_blocks(OpenFile& file, size_t begin, size_t end,
                                            const Request& request) const {
  const int width = block_width(), height = block_height();
  const int x0 = request.pixels.x0 / width, y0 = request.pixels.y0 / height;
  const auto across = size_t((request.pixels.x1 + width - 1) / width - x0);
  for (size_t p = 0; p < parts_.size(); ++p) {
    const Part& part = parts_[p];
    if (part.first >= request.last || part.end <= request.first) continue;
    size_t i = begin;
    std::string error = catch_exr_errors([&] {
      const Imf::FrameBuffer buffer = frame_buffer(part, request);
      if (layout_.tile_width > 0) {
        file.tiles.try_emplace(part.number, file.file, part.number)
            .first->second.setFrameBuffer(buffer);
      } else {
        file.rows.try_emplace(part.number, file.file, part.number)
            .first->second.setFrameBuffer(buffer);
      }
      for (; i < end; ++i) {
        const int x = (x0 + int(i % across)) * width, y = (y0 + int(i / across)) * height;
        read_block(file, part.number, Rect{x, y, x + width, y + height}.intersect(request.pixels));
      }
    });
    if (!error.empty()) return {p, i, std::move(error)};
  }
  return {};
}

// Reads a tile, or rows of at most one block, into the frame buffer that was set.
void ExrDecoder::read_block(OpenFile& file, int part, const Rect& block) const {
  if (layout_.tile_width > 0) {
    file.tiles.at(part).readTile(block.x0 / layout_.tile_width, block.y0 / layout_.tile_height);
  } else {
    file.rows.at(part).readPixels(layout_.y + block.y0, layout_.y + block.y1 - 1);
  }
}

// OpenEXR addresses pixels by their coordinates in the file, so the buffer's origin is usually
// outside the allocated memory.
Imf::FrameBuffer ExrDecoder::frame_buffer(const Part& part, const Request& request) const {
  const size_t value = request.type == Imf::HALF ? 2 : 4;
  const size_t pixel = size_t(request.last - request.first) * value;
  const auto corner = reinterpret_cast<uintptr_t>(request.out) -
                      uintptr_t(int64_t(layout_.x) + request.pixels.x0) * pixel -
                      uintptr_t(int64_t(layout_.y) + request.pixels.y0) * request.row;
  Imf::FrameBuffer buffer;
  for (int c = std::max(part.first, request.first); c < std::min(part.end, request.last); ++c) {
    auto* const base = reinterpret_cast<char*>(corner + size_t(c - request.first) * value);
    buffer.insert(layout_.channel_names[size_t(c)],
                  Imf::Slice(request.type, base, pixel, request.row));
  }
  return buffer;
}

}  // namespace

std::unique_ptr<ImageDecoder> open_exr(const ByteSource& source, const ImageHeader& header,
                                       int threads, std::string& error) {
  return open_decoder<ExrDecoder>(error, source, header.rows_per_block, threads);
}

}  // namespace emberline
