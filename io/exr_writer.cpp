// Written through OpenEXR's C interface (OpenEXRCore, since 3.1): its encoder keeps no state
// between threads, so tiles are compressed in parallel by the threads that rendered them. The C++
// TiledOutputFile compresses under its own lock, about 1 ms for a 64x64 tile of five float
// channels, which would hold up a machine with many cores.
#include "io/exr_writer.h"

#include <OpenEXR/openexr.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>
#include <system_error>

#include "io/atomic_file.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

constexpr int kPart = 0;  // single-part files
// Names longer than this need a flag in the file that OpenEXR before 1.7 does not know.
constexpr size_t kShortNameLength = 31;

// ITU-R BT.709-6, section 1: primaries and the D65 white.
constexpr exr_attr_chromaticities_t kRec709 = {0.64f, 0.33f, 0.30f,   0.60f,
                                               0.15f, 0.06f, 0.3127f, 0.3290f};

// What OpenEXR says about the last error of this thread; it hands it to a callback only.
thread_local std::string last_message;

void keep_message(exr_const_context_t, exr_result_t, const char* message) {
  last_message = message ? message : "";
}

exr_pixel_type_t pixel_type(ChannelType type) {
  return type == ChannelType::kUint ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
}

constexpr int kValueBytes = 4;  // of either type

uint32_t rounded_uint(float value) {
  if (!(value > 0.0f)) return 0;  // NaN too
  return value >= 4294967040.0f ? 0xffffffffu : uint32_t(std::floor(double(value) + 0.5));
}

// One channel of interleaved floats as a plane of file values.
void convert_channel(const float* pixels, size_t count, size_t stride, ChannelType type,
                     uint8_t* plane) {
  for (size_t i = 0; i < count; ++i) {
    const float value = pixels[i * stride];
    const uint32_t bits =
        type == ChannelType::kUint ? rounded_uint(value) : std::bit_cast<uint32_t>(value);
    std::memcpy(plane + kValueBytes * i, &bits, kValueBytes);
  }
}

}  // namespace

struct ExrWriter::Impl {
  Impl(const std::string& path, const ExrHeader& frame_header) : header(frame_header), file(path) {
    const Rect& data_window = header.data_window;
    assert(!data_window.empty() && header.tile_size > 0 && !header.channels.empty());
    tiles_x = (data_window.width() + header.tile_size - 1) / header.tile_size;
    tiles_y = (data_window.height() + header.tile_size - 1) / header.tile_size;
    written.assign(size_t(tiles_x) * size_t(tiles_y), false);
  }

  ~Impl() {
    if (context) exr_finish(&context);
  }

  // Called by OpenEXR with the bytes of the file.
  static int64_t write_bytes(exr_const_context_t, void* user, const void* bytes, uint64_t count,
                             uint64_t offset, exr_stream_error_func_ptr_t) {
    Impl* self = static_cast<Impl*>(user);
    if (!self->header_written) {
      std::string& text = self->header_bytes;
      text.resize(std::max(text.size(), size_t(offset + count)));
      std::memcpy(text.data() + offset, bytes, count);
    }
    const int error = self->file.try_write_at(bytes, count, offset);
    if (error == 0) return int64_t(count);
    if (self->write_error == 0) self->write_error = error;
    return -1;
  }

  // The last step of encoding a tile; only this one is serial.
  static exr_result_t append_chunk(exr_encode_pipeline_t* pipeline) {
    Impl* self = static_cast<Impl*>(pipeline->encoding_user_data);
    const std::lock_guard lock(self->mutex);
    if (self->keep_chunk) {
      const auto* bytes = static_cast<const uint8_t*>(pipeline->compressed_buffer);
      self->kept_chunk.assign(bytes, bytes + pipeline->compressed_bytes);
    }
    return exr_write_tile_chunk(self->context, kPart, pipeline->chunk.start_x,
                                pipeline->chunk.start_y, 0, 0, pipeline->compressed_buffer,
                                pipeline->compressed_bytes);
  }

  // Remembers the first failure and throws it. Never called under the lock.
  void check(exr_result_t result) {
    if (result == EXR_ERR_SUCCESS) return;
    const std::lock_guard lock(mutex);
    if (failure.empty()) {
      failure = "cannot write " + file.path() + ": ";
      if (write_error != 0) {
        failure += std::generic_category().message(write_error);
      } else {
        failure += last_message.empty() ? exr_get_default_error_message(result) : last_message;
      }
    }
    throw RenderError(failure);
  }

  void throw_if_failed() {
    const std::lock_guard lock(mutex);
    if (!failure.empty()) throw RenderError(failure);
  }

  void write_header();
  void write_view();
  void encode_tile(int tile_x, int tile_y, const Rect& rect, const float* pixels);

  Rect tile_rect(int tile_x, int tile_y) const {
    const int x0 = header.data_window.x0 + tile_x * header.tile_size;
    const int y0 = header.data_window.y0 + tile_y * header.tile_size;
    return Rect{x0, y0, x0 + header.tile_size, y0 + header.tile_size}.intersect(header.data_window);
  }

  // Tiles never written, as zeros.
  void fill_missing_tiles();

  const ExrHeader header;
  int tiles_x = 0, tiles_y = 0;
  AtomicFile file;
  exr_context_t context = nullptr;
  bool header_written = false;
  std::string header_bytes;  // as they are in the file

  std::mutex mutex;           // guards what follows and the writing calls on `context`
  int write_error = 0;        // errno of the first failed write
  std::string failure;        // message of the first failure
  std::vector<bool> written;  // per tile, row-major
  bool keep_chunk = false;    // the next tile's compressed bytes are to go into:
  std::vector<uint8_t> kept_chunk;
};

void ExrWriter::Impl::write_header() {
  exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
  settings.error_handler_fn = keep_message;
  settings.write_fn = write_bytes;
  settings.user_data = this;
  check(exr_start_write(&context, file.path().c_str(), EXR_WRITE_FILE_DIRECTLY, &settings));

  const auto is_long = [](const auto& name) { return name.size() > kShortNameLength; };
  const auto first = [](const auto& attribute) -> const std::string& { return attribute.first; };
  if (std::ranges::any_of(header.channels, is_long, &ExrChannel::name) ||
      std::ranges::any_of(header.attributes, is_long, first)) {
    check(exr_set_longname_support(context, 1));
  }

  int part = 0;
  check(exr_add_part(context, nullptr, EXR_STORAGE_TILED, &part));
  const Rect& data = header.data_window;
  const exr_attr_box2i_t display_window = {{0, 0}, {header.width - 1, header.height - 1}};
  const exr_attr_box2i_t data_window = {{data.x0, data.y0}, {data.x1 - 1, data.y1 - 1}};
  const exr_attr_v2f_t window_centre = {0.0f, 0.0f};
  check(exr_initialize_required_attr(context, kPart, &display_window, &data_window, 1.0f,
                                     &window_centre, 1.0f, EXR_LINEORDER_RANDOM_Y,
                                     EXR_COMPRESSION_ZIP));
  check(exr_set_tile_descriptor(context, kPart, uint32_t(header.tile_size),
                                uint32_t(header.tile_size), EXR_TILE_ONE_LEVEL,
                                EXR_TILE_ROUND_DOWN));
  for (const ExrChannel& channel : header.channels) {
    // The perceptual hint serves B44 compression only; this is the default of OpenEXR's own
    // writers.
    check(exr_add_channel(context, kPart, channel.name.c_str(), pixel_type(channel.type),
                          EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
  }
  check(exr_attr_set_chromaticities(context, kPart, "chromaticities", &kRec709));
  write_view();
  for (const auto& [name, value] : header.attributes) {
    check(exr_attr_set_string(context, kPart, name.c_str(), value.c_str()));
  }
  check(exr_write_header(context));
  header_written = true;
}

void ExrWriter::Impl::write_view() {
  const ExrView& view = header.view;
  const auto matrix = [&](const char* name, const std::array<float, 16>& values) {
    exr_attr_m44f_t m;
    std::ranges::copy(values, m.m);
    check(exr_attr_set_m44f(context, kPart, name, &m));
  };
  if (view.camera) {
    matrix("worldToCamera", view.camera->world_to_camera);
    matrix("worldToNDC", view.camera->world_to_ndc);
  }
  if (view.frames_per_second) {
    const exr_attr_rational_t rate = {view.frames_per_second->first,
                                      view.frames_per_second->second};
    check(exr_attr_set_rational(context, kPart, "framesPerSecond", &rate));
  }
  if (view.time_code) {
    const exr_attr_timecode_t code = {*view.time_code, 0};
    check(exr_attr_set_timecode(context, kPart, "timeCode", &code));
  }
}

void ExrWriter::Impl::encode_tile(int tile_x, int tile_y, const Rect& rect, const float* pixels) {
  // File values, one plane behind the other in header order.
  const size_t count = size_t(rect.area());
  const size_t channels = header.channels.size(), plane_bytes = count * kValueBytes;
  std::vector<uint8_t> planes(channels * plane_bytes);
  for (size_t c = 0; c < channels; ++c) {
    convert_channel(pixels + c, count, channels, header.channels[c].type,
                    planes.data() + c * plane_bytes);
  }

  exr_chunk_info_t chunk = {};
  const exr_result_t located = [&] {
    const std::lock_guard lock(mutex);
    return exr_write_tile_chunk_info(context, kPart, tile_x, tile_y, 0, 0, &chunk);
  }();
  check(located);

  struct Pipeline : exr_encode_pipeline_t {
    explicit Pipeline(exr_const_context_t c) : exr_encode_pipeline_t{}, owner(c) {}
    ~Pipeline() { exr_encoding_destroy(owner, this); }
    exr_const_context_t owner;
  } pipeline(context);
  check(exr_encoding_initialize(context, kPart, &chunk, &pipeline));
  for (int i = 0; i < pipeline.channel_count; ++i) {
    // OpenEXR keeps channels in alphabetical order; ours are found by name.
    exr_coding_channel_info_t& target = pipeline.channels[i];
    const auto source =
        std::ranges::find(header.channels, std::string(target.channel_name), &ExrChannel::name);
    assert(source != header.channels.end());
    target.user_bytes_per_element = kValueBytes;
    target.user_data_type = uint16_t(pixel_type(source->type));
    target.user_pixel_stride = kValueBytes;
    target.user_line_stride = kValueBytes * rect.width();
    target.encode_from_ptr = planes.data() + size_t(source - header.channels.begin()) * plane_bytes;
  }
  check(exr_encoding_choose_default_routines(context, kPart, &pipeline));
  pipeline.encoding_user_data = this;
  pipeline.write_fn = append_chunk;
  check(exr_encoding_run(context, kPart, &pipeline));
}

void ExrWriter::Impl::fill_missing_tiles() {
  // Ctrl-C early in a 16384 x 16384 frame leaves 65,000 tiles: compressed one by one they took
  // 19 s. Equal in size they are equal in bytes, so each of the at most four sizes (inner, right
  // edge, lower edge, corner) is compressed once.
  std::map<std::pair<int, int>, std::vector<uint8_t>> compressed;
  for (int y = 0; y < tiles_y; ++y) {
    for (int x = 0; x < tiles_x; ++x) {
      if (written[size_t(y) * size_t(tiles_x) + size_t(x)]) continue;
      const Rect rect = tile_rect(x, y);
      std::vector<uint8_t>& chunk = compressed[{rect.width(), rect.height()}];
      if (chunk.empty()) {
        const std::vector<float> zeros(size_t(rect.area()) * header.channels.size(), 0.0f);
        keep_chunk = true;
        encode_tile(x, y, rect, zeros.data());
        keep_chunk = false;
        chunk = kept_chunk;
      } else {
        check(exr_write_tile_chunk(context, kPart, x, y, 0, 0, chunk.data(), chunk.size()));
      }
    }
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
  self.encode_tile(tile_x, tile_y, rect, pixels.data());
}

void ExrWriter::write(std::span<const float> pixels) {
  const Rect& data_window = impl_->header.data_window;
  const size_t channels = impl_->header.channels.size();
  std::vector<float> tile;
  for (int y = 0; y < impl_->tiles_y; ++y) {
    for (int x = 0; x < impl_->tiles_x; ++x) {
      const Rect rect = impl_->tile_rect(x, y);
      tile.clear();
      for (int row = rect.y0; row < rect.y1; ++row) {
        const std::span<const float> line = pixels.subspan(
            data_window.index_of(rect.x0, row) * channels, size_t(rect.width()) * channels);
        tile.insert(tile.end(), line.begin(), line.end());
      }
      write_tile(rect, tile);
    }
  }
}

void ExrWriter::set_attribute(const std::string& name, const std::string& value) {
  Impl& self = *impl_;
  // In the file an attribute is its name, its type, the length of its value (four bytes, the lowest
  // first) and its value, name and type ended by a zero byte (OpenEXR, "File Layout"). No value of
  // ours has a zero byte, so the sequence occurs once.
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
  // With the last tile OpenEXR has put the table of tile offsets into the file.
  self.check(exr_finish(&self.context));
  if (self.write_error != 0) self.check(EXR_ERR_WRITE_IO);
  self.file.commit();
}

std::optional<uint32_t> smpte_time_code(int64_t frame, double fps) {
  constexpr int64_t kMostRate = 40, kDay = 24 * 60 * 60;
  const double rounded = std::ceil(fps);
  if (!(rounded >= 1.0) || rounded > double(kMostRate)) return std::nullopt;
  const auto rate = int64_t(rounded);
  if (frame < 0 || frame >= kDay * rate) return std::nullopt;
  const int64_t seconds = frame / rate;
  // Two binary-coded digits of each field, frames in the lowest byte; the flags between stay 0.
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
  // Television's: a thousandth slower than a whole number.
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
