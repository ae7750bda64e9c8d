// Uses OpenEXR's C interface (OpenEXRCore, since 3.1): its encoder shares no state between threads,
// so the render threads compress tiles in parallel. The C++ TiledOutputFile compresses under its
// own lock, about 1 ms per 64x64 tile of five float channels, which does not scale.
#include "io/exr/writer.h"

#include <Imath/half.h>
#include <OpenEXR/openexr.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <system_error>

#include "io/exr/dwa.h"
#include "io/files/atomic_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/rect_values.h"

namespace emberline {
namespace {

// The zlib level that OpenEXR's own writers have used since 3.1.3. Level 6, the C interface's
// default, makes files about 1 % smaller and takes 50 % longer.
constexpr int kZipLevel = 4;

// Longer names need a flag that OpenEXR before 1.7 does not know.
constexpr size_t kShortNameLength = 31;

constexpr NamedValue<ExrCompression> kCompressions[] = {
    {"none", "no compression", ExrCompression::kNone},
    {"zips", "lossless; same as zip for tiles", ExrCompression::kZips},
    {"zip", "lossless", ExrCompression::kZip},
    {"piz", "lossless; smaller for noisy images", ExrCompression::kPiz},
    {"dwaa", "lossy for colours, in blocks of 32 rows; much smaller", ExrCompression::kDwaa},
    {"dwab", "lossy for colours, in blocks of 256 rows; much smaller", ExrCompression::kDwab},
};
constexpr exr_compression_t kExrCompressions[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_ZIPS,
                                                  EXR_COMPRESSION_ZIP,  EXR_COMPRESSION_PIZ,
                                                  EXR_COMPRESSION_DWAA, EXR_COMPRESSION_DWAB};

constexpr NamedValue<ExrParts> kParts[] = {
    {"one", "a single part with all channels, which every program can read", ExrParts::kOne},
    {"layers", "one part per layer; a single layer is faster to read", ExrParts::kLayers},
};

// The message of the last OpenEXR error in this thread. OpenEXR passes it only to a callback.
thread_local std::string last_error_message;

void store_error_message(exr_const_context_t, exr_result_t, const char* message) {
  last_error_message = message ? message : "";
}

exr_pixel_type_t pixel_type(ChannelType type) {
  return type == ChannelType::kUint   ? EXR_PIXEL_UINT
         : type == ChannelType::kHalf ? EXR_PIXEL_HALF
                                      : EXR_PIXEL_FLOAT;
}
size_t value_bytes(ChannelType type) { return type == ChannelType::kHalf ? 2 : 4; }

uint32_t rounded_uint(float value) {
  if (!(value > 0.0f)) return 0;  // also for NaN
  return value >= 4294967040.0f ? 0xffffffffu : uint32_t(std::floor(double(value) + 0.5));
}

uint16_t half_bits(float value) {
  constexpr float kMaxFinite = 65504.0f;
  return Imath::half(std::clamp(value, -kMaxFinite, kMaxFinite)).bits();
}

// Converts one channel of interleaved floats to a plane of file values.
void convert_channel(const float* pixels, size_t count, size_t stride, ChannelType type,
                     uint8_t* plane) {
  const auto put = [&](const auto& bits_of) {
    for (size_t i = 0; i < count; ++i) {
      const auto bits = bits_of(pixels[i * stride]);
      std::memcpy(plane + sizeof bits * i, &bits, sizeof bits);
    }
  };
  switch (type) {
    case ChannelType::kUint:
      return put(rounded_uint);
    case ChannelType::kHalf:
      return put(half_bits);
    case ChannelType::kFloat:
      return put([](float value) { return std::bit_cast<uint32_t>(value); });
  }
}

bool has_colour_suffix(const std::string& channel) {
  return channel.ends_with(".R") || channel.ends_with(".G") || channel.ends_with(".B") ||
         channel.ends_with(".A") || layer_of(channel) == "RGBA";
}

// Whether lossy compression treats the channel as a colour (by its suffix) or as a luminance (Y).
bool is_treated_as_colour(const std::string& channel) {
  return has_colour_suffix(channel) || channel.ends_with(".Y");
}

}  // namespace

std::span<const NamedValue<ExrCompression>> exr_compression_table() { return kCompressions; }
std::span<const NamedValue<ExrParts>> exr_parts_table() { return kParts; }

std::string layer_of(const std::string& channel) {
  const size_t stop = channel.rfind('.');
  if (stop != std::string::npos) return channel.substr(0, stop);
  return channel == "R" || channel == "G" || channel == "B" || channel == "A" ? "RGBA" : channel;
}

bool is_colour(const std::string& channel) {
  const std::string layer = layer_of(channel);
  return has_colour_suffix(channel) && !layer.starts_with("Crypto") && !layer.starts_with("half") &&
         layer != "variance";
}

struct ExrWriter::Impl {
  struct Part {
    std::string name;
    std::vector<const PictureChannel*> channels;  // pointers into `header`
    ExrCompression compression = ExrCompression::kZip;
    std::vector<uint64_t> tiles;      // file offsets, row-major; 0: not written
    exr_context_t encoder = nullptr;  // for an imaginary file with only this part
  };

  Impl(const std::string& path, const ExrHeader& frame_header) : header(frame_header), file(path) {
    const Rect& data_window = header.data_window;
    assert(!data_window.empty() && header.tile_size > 0 && !header.channels.empty());
    tiles_x = (data_window.width() + header.tile_size - 1) / header.tile_size;
    tiles_y = (data_window.height() + header.tile_size - 1) / header.tile_size;
    written.assign(size_t(tiles_x) * size_t(tiles_y), false);
    make_parts();
  }

  ~Impl() {
    for (Part& part : parts) {
      if (part.encoder) exr_finish(&part.encoder);
    }
  }

  // OpenEXR calls this with the header's bytes. Collects the bytes in the string `user`, or
  // discards them if `user` is null. This class itself writes the rest of the file.
  static int64_t write_bytes(exr_const_context_t, void* user, const void* bytes, uint64_t count,
                             uint64_t offset, exr_stream_error_func_ptr_t) {
    if (!user) return int64_t(count);
    std::string& text = *static_cast<std::string*>(user);
    text.resize(std::max(text.size(), size_t(offset + count)));
    std::memcpy(text.data() + offset, bytes, count);
    return int64_t(count);
  }

  // The last step of encoding a tile: stores the compressed pixels only if they are shorter than
  // the raw ones. If both have the same length, OpenEXR (3.1) would store the compressed pixels,
  // but readers take a chunk of the raw length for raw pixels.
  static exr_result_t store_chunk(exr_encode_pipeline_t* pipeline) {
    const bool shorter = pipeline->compressed_bytes < pipeline->packed_bytes;
    const auto* bytes = static_cast<const uint8_t*>(shorter ? pipeline->compressed_buffer
                                                            : pipeline->packed_buffer);
    static_cast<std::vector<uint8_t>*>(pipeline->encoding_user_data)
        ->assign(bytes, bytes + (shorter ? pipeline->compressed_bytes : pipeline->packed_bytes));
    return EXR_ERR_SUCCESS;
  }

  // Records the first failure and throws it. Must not be called under the lock.
  [[noreturn]] void fail(const std::string& why) {
    const std::lock_guard lock(mutex);
    if (failure.empty()) failure = "cannot write " + file.path() + ": " + why;
    throw RenderError(failure);
  }

  void check(exr_result_t result) {
    if (result == EXR_ERR_SUCCESS) return;
    fail(last_error_message.empty() ? exr_get_default_error_message(result) : last_error_message);
  }

  void throw_if_failed() {
    const std::lock_guard lock(mutex);
    if (!failure.empty()) throw RenderError(failure);
  }

  // Writes at the offset. On failure, throws what fail() throws.
  void write_at(const void* bytes, size_t count, uint64_t offset) {
    const int error = file.try_write_at(bytes, count, offset);
    if (error != 0) fail(std::generic_category().message(error));
  }

  void make_parts();
  void write_header();
  exr_context_t begin_context(std::string* bytes);
  void add_part(exr_context_t context, const Part& part, int index);
  void add_view(exr_context_t context, int part);
  std::vector<uint8_t> encode(int part, int tile_x, int tile_y, const Rect& rect,
                              const float* pixels);
  std::vector<uint8_t> encode_lossless(int part, int tile_x, int tile_y, const Rect& rect,
                                       const std::vector<const uint8_t*>& planes);
  // Reserves space for the chunk in the file and appends the chunk to `bytes`.
  uint64_t put_chunk(int part, int tile_x, int tile_y, const std::vector<uint8_t>& chunk,
                     std::vector<uint8_t>& bytes);
  void append(int part, int tile_x, int tile_y, const std::vector<uint8_t>& chunk);

  Rect tile_rect(int tile_x, int tile_y) const {
    const int x0 = header.data_window.x0 + tile_x * header.tile_size;
    const int y0 = header.data_window.y0 + tile_y * header.tile_size;
    return Rect{x0, y0, x0 + header.tile_size, y0 + header.tile_size}.intersect(header.data_window);
  }

  // Writes zeros for all tiles that were never written.
  void fill_missing_tiles();
  void write_offset_tables();

  const ExrHeader header;
  std::vector<Part> parts;
  int tiles_x = 0, tiles_y = 0;
  AtomicFile file;
  std::string header_bytes;  // as written to the file

  std::mutex mutex;           // guards the members below and the parts' tiles and encoders
  uint64_t end = 0;           // current length of the file
  std::string failure;        // message of the first failure
  std::vector<bool> written;  // per tile, row-major
};

void ExrWriter::Impl::make_parts() {
  for (const PictureChannel& channel : header.channels) {
    const std::string name = header.parts == ExrParts::kOne ? "" : layer_of(channel.name);
    auto part = std::ranges::find(parts, name, &Part::name);
    if (part == parts.end()) part = parts.insert(parts.end(), Part{name, {}, {}, {}});
    part->channels.push_back(&channel);
  }
  for (Part& part : parts) {
    const bool only_colours = std::ranges::all_of(part.channels, [](const PictureChannel* channel) {
      return is_colour(channel->name) || !is_treated_as_colour(channel->name);
    });
    part.compression =
        is_lossy(header.compression) && !only_colours ? ExrCompression::kZip : header.compression;
    part.tiles.resize(written.size());
  }
}

exr_context_t ExrWriter::Impl::begin_context(std::string* bytes) {
  exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
  settings.error_handler_fn = store_error_message;
  settings.write_fn = write_bytes;
  settings.user_data = bytes;
  exr_context_t context = nullptr;
  check(exr_start_write(&context, file.path().c_str(), EXR_WRITE_FILE_DIRECTLY, &settings));
  const auto is_long = [](const auto& name) { return name.size() > kShortNameLength; };
  const auto first = [](const auto& attribute) -> const std::string& { return attribute.first; };
  if (std::ranges::any_of(header.channels, is_long, &PictureChannel::name) ||
      std::ranges::any_of(header.attributes, is_long, first)) {
    check(exr_set_longname_support(context, 1));
  }
  return context;
}

void ExrWriter::Impl::write_header() {
  struct Context {
    exr_context_t context;
    ~Context() { exr_finish(&context); }
  } whole{begin_context(&header_bytes)};
  for (size_t i = 0; i < parts.size(); ++i) add_part(whole.context, parts[i], int(i));
  check(exr_write_header(whole.context));
  // The C interface (3.1) encodes parts only in order, so each part gets its own encoder.
  for (Part& part : parts) {
    part.encoder = begin_context(nullptr);
    add_part(part.encoder, part, 0);
    check(exr_write_header(part.encoder));
  }
  write_at(header_bytes.data(), header_bytes.size(), 0);
  end = header_bytes.size() + parts.size() * written.size() * sizeof(uint64_t);
}

void ExrWriter::Impl::add_part(exr_context_t context, const Part& layout, int part) {
  int added = 0;
  check(exr_add_part(context, layout.name.empty() ? nullptr : layout.name.c_str(),
                     EXR_STORAGE_TILED, &added));
  const Rect& data = header.data_window;
  const exr_attr_box2i_t display_window = {{0, 0}, {header.width - 1, header.height - 1}};
  const exr_attr_box2i_t data_window = {{data.x0, data.y0}, {data.x1 - 1, data.y1 - 1}};
  const exr_attr_v2f_t window_centre = {0.0f, 0.0f};
  check(exr_initialize_required_attr(context, part, &display_window, &data_window, 1.0f,
                                     &window_centre, 1.0f, EXR_LINEORDER_RANDOM_Y,
                                     kExrCompressions[size_t(layout.compression)]));
  check(exr_set_zip_compression_level(context, part, kZipLevel));
  check(exr_set_tile_descriptor(context, part, uint32_t(header.tile_size),
                                uint32_t(header.tile_size), EXR_TILE_ONE_LEVEL,
                                EXR_TILE_ROUND_DOWN));
  for (const PictureChannel* channel : layout.channels) {
    // The perceptual hint matters only for B44. OpenEXR's own writers use this value by default.
    check(exr_add_channel(context, part, channel->name.c_str(), pixel_type(channel->type),
                          EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  }
  const Chromaticities xy = chromaticities_of(header.view.space);
  const exr_attr_chromaticities_t primaries = {xy[0], xy[1], xy[2], xy[3],
                                               xy[4], xy[5], xy[6], xy[7]};
  check(exr_attr_set_chromaticities(context, part, "chromaticities", &primaries));
  add_view(context, part);
  // Readers of multi-part files look for these attributes in the first part.
  for (const auto& [name, value] : header.attributes) {
    if (part == 0) check(exr_attr_set_string(context, part, name.c_str(), value.c_str()));
  }
}

void ExrWriter::Impl::add_view(exr_context_t context, int part) {
  const ExrView& view = header.view;
  const auto matrix = [&](const char* name, const std::array<float, 16>& values) {
    exr_attr_m44f_t m;
    std::ranges::copy(values, m.m);
    check(exr_attr_set_m44f(context, part, name, &m));
  };
  if (view.camera) {
    matrix("worldToCamera", view.camera->world_to_camera);
    matrix("worldToNDC", view.camera->world_to_ndc);
  }
  if (view.frames_per_second) {
    const exr_attr_rational_t rate = {view.frames_per_second->first,
                                      view.frames_per_second->second};
    check(exr_attr_set_rational(context, part, "framesPerSecond", &rate));
  }
  if (view.time_code) {
    const exr_attr_timecode_t code = {*view.time_code, 0};
    check(exr_attr_set_timecode(context, part, "timeCode", &code));
  }
}

std::vector<uint8_t> ExrWriter::Impl::encode(int part, int tile_x, int tile_y, const Rect& rect,
                                             const float* pixels) {
  // Converts the pixels to file values, plane by plane.
  const Part& layout = parts[size_t(part)];
  const size_t count = size_t(rect.area()), stride = header.channels.size();
  std::vector<uint8_t> values(layout.channels.size() * count * sizeof(float));
  std::vector<const uint8_t*> planes;
  uint8_t* next = values.data();
  for (const PictureChannel* channel : layout.channels) {
    convert_channel(pixels + (channel - header.channels.data()), count, stride, channel->type,
                    next);
    planes.push_back(next);
    next += count * value_bytes(channel->type);
  }
  if (!is_lossy(layout.compression)) return encode_lossless(part, tile_x, tile_y, rect, planes);

  std::vector<EncodedPlane> encoded;
  for (size_t i = 0; i < planes.size(); ++i) {
    encoded.push_back({layout.channels[i]->name, layout.channels[i]->type, planes[i]});
  }
  std::vector<uint8_t> chunk;
  try {
    encode_dwa_tile(rect.width(), rect.height(), encoded,
                    layout.compression == ExrCompression::kDwab, chunk);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    fail(error.what());
  }
  return chunk;
}

std::vector<uint8_t> ExrWriter::Impl::encode_lossless(int part, int tile_x, int tile_y,
                                                      const Rect& rect,
                                                      const std::vector<const uint8_t*>& planes) {
  const exr_context_t context = parts[size_t(part)].encoder;
  exr_chunk_info_t chunk = {};
  const exr_result_t located = [&] {
    const std::lock_guard lock(mutex);
    return exr_write_tile_chunk_info(context, 0, tile_x, tile_y, 0, 0, &chunk);
  }();
  check(located);

  struct Pipeline : exr_encode_pipeline_t {
    explicit Pipeline(exr_const_context_t c) : exr_encode_pipeline_t{}, owner(c) {}
    ~Pipeline() { exr_encoding_destroy(owner, this); }
    exr_const_context_t owner;
  } pipeline(context);
  check(exr_encoding_initialize(context, 0, &chunk, &pipeline));
  const std::vector<const PictureChannel*>& channels = parts[size_t(part)].channels;
  for (int i = 0; i < pipeline.channel_count; ++i) {
    // OpenEXR sorts channels alphabetically, so the matching channel is found by its name.
    exr_coding_channel_info_t& target = pipeline.channels[i];
    const auto source =
        std::ranges::find(channels, std::string(target.channel_name), &PictureChannel::name);
    assert(source != channels.end());
    const ChannelType type = (*source)->type;
    target.user_bytes_per_element = int16_t(value_bytes(type));
    target.user_data_type = uint16_t(pixel_type(type));
    target.user_pixel_stride = int32_t(value_bytes(type));
    target.user_line_stride = int32_t(value_bytes(type)) * rect.width();
    target.encode_from_ptr = planes[size_t(source - channels.begin())];
  }
  check(exr_encoding_choose_default_routines(context, 0, &pipeline));
  std::vector<uint8_t> bytes;
  pipeline.encoding_user_data = &bytes;
  pipeline.write_fn = store_chunk;
  check(exr_encoding_run(context, 0, &pipeline));
  return bytes;
}

// Appends the chunk's header and data (OpenEXR, "File Layout"). OpenEXR's C interface cannot be
// used, because it would write one part after another. The header has the part number (multi-part
// files only), the tile's coordinates and level, and the data's size. Reserves the chunk's place in
// the file and returns its offset.
uint64_t ExrWriter::Impl::put_chunk(int part, int tile_x, int tile_y,
                                    const std::vector<uint8_t>& chunk,
                                    std::vector<uint8_t>& bytes) {
  static_assert(std::endian::native == std::endian::little);
  const std::array<int32_t, 6> start = {part, tile_x, tile_y, 0, 0, int32_t(chunk.size())};
  const size_t omitted_words = parts.size() == 1 ? 1 : 0, words = start.size() - omitted_words;
  const auto* const first = reinterpret_cast<const uint8_t*>(&start[omitted_words]);
  const size_t size = words * sizeof(int32_t) + chunk.size();
  bytes.insert(bytes.end(), first, first + words * sizeof(int32_t));
  bytes.insert(bytes.end(), chunk.begin(), chunk.end());
  const std::lock_guard lock(mutex);
  const uint64_t at = end;
  end += size;
  parts[size_t(part)].tiles[size_t(tile_y) * size_t(tiles_x) + size_t(tile_x)] = at;
  return at;
}

void ExrWriter::Impl::append(int part, int tile_x, int tile_y, const std::vector<uint8_t>& chunk) {
  std::vector<uint8_t> bytes;
  bytes.reserve(6 * sizeof(int32_t) + chunk.size());
  const uint64_t at = put_chunk(part, tile_x, tile_y, chunk, bytes);
  write_at(bytes.data(), bytes.size(), at);
}

void ExrWriter::Impl::fill_missing_tiles() {
  // A render that is cancelled early can leave tens of thousands of empty tiles, or millions if
  // they are tiny. Empty tiles of the same size have identical bytes. So each of up to four sizes
  // (inner, right edge, lower edge, corner) is compressed once, and many tiles are written at a
  // time.
  constexpr size_t kBlock = size_t(1) << 20;
  std::vector<uint8_t> block;
  const auto write_block = [&] {
    if (block.empty()) return;
    write_at(block.data(), block.size(), end - block.size());
    block.clear();
  };
  for (int part = 0; part < int(parts.size()); ++part) {
    std::map<std::pair<int, int>, std::vector<uint8_t>> compressed;
    for (int y = 0; y < tiles_y; ++y) {
      for (int x = 0; x < tiles_x; ++x) {
        if (written[size_t(y) * size_t(tiles_x) + size_t(x)]) continue;
        const Rect rect = tile_rect(x, y);
        std::vector<uint8_t>& chunk = compressed[{rect.width(), rect.height()}];
        if (chunk.empty()) {
          const std::vector<float> zeros(size_t(rect.area()) * header.channels.size(), 0.0f);
          chunk = encode(part, x, y, rect, zeros.data());
        }
        put_chunk(part, x, y, chunk, block);
        if (block.size() >= kBlock) write_block();
      }
    }
  }
  write_block();
}

// Writes the offsets of the tiles, part after part.
void ExrWriter::Impl::write_offset_tables() {
  uint64_t at = header_bytes.size();
  for (const Part& part : parts) {
    const size_t bytes = part.tiles.size() * sizeof(uint64_t);
    write_at(part.tiles.data(), bytes, at);
    at += bytes;
  }
}

ExrWriter::ExrWriter(const std::string& path, const ExrHeader& header)
    : impl_(std::make_unique<Impl>(path, header)) {
  impl_->write_header();
}

ExrWriter::~ExrWriter() = default;

void ExrWriter::write_tile(const Rect& rect, const std::vector<float>& pixels) {
  Impl& self = *impl_;
  const int tile_x = (rect.x0 - self.header.data_window.x0) / self.header.tile_size;
  const int tile_y = (rect.y0 - self.header.data_window.y0) / self.header.tile_size;
  assert(rect == self.tile_rect(tile_x, tile_y) && "not one whole tile");
  assert(pixels.size() == size_t(rect.area()) * self.header.channels.size());
  self.throw_if_failed();
  {
    const std::lock_guard lock(self.mutex);
    const size_t index = size_t(tile_y) * size_t(self.tiles_x) + size_t(tile_x);
    assert(!self.written[index] && "a tile is written once");
    self.written[index] = true;
  }
  for (int part = 0; part < int(self.parts.size()); ++part) {
    self.append(part, tile_x, tile_y, self.encode(part, tile_x, tile_y, rect, pixels.data()));
  }
}

void ExrWriter::write(std::span<const float> pixels) {
  assert(pixels.size() == size_t(impl_->header.data_window.area()) * impl_->header.channels.size());
  for (int y = 0; y < impl_->tiles_y; ++y) {
    for (int x = 0; x < impl_->tiles_x; ++x) {
      const Rect rect = impl_->tile_rect(x, y);
      write_tile(rect, extract_rect(pixels, impl_->header.data_window, rect));
    }
  }
}

void ExrWriter::set_attribute(const std::string& name, const std::string& value) {
  Impl& self = *impl_;
  // An attribute is stored as its name, its type, the length of its value (four bytes,
  // little-endian) and its value; name and type end with a zero byte (OpenEXR, "File Layout"). Our
  // values have no zero bytes, so `begin` occurs only once.
  const std::string begin = name + '\0' + "string" + '\0';
  const size_t at = self.header_bytes.find(begin);
  assert(at != std::string::npos && "an attribute of the header");
  size_t length = 0;
  for (size_t i = 4; i-- > 0;) {
    length = length << 8 | static_cast<unsigned char>(self.header_bytes[at + begin.size() + i]);
  }
  assert(value.size() <= length);
  std::string padded = value;
  padded.resize(length, ' ');
  self.file.write_at(padded.data(), length, at + begin.size() + 4);
}

void ExrWriter::finish() {
  Impl& self = *impl_;
  self.throw_if_failed();
  self.fill_missing_tiles();
  self.write_offset_tables();
  self.file.commit();
}

std::optional<uint32_t> smpte_time_code(int64_t frame, double fps) {
  constexpr int64_t kMaxRate = 40, kDay = 24 * 60 * 60;
  const double rounded = std::ceil(fps);
  if (!(rounded >= 1.0) || rounded > double(kMaxRate)) return std::nullopt;
  const auto rate = int64_t(rounded);
  if (frame < 0 || frame >= kDay * rate) return std::nullopt;
  const int64_t seconds = frame / rate;
  // Each field has two binary-coded decimal digits. The lowest byte has the frames. All flag bits
  // are 0.
  uint32_t code = 0;
  int shift = 0;
  for (const int64_t field : {frame % rate, seconds % 60, seconds / 60 % 60, seconds / 3600}) {
    code |= uint32_t(field / 10 << 4 | field % 10) << shift;
    shift += 8;
  }
  return code;
}

std::pair<int32_t, uint32_t> frame_rate_fraction(double fps) {
  const double whole = std::round(fps);
  if (fps == whole && whole <= 1e6) return {int32_t(whole), 1};
  // Television rates are 1000/1001 times a whole number.
  const double faster = std::round(fps * 1.001);
  if (std::abs(faster / 1.001 - fps) < 1e-3) return {int32_t(faster * 1000), 1001};
  return {int32_t(std::round(std::min(fps, 1e6) * 1000)), 1000};
}

void write_exr_file(const std::string& path, const ExrHeader& header,
                    std::span<const float> pixels) {
  ExrWriter writer(path, header);
  writer.write(pixels);
  writer.finish();
}

}  // namespace emberline
