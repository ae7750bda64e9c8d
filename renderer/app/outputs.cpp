#include "renderer/app/outputs.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cctype>
#include <chrono>

#include "renderer/core/errors.h"

namespace emberline {
namespace {

std::string lower_suffix(const std::string& path) {
  const size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] != '.') return "";
  std::string suffix = path.substr(dot);
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return char(std::tolower(c)); });
  return suffix;
}

}  // namespace

void check_output_suffix(const std::string& path) {
  const std::string suffix = lower_suffix(path);
  for (const char* known : {".exr", ".png", ".jpg", ".jpeg"}) {
    if (suffix == known) return;
  }
  throw UsageError("-o " + path + ": unknown format; valid suffixes are .exr, .png, .jpg, .jpeg");
}

FrameOutputs::FrameOutputs(const std::vector<std::string>& paths, const OutputSettings& settings) {
  for (const std::string& path : paths) check_output_suffix(path);
  for (const std::string& path : paths) {
    if (lower_suffix(path) == ".exr") {
      ExrHeader header;
      header.width = settings.width;
      header.height = settings.height;
      header.data_window = settings.window;
      header.tile_size = settings.tile_size;
      for (const FilmChannel& channel : film_channels(settings.aovs)) {
        header.channels.push_back(
            {channel.name, channel.integer ? ChannelType::kUint : ChannelType::kFloat});
      }
      header.attributes = settings.attributes;
      exrs_.push_back(std::make_unique<ExrWriter>(path, header));
    } else {
      if (!transform_) transform_ = std::make_shared<DisplayTransform>(settings.display);
      images_.push_back(std::make_unique<DisplayImageWriter>(
          path, settings.window, transform_, settings.transparent && lower_suffix(path) == ".png"));
    }
  }
}

void FrameOutputs::tile_finished(const FilmTile& tile) {
  const auto start = std::chrono::steady_clock::now();
  thread_local std::vector<float> pixels;  // reused: no allocation per bucket
  if (!exrs_.empty()) {
    tile.resolve(pixels);
    for (const auto& exr : exrs_) exr->write_tile(tile.rect(), pixels);
  }
  if (!images_.empty()) {
    tile.resolve_rgba(pixels);
    for (const auto& image : images_) image->write_tile(tile.rect(), pixels);
  }
  const uint64_t workers = uint64_t(std::max(1, tbb::this_task_arena::max_concurrency()));
  const uint64_t bytes = workers * (tile.bytes() + pixels.capacity() * sizeof(float));
  uint64_t seen = film_bytes_.load();
  while (bytes > seen && !film_bytes_.compare_exchange_weak(seen, bytes)) {
  }
  write_nanoseconds_ += uint64_t(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
}

void FrameOutputs::samples_finished(uint64_t count) {
  if (on_samples_) on_samples_(count);
}

void FrameOutputs::finish() {
  for (const auto& exr : exrs_) exr->finish();
  for (const auto& image : images_) image->finish();
}

std::string FrameOutputs::display_description() const {
  return transform_ ? transform_->describe() : "";
}

}  // namespace emberline
