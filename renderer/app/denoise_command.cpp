#include "renderer/app/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "io/files/register.h"
#include "io/files/write_attempts.h"
#include "io/image/input.h"
#include "renderer/app/failure.h"
#include "renderer/app/frame_range.h"
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

constexpr const char* kCombinedFrames = "emberline:denoised_with_frames";

// Reads some of a frame's channels.
class InputRows {
 public:
  // Reads all channels except the results of an earlier denoising.
  InputRows(const std::string& path, const LoadProgress& progress)
      : path_(path), file_(path, progress) {
    for (const std::string& name : file_.image().channel_names) {
      if (!name.starts_with("denoised.")) channels_.push_back(name);
    }
    find_channels();
  }
  // Reads only `channels`. read() may be called only if missing(channels) is empty.
  InputRows(const std::string& path, const LoadProgress& progress,
            std::vector<std::string> channels)
      : path_(path), file_(path, progress), channels_(std::move(channels)) {
    find_channels();
  }

  const std::string& path() const { return path_; }
  const FloatImageRows& file() const { return file_; }
  const std::vector<std::string>& channels() const { return channels_; }
  // Returns those of `names` that the file lacks.
  std::vector<std::string> missing(const std::vector<std::string>& names) const {
    std::vector<std::string> list;
    for (const std::string& name : names) {
      if (file_.image().find_channel(name) < 0) list.push_back(name);
    }
    return list;
  }
  RowSource source() {
    return {channels_, file_.rows_at_once(),
            [this](const Rect& rows, std::vector<float>& pixels) { read(rows.height(), pixels); }};
  }

  // Sets the storage options (parts, compression, half floats) that the frame's header records.
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
    if (channels_ == file_.image().channel_names) return file_.read(rows, pixels);
    file_.read(rows, file_pixels_);
    pixels.resize(file_pixels_.size() / all * channel_indices_.size());
    float* next = pixels.data();
    for (size_t i = 0; i < file_pixels_.size(); i += all) {
      for (const size_t c : channel_indices_) *next++ = file_pixels_[i + c];
    }
  }

  // `frames` lists the frames that were combined. It is empty if this frame was denoised alone.
  ExrHeader header(const std::string& frames) const {
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
    std::erase_if(header.attributes, [](const auto& a) { return a.first == kCombinedFrames; });
    if (!frames.empty()) header.attributes.emplace_back(kCombinedFrames, frames);
    restore_storage(header);
    return header;
  }

 private:
  void find_channels() {
    for (const std::string& name : channels_) {
      channel_indices_.push_back(size_t(file_.image().find_channel(name)));
    }
  }

  std::string path_;
  FloatImageRows file_;
  std::vector<std::string> channels_;
  std::vector<size_t> channel_indices_;
  std::vector<float> file_pixels_;
};

// Returns text such as "R, G and more".
std::string format_names(const std::vector<std::string>& names) {
  constexpr size_t kMaxListed = 6;
  const auto first = std::span(names).first(std::min(kMaxListed, names.size()));
  return fmt::format("{}{}", fmt::join(first, ", "), names.size() > kMaxListed ? " and more" : "");
}

void check_channels(const std::string& path, const InputRows& rows, int across) {
  const auto need = [&](const std::vector<std::string>& missing, const char* aov) {
    if (missing.empty()) return;
    throw InputError(path, "it has no channels {}; render it with --aov {}", format_names(missing),
                     aov);
  };
  need(missing_denoise_channels(rows.channels()), "denoising");
  if (across > 0) need(rows.missing(neighbour_channels(rows.channels())), "denoising,velocity");
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
  Results(const DenoiseOptions& options, const InputRows& rows, const std::string& frames)
      : channels_(rows.channels()) {
    std::shared_ptr<const DisplayTransform> transform;
    for (const std::string& path : options.outputs) {
      if (is_exr(path)) {
        exrs_.push_back({path, std::make_unique<ExrWriter>(path, rows.header(frames))});
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

// The frames of a sequence, which are denoised one after another. Each neighbour is decoded once
// and kept in a scratch file, because later frames use it too.
class Sequence {
 public:
  // `options` must outlive the sequence.
  explicit Sequence(const DenoiseOptions& options)
      : options_(options), numbers_(existing_frames(options.image)) {}

  const std::vector<int>& numbers() const { return numbers_; }  // of all existing frames

  // Returns the neighbours of a frame, nearest first. On each side, stops at the first frame that
  // is missing or does not fit. If there are fewer neighbours than requested, logs which frames are
  // combined. The result is valid until the next call. Scratch files are created beside `output`.
  std::vector<DenoiseNeighbour> neighbours_of(int number, const InputRows& frame,
                                              const std::string& output,
                                              const LoadProgress& progress) {
    std::erase_if(decoded_, [&](const auto& entry) {
      return std::abs(int64_t(entry.first) - number) > options_.across;
    });
    std::vector<DenoiseNeighbour> list;
    combined_ = {number};
    std::array<bool, 2> ended = {};
    for (int distance = 1; distance <= options_.across; ++distance) {
      for (const size_t side : {size_t(0), size_t(1)}) {
        const int offset = side == 0 ? distance : -distance;
        ended[side] = ended[side] || !decode(number + offset, frame, output, progress);
        if (ended[side]) continue;
        const Decoded& neighbour = decoded_.at(number + offset);
        list.push_back({offset,
                        {neighbour.channels, 1,
                         std::bind_front(&PixelSpool::read_rows, neighbour.rows.get())}});
        combined_.push_back(number + offset);
      }
    }
    std::ranges::sort(combined_);
    if (list.size() < 2 * size_t(options_.across)) {
      log_info(fmt::format("{}: combined with fewer frames than --across {} would use: {}",
                           expand_frame_number(options_.image, number), options_.across,
                           format_frames(combined_)));
    }
    return list;
  }
  // The numbers of the frames that the last call of neighbours_of() combined.
  std::string combined() const { return format_frames(combined_); }

 private:
  struct Decoded {
    FloatImage image;  // without pixel values
    std::vector<std::string> channels;
    std::unique_ptr<PixelSpool> rows;
  };

  // Reads a neighbour into decoded_. Returns false if it does not exist or, with a warning, if it
  // does not fit the frame.
  bool decode(int number, const InputRows& frame, const std::string& output,
              const LoadProgress& progress) {
    if (!std::ranges::binary_search(numbers_, number) || unreadable_.contains(number)) return false;
    const std::vector<std::string> channels = neighbour_channels(frame.channels());
    const auto known = decoded_.find(number);
    if (known != decoded_.end() && known->second.channels == channels &&
        why_unfit(frame.file().image(), known->second.image).empty()) {
      return true;
    }
    const std::string path = expand_frame_number(options_.image, number);
    try {
      InputRows rows(path, progress, channels);
      const FloatImage& image = rows.file().image();
      const std::vector<std::string> missing = rows.missing(channels);
      std::string unfit = why_unfit(frame.file().image(), image);
      if (unfit.empty() && !missing.empty()) unfit = "it has no channels " + format_names(missing);
      if (!unfit.empty()) {
        log_warning(fmt::format("{}: not combined with {}: {}", path, frame.path(), unfit));
        return false;
      }
      decoded_.insert_or_assign(number, Decoded{image, channels, copy_of(rows, output)});
      return true;
    } catch (const LimitError&) {
      throw;
    } catch (const InputError& error) {
      log_warning(fmt::format("{}; not combined with its neighbours", error.what()));
      unreadable_.insert(number);
      return false;
    }
  }

  static std::string why_unfit(const FloatImage& here, const FloatImage& there) {
    if (here.data_window != there.data_window || here.frame_width != there.frame_width ||
        here.frame_height != there.frame_height) {
      return "its size or crop differs";
    }
    return here.space == there.space ? "" : "its colour space differs";
  }

  static std::unique_ptr<PixelSpool> copy_of(InputRows& from, const std::string& output) {
    const Rect& crop = from.file().image().data_window;
    auto copy = std::make_unique<PixelSpool>(output, crop, from.channels().size());
    const int step = from.file().rows_at_once();
    std::vector<float> pixels;
    for (int y = crop.y0; y < crop.y1; y += step) {
      const Rect rows = {crop.x0, y, crop.x1, std::min(y + step, crop.y1)};
      from.read(rows.height(), pixels);
      copy->write_tile(rows, pixels);
    }
    return copy;
  }

  const DenoiseOptions& options_;
  std::vector<int> numbers_;  // in ascending order
  std::map<int, Decoded> decoded_;
  std::set<int> unreadable_;
  std::vector<int> combined_;
};

// Denoises a single frame. `sequence` is null if the frame is not combined with others.
int denoise_file(const DenoiseOptions& options, Sequence* sequence, int number) {
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  InputRows rows(options.image, progress);
  const FloatImage& image = rows.file().image();
  check_parts(options.image, image.parts);
  check_channels(options.image, rows, options.across);
  for (const std::string& path : options.outputs) check_picture_format(path, image.data_window);
  DenoiseJob job = {.crop = image.data_window,
                    .rows = rows.source(),
                    .tile_size = rows.file().tile_size(),
                    .write = {}};
  if (sequence != nullptr) {
    job.neighbours = sequence->neighbours_of(number, rows, options.outputs.front(), progress);
  }
  const MemoryReservation memory(
      progress.budget(), MemoryPart::kFilm,
      denoise_bytes(image.data_window, rows.file().tile_size(), image.channel_names,
                    rows.file().rows_at_once(), job.neighbours.size()),
      options.image);
  warn_if_stopped(options.image, image);
  Results results(options, rows, sequence != nullptr ? sequence->combined() : "");
  job.write = [&](const Rect& tile, const std::vector<float>& pixels) {
    results.write(tile, pixels);
  };
  tbb::task_arena arena(options.threads);
  const DenoiseReport report = arena.execute([&] { return denoise_frame(job); });
  WriteAttempts attempts;
  results.finish(!image.stopped_after, attempts);
  log_info(describe(report));
  for (const std::string& path : attempts.written()) log_info("wrote " + path);
  return attempts.failed().empty() ? kExitDone : kExitRenderFailed;
}

void register_outputs(const DenoiseOptions& options, FileRegister& files) {
  for (const std::string& path : options.outputs) {
    check_picture_format(path, {});
    files.write("-o", path);
  }
}

DenoiseOptions options_of_frame(const DenoiseOptions& options, int number) {
  DenoiseOptions one = options;
  one.image = expand_frame_number(options.image, number);
  for (std::string& path : one.outputs) path = expand_frame_number(path, number);
  return one;
}

int denoise_sequence(DenoiseOptions options) {
  Sequence sequence(options);
  if (options.frames.empty()) options.frames = sequence.numbers();
  if (options.frames.size() > 1) {
    for (const std::string& path : options.outputs) {
      check_frame_number("-o", path, options.image);
    }
  }
  FileRegister files;
  for (const int number : options.in_place ? std::vector<int>() : sequence.numbers()) {
    files.read(expand_frame_number(options.image, number), "it is a frame of the sequence");
  }
  for (const int number : options.frames) {
    register_outputs(options_of_frame(options, number), files);
  }
  for (const std::string& path : options.outputs) {
    check_writable(expand_frame_number(path, options.frames.front()));
  }
  int exit_code = kExitDone;
  for (const int number : options.frames) {
    const DenoiseOptions one = options_of_frame(options, number);
    try {
      exit_code =
          std::max(exit_code, denoise_file(one, options.across > 0 ? &sequence : nullptr, number));
    } catch (const std::exception& error) {
      const Failure failure = failure_of(error);
      log_error(failure.message);
      exit_code = std::max(exit_code, failure.exit_code);
    }
  }
  return exit_code;
}

}  // namespace

int run_denoise(const DenoiseOptions& options) {
  const WorkerThreads workers(options.threads);
  DenoiseOptions limited = options;
  limited.threads = workers.count();
  if (is_sequence(options.image)) return denoise_sequence(std::move(limited));
  if (options.across > 0 || !options.frames.empty()) {
    throw UsageError("--{} needs a sequence: write #### instead of the frame's number in {}",
                     options.across > 0 ? "across" : "frames", options.image);
  }
  FileRegister files;
  files.read(options.image, "it is the frame itself");
  register_outputs(options, files);
  return denoise_file(limited, nullptr, 0);
}

}  // namespace emberline
