#include "renderer/output/denoise_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/memory_budget.h"
#include "renderer/core/parallel.h"
#include "renderer/core/readable.h"
#include "renderer/core/rect_values.h"
#include "renderer/engine/render_clock.h"
#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/shared_samples.h"
#include "renderer/reconstruction/denoise.h"
#include "renderer/reconstruction/motion_path.h"

namespace emberline {
namespace {

constexpr int kReadRows = 64;
// Rows per band; a small frame has fewer. Each band also filters the margins around it.
constexpr int kBandRows = 384;
// Bytes that denoise() needs per pixel, including the results, and the bytes that it needs per
// pixel for each light group.
constexpr uint64_t kFilterBytes = 368, kLightGroupBytes = 88;
// Additional bytes per pixel if there are any neighbouring frames. Their number does not matter.
constexpr uint64_t kAcrossBytes = 320, kAcrossLightGroupBytes = 88;
// Rows that are read from a neighbouring frame above and below the filtered rows.
constexpr int kNeighbourRows = kMotionReach + kNeighbourReach;
static_assert(kNeighbourReach >= kVelocityReach);
constexpr std::array kChannels = {"R", "G", "B"};
constexpr std::array kColour = {".R", ".G", ".B"};
constexpr const char* kLightLayer = "light.";
const std::array<std::string, 2> kVelocity = {"velocity.X", "velocity.Y"};
const std::array<std::string, 2> kSpecularVelocity = {"specular_velocity.X", "specular_velocity.Y"};

// A feature, and how much it may differ in a neighbouring frame's pixel that shows the same
// surface.
struct FeatureChannel {
  const char* name;
  float tolerance;
};
constexpr FeatureChannel kFeatures[] = {
    {"N.X", 0.1f}, {"N.Y", 0.1f}, {"N.Z", 0.1f}, {"nearness", 0.01f}};
// This feature is not compared between frames, because it changes with the objects near a surface.
constexpr const char* kUncomparedFeature = "visibility";

using Names = std::span<const std::string>;

bool has(Names channels, const std::string& name) {
  return std::ranges::find(channels, name) != channels.end();
}

// Finds the layers of the light groups, such as "light.key", among the channels of the first half.
// Sorts the layers, because they are summed and their order in the file must not affect the bits.
std::vector<std::string> light_layers(Names channels) {
  const std::string begin = std::string(kHalfNames[0]) + "." + kLightLayer;
  std::vector<std::string> layers;
  for (const std::string& name : channels) {
    if (!name.starts_with(begin) || !name.ends_with(kColour[0])) continue;
    const size_t at = std::string(kHalfNames[0]).size() + 1;
    layers.push_back(name.substr(at, name.size() - at - 2));
  }
  std::ranges::sort(layers);
  return layers;
}

int band_rows(int tile_size) { return (kBandRows + tile_size - 1) / tile_size * tile_size; }
int read_rows(int rows_at_once) {
  return (kReadRows + rows_at_once - 1) / rows_at_once * rows_at_once;
}
int margin_rows(size_t neighbours) {
  return neighbours == 0 ? kDenoiseMargin : kDenoiseMargin + kAcrossMargin;
}
// Returns how many rows a window may hold: a band, `margin` rows above and below it, and the extra
// rows that the last read may add.
int64_t window_rows(const Rect& crop, int tile_size, int rows_at_once, int margin) {
  return std::min(int64_t(crop.height()),
                  int64_t(band_rows(tile_size)) + 2 * margin + rows_at_once);
}

// A sliding window of a frame's rows. Each channel is stored as a plane.
class PlaneWindow {
 public:
  // Reserves memory for a band and `margin` rows around it.
  PlaneWindow(const Rect& crop, const RowSource& source, int tile_size, int margin)
      : crop_(crop),
        source_(source),
        width_(size_t(crop.width())),
        planes_(source.channels.size()) {
    const int64_t rows = window_rows(crop, tile_size, source.rows_at_once, margin);
    for (std::vector<float>& plane : planes_) plane.reserve(size_t(rows) * width_);
  }

  // Moves the window down until it has at least rows [begin, end) of the crop. `buffer` is scratch
  // space for reading.
  void move_to(int begin, int end, std::vector<float>& buffer) {
    drop_above(std::max(0, begin));
    end = std::min(crop_.height(), end);
    while (end_ < end) {
      const int row_count = std::min(end - end_, read_rows(source_.rows_at_once));
      const int parts = (row_count + source_.rows_at_once - 1) / source_.rows_at_once;
      const int to = std::min(crop_.height(), end_ + parts * source_.rows_at_once);
      source_.read({crop_.x0, crop_.y0 + end_, crop_.x1, crop_.y0 + to}, buffer);
      append(buffer, to - end_);
    }
  }

  int begin() const { return begin_; }
  int end() const { return end_; }
  int rows() const { return end_ - begin_; }

  std::span<const float> plane(const std::string& name) const {
    const std::vector<std::string>& names = source_.channels;
    const auto at = std::ranges::find(names, name);
    assert(at != names.end());
    return planes_[size_t(at - names.begin())];
  }
  HalfPlanes halves(const std::string& name) const {
    return {plane(std::string(kHalfNames[0]) + "." + name),
            plane(std::string(kHalfNames[1]) + "." + name)};
  }
  HalfColour colours(const std::string& layer) const {
    return {halves(layer + "R"), halves(layer + "G"), halves(layer + "B")};
  }
  // Writes all channels of a pixel to `pixel` and returns the position after them.
  float* put(size_t i, float* pixel) const {
    for (const std::vector<float>& plane : planes_) *pixel++ = plane[i];
    return pixel;
  }
  size_t index_of(int x, int row) const { return size_t(row - begin_) * width_ + size_t(x); }
  VelocityRows velocity() const {
    VelocityRows rows = {int(width_), crop_.height(), begin_, plane(kVelocity[0]),
                         plane(kVelocity[1])};
    if (has(source_.channels, kSpecularVelocity[0])) {
      rows.specular_right = plane(kSpecularVelocity[0]);
      rows.specular_up = plane(kSpecularVelocity[1]);
    }
    return rows;
  }

 private:
  void append(std::span<const float> pixels, int rows) {
    const size_t before = size_t(this->rows()) * width_, more = size_t(rows) * width_;
    end_ += rows;
    parallel_tasks(planes_.size(), [&](size_t c) {
      std::vector<float>& plane = planes_[c];
      plane.resize(before + more);
      for (size_t i = 0; i < more; ++i) plane[before + i] = pixels[i * planes_.size() + c];
    });
  }
  void drop_above(int row) {
    const auto dropped_count = int64_t(size_t(row - begin_) * width_);
    for (std::vector<float>& plane : planes_)
      plane.erase(plane.begin(), plane.begin() + dropped_count);
    begin_ = row;
  }

  const Rect crop_;
  const RowSource& source_;
  size_t width_;
  std::vector<std::vector<float>> planes_;
  int begin_ = 0, end_ = 0;
};

// `colour_layer` is the prefix of the colour channels. For a neighbouring frame it is "shared.",
// because these are the only colours that are read from it.
DenoiseInput input_of(const PlaneWindow& window, const Rect& crop,
                      std::span<const std::string> layers, const std::string& colour_layer) {
  DenoiseInput input;
  input.width = crop.width();
  input.height = window.rows();
  input.x0 = crop.x0;
  input.y0 = crop.y0 + window.begin();
  input.samples = window.halves("samples");
  input.colour = window.colours(colour_layer);
  input.albedo = window.colours("albedo.");
  for (const auto& [name, tolerance] : kFeatures) {
    input.features.push_back(window.halves(name));
    input.tolerances.push_back(tolerance);
  }
  input.features.push_back(window.halves(kUncomparedFeature));
  input.shared = window.colours("shared.");
  for (const std::string& layer : layers) input.parts.push_back(window.colours(layer + "."));
  return input;
}

class DenoisePass {
 public:
  explicit DenoisePass(const DenoiseJob& job)
      : job_(job),
        layers_(light_layers(job.rows.channels)),
        results_(denoise_results(job.rows.channels).size()),
        height_(job.crop.height()),
        margin_(margin_rows(job.neighbours.size())),
        window_(job.crop, job.rows, job.tile_size, margin_) {
    for (const DenoiseNeighbour& neighbour : job.neighbours) {
      neighbours_.push_back(
          {neighbour.offset, {job.crop, neighbour.rows, job.tile_size, margin_ + kNeighbourRows}});
    }
  }

  DenoiseReport run() {
    const Stopwatch clock;
    const int band = band_rows(job_.tile_size);
    for (int row = 0; row < height_; row += band) pass(row, std::min(height_, row + band));
    const double pixels = double(job_.crop.area());
    return {std::sqrt(before_ / pixels),
            std::sqrt(after_ / pixels),
            double(unchanged_) / pixels,
            clock.seconds(),
            stopped_,
            neighbours_.empty() ? 0.0 : frames_ / pixels};
  }

 private:
  struct Neighbour {
    int offset;
    PlaneWindow window;
  };

  // Filters rows [begin, end), counted from the top of the crop.
  void pass(int begin, int end) {
    const int first = std::max(0, begin - margin_), last = std::min(height_, end + margin_);
    window_.move_to(first, last, read_);
    for (Neighbour& neighbour : neighbours_) {
      neighbour.window.move_to(first - kNeighbourRows, last + kNeighbourRows, read_);
    }
    const std::vector<std::vector<float>> positions = find_positions(first, last);
    std::vector<NeighbourFrame> near;
    for (size_t k = 0; k < neighbours_.size(); ++k) {
      near.push_back({input_of(neighbours_[k].window, job_.crop, layers_, "shared."),
                      positions[2 * k], positions[2 * k + 1]});
    }
    DenoisedPicture picture =
        denoise(input_of(window_, job_.crop, layers_, ""), begin - window_.begin(),
                end - window_.begin(), job_.stop, near);
    if (picture.error.empty()) picture = unfiltered(begin, end);
    before_ += picture.squared_error_before;
    after_ += picture.squared_error_after;
    unchanged_ += picture.unchanged_pixels;
    frames_ += picture.frames;
    copy_unsampled(begin, end, &picture);
    write(picture, begin, end);
  }

  // Follows the motion of the denoised frame's pixels to each neighbouring frame. Returns two
  // planes for each neighbour, with an entry for each pixel in window_: the x and the y to which
  // the pixel moves in the neighbour's window. They are NaN outside rows [first, last).
  std::vector<std::vector<float>> find_positions(int first, int last) const {
    const std::vector<float> unknown(size_t(window_.rows()) * size_t(job_.crop.width()),
                                     std::numeric_limits<float>::quiet_NaN());
    std::vector<std::vector<float>> positions(2 * neighbours_.size(), unknown);
    for (const int direction : {1, -1}) {
      MotionPath path(job_.crop.width(), height_, first, last);
      const PlaneWindow* here = &window_;
      for (size_t k = 0; k < neighbours_.size(); ++k) {
        if (neighbours_[k].offset * direction < 0) continue;
        const PlaneWindow& there = neighbours_[k].window;
        if (direction > 0) {
          path.step_forward(here->velocity());
        } else {
          path.step_back(here->velocity(), there.velocity());
        }
        here = &there;
        const size_t begin = window_.index_of(0, first);
        std::ranges::copy(path.x(), &positions[2 * k][begin]);
        std::ranges::transform(path.y(), &positions[2 * k + 1][begin],
                               [&](float y) { return y - float(there.begin()); });
      }
    }
    return positions;
  }

  // Returns the unfiltered rows [begin, end), for use after a stop request. Their error is unknown
  // and set to its upper bound.
  DenoisedPicture unfiltered(int begin, int end) {
    constexpr float kMaxError = 0.5f;
    stopped_ = true;
    const size_t first = window_.index_of(0, begin), count = window_.index_of(0, end) - first;
    const auto colour_of = [&](const std::string& layer) {
      std::array<std::vector<float>, 3> colour;
      for (size_t c = 0; c < 3; ++c) {
        const std::span<const float> raw =
            window_.plane(layer + kChannels[c]).subspan(first, count);
        colour[c].assign(raw.begin(), raw.end());
      }
      return colour;
    };
    DenoisedPicture picture;
    picture.colour = colour_of("");
    for (const std::string& layer : layers_) picture.parts.push_back(colour_of(layer + "."));
    picture.error.assign(count, kMaxError);
    picture.unchanged_pixels = count;
    picture.squared_error_before = picture.squared_error_after =
        double(kMaxError) * double(kMaxError) * double(count);
    return picture;
  }

  // Gives pixels without samples their undenoised values, which may be filled in from neighbouring
  // pixels.
  void copy_unsampled(int begin, int end, DenoisedPicture* picture) const {
    const HalfPlanes samples = window_.halves("samples");
    const size_t first = window_.index_of(0, begin), count = window_.index_of(0, end) - first;
    const auto copy = [&](const std::string& layer, std::array<std::vector<float>, 3>& colour) {
      for (size_t c = 0; c < 3; ++c) {
        const std::span<const float> shown = window_.plane(layer + kChannels[c]);
        for (size_t i = 0; i < count; ++i) {
          const size_t pixel = first + i;
          if (samples.a[pixel] + samples.b[pixel] == 0.0f) colour[c][i] = shown[pixel];
        }
      }
    };
    copy("", picture->colour);
    for (size_t l = 0; l < layers_.size(); ++l) copy(layers_[l] + ".", picture->parts[l]);
  }

  void write(const DenoisedPicture& picture, int begin, int end) const {
    const Rect& crop = job_.crop;
    const Rect band = {crop.x0, crop.y0 + begin, crop.x1, crop.y0 + end};
    std::vector<Rect> tiles;
    for (int y = band.y0; y < band.y1; y += job_.tile_size) {
      for (int x = band.x0; x < band.x1; x += job_.tile_size) {
        tiles.push_back(Rect{x, y, x + job_.tile_size, y + job_.tile_size}.intersect(band));
      }
    }
    const size_t channels = job_.rows.channels.size() + results_;
    parallel_tasks(tiles.size(), [&](size_t t) {
      const Rect& tile = tiles[t];
      std::vector<float> pixels(channels * size_t(tile.area()));
      for (size_t i = 0; i < size_t(tile.area()); ++i) {
        const int x = tile.x_of(i) - crop.x0, row = tile.y_of(i) - crop.y0;
        float* const results = window_.put(window_.index_of(x, row), &pixels[channels * i]);
        put_results(picture, band.index_of(tile.x_of(i), tile.y_of(i)), results);
      }
      job_.write(tile, pixels);
    });
  }

  void put_results(const DenoisedPicture& picture, size_t i, float* results) const {
    for (const auto& plane : picture.colour) *results++ = plane[i];
    *results++ = picture.error[i];
    for (const auto& part : picture.parts) {
      for (const auto& plane : part) *results++ = plane[i];
    }
  }

  const DenoiseJob& job_;
  const std::vector<std::string> layers_;
  const size_t results_;
  const int height_, margin_;
  PlaneWindow window_;
  std::vector<Neighbour> neighbours_;
  std::vector<float> read_;
  double before_ = 0.0, after_ = 0.0, frames_ = 0.0;
  size_t unchanged_ = 0;
  bool stopped_ = false;
};

}  // namespace

std::string describe(const DenoiseReport& report) {
  if (report.stopped) {
    return fmt::format("denoising was stopped after {}: {} of the pixels are not denoised",
                       readable_seconds(report.seconds),
                       readable_percent(report.unchanged_fraction));
  }
  std::string text =
      fmt::format("denoised in {}: expected error {:.2g} -> {:.2g}, {} of the pixels are unchanged",
                  readable_seconds(report.seconds), report.error_before, report.error_after,
                  readable_percent(report.unchanged_fraction));
  if (report.frames > 0.0) {
    text += fmt::format(", a pixel combines {:.1f} frames on average", report.frames);
  }
  return text;
}

std::vector<std::string> missing_denoise_channels(Names channels) {
  std::vector<std::string> missing;
  const auto need = [&](const std::string& name) {
    if (!has(channels, name)) missing.push_back(name);
  };
  for (const std::string& name : resolved_channel_names(names_of(half_channels()))) need(name);
  for (const std::string& layer : light_layers(channels)) {
    for (const char* c : kColour) {
      for (const char* half : kHalfNames) need(std::string(half) + "." + layer + c);
      need(layer + c);
    }
  }
  for (const char* name : kChannels) need(name);
  return missing;
}

std::vector<std::string> neighbour_channels(Names channels) {
  std::vector<std::string> names(kVelocity.begin(), kVelocity.end());
  if (has(channels, kSpecularVelocity[0])) {
    names.insert(names.end(), kSpecularVelocity.begin(), kSpecularVelocity.end());
  }
  for (const char* half : kHalfNames) {
    const std::string begin = std::string(half) + ".";
    const auto add_colour = [&](const std::string& layer) {
      for (const char* c : kColour) names.push_back(begin + layer + c);
    };
    names.push_back(begin + "samples");
    add_colour("shared");
    add_colour("albedo");
    for (const FeatureChannel& feature : kFeatures) names.push_back(begin + feature.name);
    names.push_back(begin + kUncomparedFeature);
    for (const std::string& layer : light_layers(channels)) add_colour(layer);
  }
  return names;
}

std::vector<std::string> denoise_results(Names channels) {
  std::vector<std::string> results;
  const auto add = [&](const std::string& layer) {
    for (const char* c : kColour) results.push_back(layer + c);
  };
  add("denoised");
  results.push_back("denoised.error");
  for (const std::string& layer : light_layers(channels)) add("denoised." + layer);
  return results;
}

std::vector<float> denoised_rgba(std::span<const float> pixels, Names channels) {
  const size_t stride = channels.size() + denoise_results(channels).size();
  const auto alpha = std::ranges::find(channels, "A");
  std::vector<float> rgba;
  rgba.reserve(4 * (pixels.size() / stride));
  for (size_t i = 0; i < pixels.size(); i += stride) {
    const float* const results = &pixels[i + channels.size()];
    rgba.insert(rgba.end(), results, results + 3);
    rgba.push_back(alpha != channels.end() ? pixels[i + size_t(alpha - channels.begin())] : 1.0f);
  }
  return rgba;
}

uint64_t denoise_bytes(const Rect& crop, int tile_size, Names channels, int rows_at_once,
                       size_t neighbours) {
  const auto width = uint64_t(crop.width());
  const int margin = margin_rows(neighbours);
  const auto rows = uint64_t(window_rows(crop, tile_size, rows_at_once, margin));
  const auto read = uint64_t(std::min(crop.height(), read_rows(rows_at_once) + 2));
  const size_t of_channels = resolved_channel_names(channels).size() * sizeof(float);
  const size_t of_films = channels.size() * sizeof(float);
  const size_t groups = light_layers(channels).size();
  size_t of_filter = kFilterBytes + kLightGroupBytes * groups;
  uint64_t of_neighbours = 0;
  if (neighbours > 0) {
    of_filter += kAcrossBytes + kAcrossLightGroupBytes * groups;
    const auto near_rows =
        uint64_t(window_rows(crop, tile_size, rows_at_once, margin + kNeighbourRows));
    constexpr size_t kPositions = 2;
    const size_t planes = neighbour_channels(channels).size() + kPositions;
    of_neighbours = neighbours * bytes_of(width * near_rows, planes * sizeof(float));
  }
  return bytes_of(width * rows, of_channels + of_filter) +
         bytes_of(width * read, of_channels + of_films) + of_neighbours;
}

DenoiseReport denoise_frame(const DenoiseJob& job) { return DenoisePass(job).run(); }

DenoiseReport denoise_film_rows(DenoiseJob job) {
  ShareResolver rows(job.crop, job.rows.channels, std::move(job.rows.read));
  job.rows.channels = resolved_channel_names(job.rows.channels);
  job.rows.read = [&](const Rect& part, std::vector<float>& pixels) { rows.read(part, pixels); };
  return denoise_frame(job);
}

DenoiseReport denoise_film(const Rect& crop, int tile_size, Names channels,
                           std::span<const float> values,
                           std::function<void(const Rect&, const std::vector<float>&)> write,
                           const std::stop_token& stop) {
  const auto read = [&](const Rect& part, std::vector<float>& pixels) {
    pixels = extract_rect(values, crop, part);
  };
  return denoise_film_rows({.crop = crop,
                            .rows = {.channels = {channels.begin(), channels.end()}, .read = read},
                            .tile_size = tile_size,
                            .write = std::move(write),
                            .stop = stop});
}

void finish_film(const Rect& crop, int tile_size, bool denoises, std::vector<std::string>& channels,
                 std::vector<float>& values, const std::stop_token& stop) {
  if (!denoises) return resolve_shares(crop, channels, values);
  std::vector<std::string> names = resolved_channel_names(channels);
  const std::vector<std::string> results = denoise_results(names);
  names.insert(names.end(), results.begin(), results.end());
  std::vector<float> denoised(size_t(crop.area()) * names.size());
  const auto write = [&](const Rect& tile, const std::vector<float>& pixels) {
    put_rect(pixels, tile, crop, denoised);
  };
  denoise_film(crop, tile_size, channels, values, write, stop);
  channels = std::move(names);
  values = std::move(denoised);
}

void PixelSpool::write_tile(const Rect& tile, const std::vector<float>& pixels) {
  const size_t row = size_t(tile.width()) * channels_;
  for (int y = tile.y0; y < tile.y1; ++y) {
    file_.write_at(&pixels[size_t(y - tile.y0) * row], row * sizeof(float), offset_of(tile.x0, y));
  }
}

void PixelSpool::read_rows(const Rect& rows, std::vector<float>& pixels) const {
  assert(rows.x0 == crop_.x0 && rows.x1 == crop_.x1);
  pixels.resize(size_t(rows.area()) * channels_);
  file_.read_at(pixels.data(), pixels.size() * sizeof(float), offset_of(rows.x0, rows.y0));
}

}  // namespace emberline
