#include "renderer/output/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "io/image/file_completeness.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/parallel.h"
#include "renderer/core/rect_values.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/half_layers.h"
#include "renderer/engine/render_plan.h"
#include "renderer/film/shared_samples.h"
#include "renderer/output/frame_explanation.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

constexpr const char* kSamplesAttribute = "emberline:samples";
constexpr const char* kClampedAttribute = "emberline:clamped";
constexpr size_t kMaxDigits = 20;  // length of a 64-bit number

// Returns the header's primaries and, if the settings give a time, its time code and frame rate.
ExrView view_of(const FrameSettings& settings) {
  ExrView view;
  view.space = settings.working_space;
  const std::optional<double> time = pose_time(settings);
  if (!time) return view;
  view.frames_per_second = frame_rate_fraction(settings.fps);
  const double frame = settings.frame.value_or(*time * settings.fps);
  constexpr double kFrameTolerance = 1e-6;  // tolerance for a whole frame number
  if (std::abs(frame - std::round(frame)) < kFrameTolerance)
    view.time_code = smpte_time_code(std::llround(frame), settings.fps);
  return view;
}

}  // namespace

void write_film_exr(const std::string& path, const AovSet& aovs, int width, int height,
                    const Rect& crop, std::vector<std::pair<std::string, std::string>> attributes,
                    std::vector<float> values) {
  std::vector<std::string> names = film_channel_names(aovs);
  resolve_shares(crop, names, values);
  write_exr_file(path,
                 {.width = width,
                  .height = height,
                  .data_window = crop,
                  .channels = finished_channels(film_channels(aovs), false),
                  .attributes = std::move(attributes)},
                 values);
}

OutputSettings output_settings(const RenderOptions& options, const Rect& crop) {
  OutputSettings settings;
  settings.width = options.width;
  settings.height = options.height;
  settings.tile_size = tile_size(driver_of(options), options.bucket_size);
  settings.view = view_of(options);
  settings.compression = options.exr_compression;
  settings.parts = options.exr_parts;
  settings.attributes = settings_attributes(options);
  settings.crop = crop;
  settings.aovs = aovs_of(options);
  settings.display = options.display;
  settings.transparent = options.transparent;
  settings.heatmaps = heatmap_requests(options);
  settings.heatmap_style = options.heatmap_style;
  settings.heatmap_style.judged = judged_names(options);
  settings.is_clamped = options.clamp_indirect.has_value();
  settings.denoise = options.denoise;
  settings.explained = options.explained;
  settings.light_groups = options.light_groups;
  settings.cryptomattes = parse_cryptomattes(options.cryptomattes);
  settings.cryptomatte_levels = options.cryptomatte_levels;
  settings.half = parse_half_layers(options.half);
  for (const HeatmapRequest& heatmap : settings.heatmaps) {
    if (heatmap.quantity->aov) settings.aovs.insert(*heatmap.quantity->aov);
  }
  return settings;
}

ExrHeader frame_header(const OutputSettings& settings, std::vector<PictureChannel> channels,
                       const SceneLayers& layers) {
  for (PictureChannel& channel : channels) {
    const bool half = channel.type == ChannelType::kFloat && is_half(channel.name, settings.half);
    if (half) channel.type = ChannelType::kHalf;
  }
  ExrHeader header = settings;
  header.data_window = settings.crop;
  header.channels = std::move(channels);
  header.view.camera = layers.camera;
  header.attributes.emplace_back(kCompleteAttribute, "false");
  header.attributes.emplace_back(kSamplesAttribute, std::string(kMaxDigits, ' '));
  if (settings.is_clamped) {
    header.attributes.emplace_back(kClampedAttribute, std::string(kMaxDigits, ' '));
  }
  if (settings.explained) {
    header.attributes.emplace_back(kExplanationAttribute, std::string(kMaxExplanation, ' '));
  }
  // The mattes' names may be megabytes long. They come last, so that is_unfinished_image() soon
  // finds the attributes that it reads.
  for (auto& attribute : cryptomatte_attributes(layers.cryptomattes)) {
    header.attributes.push_back(std::move(attribute));
  }
  return header;
}

void set_state(const OutputSettings& settings, const FrameState& state, ExrWriter& writer) {
  writer.set_attribute(kCompleteAttribute, state.complete ? "true" : "false");
  writer.set_attribute(kSamplesAttribute, std::to_string(state.samples));
  if (settings.is_clamped)
    writer.set_attribute(kClampedAttribute, fmt::format("{:.4g}", state.clamped_fraction));
  if (settings.explained && !state.history.empty()) {
    writer.set_attribute(kExplanationAttribute,
                         explanation_attribute(*settings.explained, state.history));
  }
}

void register_inputs(const RenderOptions& options, FileRegister& files) {
  if (!options.scene.empty()) files.read(options.scene, "it is the scene");
  const auto read = [&files](const std::string& path, const char* option) {
    if (!path.empty()) files.read(path, std::string("it is the file of ") + option);
  };
  read(options.environment, "`env`");
  read(options.edits, "`edits`");
  read(options.reference, "`reference`");
  read(options.settings_file, "`settings`");
  if (!options.extended.empty()) files.read(options.extended, "it is the frame to extend");
  if (const char* config = std::getenv("OCIO")) {
    read(config, "$OCIO");
    for (const std::string& table : ocio_table_files())
      files.read(table, "the $OCIO config reads it");
  }
}

void check_picture_format(const std::string& path, const Rect& crop) {
  const std::string suffix = lower_suffix(path);
  // libjpeg's own limit (JPEG_MAX_DIMENSION). libjpeg ends the process if a side is longer.
  constexpr int kJpegLimit = 65500;
  if (suffix == ".jpg" || suffix == ".jpeg") {
    if (crop.width() > kJpegLimit || crop.height() > kJpegLimit) {
      throw UsageError("-o {}: JPEG holds at most {} pixels a side; write .exr or .png", path,
                       kJpegLimit);
    }
  } else if (suffix != ".exr" && suffix != ".png") {
    throw UsageError("-o {}: unknown format; valid suffixes are .exr, .png, .jpg, .jpeg", path);
  }
}

void register_frame_outputs(const RenderOptions& options, FileRegister& files) {
  for (const std::string& path : options.outputs) files.write("-o", path);
  for (const std::string& path : options.heatmaps) files.write("`heatmap`", path);
  for (const std::string& path : options.reports) files.write("`report`", path);
  for (const std::string& path : options.trees) files.write("`tree`", path);
  const std::string checkpoint = checkpoint_path(options);
  if (!checkpoint.empty()) files.write("`checkpoint`", checkpoint);
  if (!options.snapshots.empty()) {
    files.write_in("`snapshots`", options.snapshots, is_snapshot_name);
  }
}

void register_run_outputs(const RenderOptions& options, FileRegister& files) {
  if (!options.save_settings.empty()) files.write("`save-settings`", options.save_settings);
  if (!options.range_report.empty()) files.write("`range-report`", options.range_report);
  if (!options.progress_file.empty()) files.write("`progress-file`", options.progress_file);
}

void check_output_paths(const RenderOptions& options, const Rect& crop, FileRegister& files) {
  for (const std::string& path : options.outputs) check_picture_format(path, crop);
  for (const std::string& path : options.heatmaps) check_heatmap_format("`heatmap`", path, crop);
  for (const std::string& path : options.trees) {
    if (!is_json(path)) image_format_of(path);
  }
  register_inputs(options, files);
  register_frame_outputs(options, files);
  register_run_outputs(options, files);
}

FrameOutputs::FrameOutputs(const std::vector<std::string>& paths, const OutputSettings& settings,
                           const StopRequest& stop)
    : settings_(settings), channels_(settings), stop_(stop) {
  for (const std::string& path : paths) {
    if (is_exr(path)) {
      ExrOutput& exr = exrs_.emplace_back();
      exr.path = path;
      begin(exr);
    } else {
      if (!transform_) {
        transform_ = std::make_shared<DisplayTransform>(settings.display, settings.view.space);
        exposure_hint_.emplace(*transform_, settings.display.exposure);
      }
      images_.push_back(std::make_unique<DisplayImageWriter>(path, settings.crop, transform_,
                                                             settings.transparent));
    }
  }
  begin_spool();
  const std::vector<std::string> names = film_channel_names(settings.aovs);
  const HeatmapFile::Frame frame{settings.width, settings.height, settings.crop,
                                 settings.attributes};
  for (const HeatmapRequest& request : settings.heatmaps) {
    heatmaps_.push_back(
        std::make_unique<HeatmapFile>(request, settings.heatmap_style, frame, names));
  }
}

// Opens the file with all channels known so far.
void FrameOutputs::begin(ExrOutput& exr) {
  exr.writer.reset();  // deletes the unfinished file
  exr.writer = std::make_unique<ExrWriter>(
      exr.path,
      frame_header(settings_, finished_channels(channels_.list(), settings_.denoise), layers_));
}

void FrameOutputs::begin_spool() {
  spool_.reset();
  const bool sums = settings_.aovs.contains(Aov::kDenoising) && !exrs_.empty();
  if (!sums && (!settings_.denoise || images_.empty())) return;
  const std::string& beside = exrs_.empty() ? images_.front()->path() : exrs_.front().path;
  spool_ = std::make_unique<PixelSpool>(beside, settings_.crop, channels_.list().size());
}

void FrameOutputs::add_scene(const SceneLayers& layers) {
  layers_ = layers;
  channels_.add_scene(layers);
  for (ExrOutput& exr : exrs_) begin(exr);
  begin_spool();
}

void FrameOutputs::tile_finished(const FilmTile& tile) {
  thread_local std::vector<float> pixels;  // reused, so that a tile needs no allocation
  if (spool_ || !exrs_.empty() || !heatmaps_.empty()) {
    channels_.resolve(tile, pixels);
    for (const auto& heatmap : heatmaps_) heatmap->write_tile(tile.rect(), pixels);
    if (spool_) {
      spool(tile.rect(), pixels);
    } else {
      for (ExrOutput& exr : exrs_) write(exr, tile.rect(), pixels);
    }
  }
  if (!images_.empty() && !settings_.denoise) {
    tile.resolve_rgba(pixels);
    write_images(tile.rect(), pixels);
  }
  const uint64_t bytes = tile.bytes() + pixels.capacity() * sizeof(float);
  const std::lock_guard lock(mutex_);
  uint64_t& peak_bytes = thread_bytes_[std::this_thread::get_id()];
  peak_bytes = std::max(peak_bytes, bytes);
}

void FrameOutputs::write(ExrOutput& exr, const Rect& tile, const std::vector<float>& pixels) {
  if (exr.failed) return;
  try {
    exr.writer->write_tile(tile, pixels);
  } catch (const RenderError& error) {
    exr.failed = true;
    if (rendered_) return;
    if (all_outputs_failed()) throw;
    log_warning(std::string(error.what()) + "; the render continues for the other files");
  }
}

// Throws RenderError. Once rendering has ended, stores the error for finish() instead of throwing
// it.
void FrameOutputs::spool(const Rect& tile, const std::vector<float>& pixels) {
  try {
    spool_->write_tile(tile, pixels);
  } catch (const RenderError& error) {
    if (!rendered_) throw;
    const std::lock_guard lock(mutex_);
    spool_failure_ = error.what();
  }
}

std::optional<DenoiseReport> FrameOutputs::finish_spooled(const std::stop_token& stop) {
  if (!spool_ || !spool_failure_.empty()) return std::nullopt;
  try {
    if (settings_.denoise) return denoise(stop);
    write_tiles();
  } catch (const RenderError& error) {
    spool_failure_ = error.what();
  }
  return std::nullopt;
}

DenoiseReport FrameOutputs::denoise(const std::stop_token& stop) {
  log_verbose("denoising");
  const auto read = std::bind_front(&PixelSpool::read_rows, spool_.get());
  const auto write = std::bind_front(&FrameOutputs::write_denoised, this);
  return denoise_film_rows({.crop = settings_.crop,
                            .rows = {.channels = names_of(channels_.list()), .read = read},
                            .tile_size = settings_.tile_size,
                            .write = write,
                            .stop = stop});
}

void FrameOutputs::write_tiles() {
  const Rect& crop = settings_.crop;
  ShareResolver rows(crop, names_of(channels_.list()),
                     std::bind_front(&PixelSpool::read_rows, spool_.get()));
  const int size = settings_.tile_size;
  std::vector<float> pixels;
  for (int y = crop.y0; y < crop.y1; y += size) {
    const Rect band = Rect{crop.x0, y, crop.x1, y + size}.intersect(crop);
    rows.read(band, pixels);
    parallel_tasks(size_t((crop.width() + size - 1) / size), [&](size_t i) {
      const int x = crop.x0 + int(i) * size;
      const Rect tile = Rect{x, y, x + size, y + size}.intersect(crop);
      const std::vector<float> values = extract_rect(pixels, band, tile);
      for (ExrOutput& exr : exrs_) write(exr, tile, values);
    });
  }
}

void FrameOutputs::write_images(const Rect& tile, const std::vector<float>& rgba) {
  for (const auto& image : images_) image->write_tile(tile, rgba);
  exposure_hint_->add(rgba);
}

void FrameOutputs::write_denoised(const Rect& tile, const std::vector<float>& pixels) {
  for (ExrOutput& exr : exrs_) write(exr, tile, pixels);
  if (images_.empty()) return;
  const std::vector<float> rgba =
      denoised_rgba(pixels, names_of(finished_channels(channels_.list(), false)));
  write_images(tile, rgba);
}

bool FrameOutputs::all_outputs_failed() const {
  return images_.empty() && heatmaps_.empty() &&
         std::ranges::all_of(exrs_, [](const ExrOutput& exr) { return exr.failed.load(); });
}

void FrameOutputs::finish(const FrameState& state, WriteAttempts& attempts) {
  const auto check_spool = [&] {
    if (!spool_failure_.empty()) throw RenderError(spool_failure_);
  };
  for (const ExrOutput& exr : exrs_) {
    attempts.attempt(exr.path, [&] {
      check_spool();
      set_state(settings_, state, *exr.writer);
      exr.writer->finish();
    });
  }
  for (const auto& image : images_) {
    attempts.attempt(image->path(), [&] {
      check_spool();
      image->finish(state.complete);
    });
  }
  for (const auto& heatmap : heatmaps_)
    attempts.attempt(heatmap->path(), [&] { heatmap->finish(); });
  if (const auto exposure = exposure_hint_ ? exposure_hint_->suggestion() : std::nullopt) {
    log_info(
        fmt::format("most of the picture is brighter than white; try `exposure` {}", *exposure));
  }
}

uint64_t FrameOutputs::film_bytes() const {
  const std::lock_guard lock(mutex_);
  uint64_t bytes = 0;
  for (const auto& [thread, peak_bytes] : thread_bytes_) bytes += peak_bytes;
  for (const auto& image : images_) bytes += image->bytes();
  for (const auto& heatmap : heatmaps_) bytes += heatmap->bytes();
  return bytes;
}

std::string FrameOutputs::display_description() const {
  return transform_ ? transform_->describe() : "";
}

}  // namespace emberline
