#include "renderer/app/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "io/exr/writer.h"
#include "io/files/register.h"
#include "io/files/write_attempts.h"
#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/half_layers.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/denoise_pass.h"
#include "renderer/output/outputs.h"
#include "renderer/output/rgb_file.h"

namespace emberline {
namespace {

// Reads the frame's channels, except the results of an earlier denoising.
class InputRows {
 public:
  InputRows(const std::string& path, const LoadProgress& progress) : file_(path, progress) {
    const std::vector<std::string>& names = file_.image().channel_names;
    for (size_t c = 0; c < names.size(); ++c) {
      if (names[c].starts_with("denoised.")) continue;
      channel_indices_.push_back(c);
      channels_.push_back(names[c]);
    }
  }

  const FloatImageRows& file() const { return file_; }
  const std::vector<std::string>& channels() const { return channels_; }

  // Sets the storage options (parts, compression, half floats) to those that the frame's header
  // names.
  static void restore_storage(ExrHeader& header) {
    std::vector<std::string> half;
    for (const auto& [name, text] : header.attributes) {
      const auto choose = [&text](const auto& table, auto& choice) {
        for (const auto& entry : table) {
          if (entry.name == text) choice = entry.value;
        }
      };
      if (name == "emberline:exr_parts") {
        choose(exr_parts_table(), header.parts);
      } else if (name == "emberline:exr_compression") {
        choose(exr_compression_table(), header.compression);
      } else if (name == "emberline:half") {
        for (const std::string_view layer : split_list(text)) half.emplace_back(layer);
      }
    }
    for (PictureChannel& channel : header.channels) {
      if (channel.type == ChannelType::kFloat && is_half(channel.name, half)) {
        channel.type = ChannelType::kHalf;
      }
    }
  }

  void read(int rows, std::vector<float>& pixels) {
    const size_t all = file_.image().channel_names.size();
    if (channel_indices_.size() == all) return file_.read(rows, pixels);
    file_.read(rows, file_pixels_);
    pixels.resize(file_pixels_.size() / all * channel_indices_.size());
    float* next = pixels.data();
    for (size_t i = 0; i < file_pixels_.size(); i += all) {
      for (const size_t c : channel_indices_) *next++ = file_pixels_[i + c];
    }
  }

  ExrHeader header() const {
    const FloatImage& image = file_.image();
    ExrHeader header = {.width = image.frame_width,
                        .height = image.frame_height,
                        .data_window = image.data_window,
                        .tile_size = file_.tile_size(),
                        .channels = {},
                        .view = file_.view(),
                        .attributes = file_.text_attributes()};
    for (const size_t c : channel_indices_) {
      const bool is_counter = file_.channel_type(c) == ChannelType::kUint;
      header.channels.push_back(
          {image.channel_names[c], is_counter ? ChannelType::kUint : ChannelType::kFloat});
    }
    for (const std::string& name : denoise_results(channels_)) header.channels.push_back({name});
    restore_storage(header);
    return header;
  }

 private:
  FloatImageRows file_;
  std::vector<size_t> channel_indices_;
  std::vector<std::string> channels_;
  std::vector<float> file_pixels_;
};

void check_channels(const std::string& path, const std::vector<std::string>& channels) {
  const std::vector<std::string> missing = missing_denoise_channels(channels);
  if (missing.empty()) return;
  constexpr size_t kMaxListed = 6;
  const auto named = std::span(missing).first(std::min(kMaxListed, missing.size()));
  throw InputError(path, "it has no channels {}{}; render it with --aov denoising",
                   fmt::join(named, ", "), missing.size() > kMaxListed ? " and more" : "");
}

// Throws InputError if a part of the file does not belong to the picture. The result has the
// channels of only one picture, so the channels of such a part would be lost.
void check_parts(const std::string& path, const std::vector<ImagePart>& parts) {
  const auto mismatched = std::ranges::find(parts, -1, &ImagePart::first);
  if (mismatched == parts.end()) return;
  throw InputError(path, "its part {} differs from the first in size, or repeats its channel names",
                   mismatched->name);
}

// The output files, opened before denoising and written during it.
class Results {
 public:
  Results(const DenoiseOptions& options, const InputRows& rows) : channels_(rows.channels()) {
    std::shared_ptr<const DisplayTransform> transform;
    for (const std::string& path : options.outputs) {
      if (is_exr(path)) {
        exrs_.push_back({path, std::make_unique<ExrWriter>(path, rows.header())});
        continue;
      }
      if (!transform) {
        transform = std::make_shared<DisplayTransform>(options.display, rows.file().view().space);
      }
      images_.push_back(
          std::make_unique<DisplayImageWriter>(path, rows.file().image().data_window, transform,
                                               is_marked(rows.file(), "emberline:transparent")));
    }
  }

  void write(const Rect& tile, const std::vector<float>& pixels) {
    for (const auto& [path, writer] : exrs_) writer->write_tile(tile, pixels);
    if (images_.empty()) return;
    const std::vector<float> rgba = denoised_rgba(pixels, channels_);
    for (const auto& image : images_) image->write_tile(tile, rgba);
  }
  void finish(bool complete, WriteAttempts& attempts) {
    for (const auto& [path, writer] : exrs_) attempts.attempt(path, [&] { writer->finish(); });
    for (const auto& image : images_) {
      attempts.attempt(image->path(), [&] { image->finish(complete); });
    }
  }

 private:
  const std::vector<std::string>& channels_;
  std::vector<std::pair<std::string, std::unique_ptr<ExrWriter>>> exrs_;
  std::vector<std::unique_ptr<DisplayImageWriter>> images_;
};

}  // namespace

int run_denoise(const DenoiseOptions& options) {
  const WorkerThreads workers(options.threads);
  FileRegister files;
  files.read(options.image, "it is the frame itself");
  for (const std::string& path : options.outputs) {
    check_picture_format(path, {});
    files.write("-o", path);
  }
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  InputRows rows(options.image, progress);
  const FloatImage& image = rows.file().image();
  check_parts(options.image, image.parts);
  check_channels(options.image, rows.channels());
  for (const std::string& path : options.outputs) check_picture_format(path, image.data_window);
  const MemoryReservation memory(progress.budget(), MemoryPart::kFilm,
                                 denoise_bytes(image.data_window, rows.file().tile_size(),
                                               image.channel_names, rows.file().rows_at_once()),
                                 options.image);
  warn_if_stopped(options.image, image);
  Results results(options, rows);
  const DenoiseJob job = {
      .crop = image.data_window,
      .channels = rows.channels(),
      .tile_size = rows.file().tile_size(),
      .rows_at_once = rows.file().rows_at_once(),
      .read = [&](const Rect& part,
                  std::vector<float>& pixels) { rows.read(part.height(), pixels); },
      .write = [&](const Rect& tile,
                   const std::vector<float>& pixels) { results.write(tile, pixels); }};
  tbb::task_arena arena(workers.count());
  const DenoiseReport report = arena.execute([&] { return denoise_frame(job); });
  WriteAttempts attempts;
  results.finish(!image.stopped_after, attempts);
  log_info(describe(report));
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  return attempts.failed().empty() ? kExitDone : kExitRenderFailed;
}

}  // namespace emberline
