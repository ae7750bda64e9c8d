#include "renderer/output/snapshots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "io/image/library.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/output/rgb_file.h"
#include "renderer/output/scaled_picture.h"

namespace emberline {
namespace {

using Unit = SnapshotMoment::Unit;

constexpr NamedValue<SnapshotFormat> kFormats[] = {
    {"png", "the displayed picture (`display`, `view`, `look`, `exposure`)", SnapshotFormat::kPng},
    {"exr", "the displayed picture, and linear R G B A in an .exr file", SnapshotFormat::kExr},
};

constexpr const char* kAnimation = "refinement.gif";
constexpr const char* kMarker = "emberline-snapshots.json";

// A unit, its suffix in the option, and its label in file names.
struct UnitEntry {
  Unit unit;
  std::string_view suffix, label;
  double max_value;
};
constexpr UnitEntry kUnits[] = {
    {Unit::kPercentCovered, "%", "pct", 100.0},
    {Unit::kSamplesPerPixel, "spp", "spp", double(kMaxSamples)},
    {Unit::kSeconds, "s", "s", 1e9},
};

SnapshotMoment parse_moment(std::string_view text) {
  if (text == "first") return {};
  for (const UnitEntry& entry : kUnits) {
    if (!text.ends_with(entry.suffix)) continue;
    const auto value = parse_real(text.substr(0, text.size() - entry.suffix.size()));
    if (value && *value > 0 && *value <= entry.max_value) return {entry.unit, *value};
    break;
  }
  throw UsageError(
      "`snapshot-at`: '{}' is not a moment; valid are 'first', N% up to 100%, Ns up to 1e9s and "
      "Nspp up to {}spp, with N above 0",
      shortened(text), kMaxSamples);
}

// Pads numbers with zeros, so that the names sort by number.
std::string label(const SnapshotMoment& moment) {
  const auto entry = std::ranges::find(kUnits, moment.unit, &UnitEntry::unit);
  if (entry == std::end(kUnits)) return "first";
  const bool whole = moment.value == std::floor(moment.value);
  return whole ? fmt::format("{:04.0f}{}", moment.value, entry->label)
               : fmt::format("{:08.3f}{}", moment.value, entry->label);
}

// Returns what follows a number such as "003_" in a snapshot's name; nullopt for other names.
std::optional<std::string> suffix_after_number(const std::string& name) {
  const size_t digits = name.find_first_not_of("0123456789");
  if (digits == std::string::npos || digits < 3 || name[digits] != '_') return std::nullopt;
  return name.substr(digits + 1);
}

}  // namespace

std::span<const NamedValue<SnapshotFormat>> snapshot_format_table() { return kFormats; }

std::vector<SnapshotMoment> parse_snapshot_moments(std::string_view list) {
  std::vector<SnapshotMoment> moments;
  while (true) {
    const size_t comma = list.find(',');
    moments.push_back(parse_moment(list.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  return moments;
}

bool is_snapshot_name(const std::string& name) {
  return name == kAnimation || name == kMarker || suffix_after_number(name);
}

SnapshotRecorder::SnapshotRecorder(const RenderOptions& options, const Rect& crop,
                                   const LoadProgress& progress)
    : options_(options),
      crop_(crop),
      format_(find_named(kFormats, "`snapshot-format`", "format", options.snapshot_format).value),
      pending_(parse_snapshot_moments(options.snapshot_at ? std::string_view(*options.snapshot_at)
                                                          : kDefaultSnapshotMoments)),
      transform_(std::make_shared<DisplayTransform>(options.display)) {
  if (!options.reference.empty()) {
    reference_ = reference_pixels(read_rgb(options.reference, progress), "the frame to measure",
                                  crop, options.width, options.height);
  }
  image_library();  // needed by the animation; if it is missing, fails now and not after rendering
  folder_.emplace(options.snapshots, OwnedFolderKind{"`snapshots`", kMarker});
  for (const std::string& name : folder_->entries()) {
    if (matches_pending(name)) folder_->check(std::array{name});
  }
}

// Whether `name` is the name of the animation or of a pending moment's file. Such a file is called,
// for example, "003_0005pct.png", with any number in place of 003.
bool SnapshotRecorder::matches_pending(const std::string& name) const {
  if (name == kAnimation) return true;
  const std::optional<std::string> suffix = suffix_after_number(name);
  return suffix && std::ranges::any_of(pending_, [&](const SnapshotMoment& moment) {
           return *suffix == label(moment) + ".png" || *suffix == label(moment) + ".exr";
         });
}

bool SnapshotRecorder::is_reached(const SnapshotMoment& moment, const JobProgress& progress,
                                  double elapsed_s) const {
  switch (moment.unit) {
    case Unit::kFirstPause:
      return true;
    case Unit::kPercentCovered:
      return 100.0 * progress.completion >= moment.value;
    case Unit::kSeconds:
      return elapsed_s >= moment.value;
    case Unit::kSamplesPerPixel:
      return double(progress.samples) >= moment.value * double(crop_.area());
  }
  return false;
}

void SnapshotRecorder::update(const JobProgress& progress, const LivePicture& picture,
                              double elapsed_s) {
  std::shared_ptr<std::vector<float>> rgba;
  std::erase_if(pending_, [&](const SnapshotMoment& moment) {
    if (!is_reached(moment, progress, elapsed_s)) return false;
    if (!rgba) {
      rgba = std::make_shared<std::vector<float>>(4 * size_t(crop_.area()));
      picture.resolve(*rgba);
    }
    recorded_.push_back({moment, progress, elapsed_s, rgba});
    return true;
  });
}

bool SnapshotRecorder::is_due(double elapsed_s) const {
  return std::ranges::any_of(pending_, [&](const SnapshotMoment& moment) {
    return moment.unit == Unit::kSeconds && elapsed_s >= moment.value;
  });
}

std::optional<uint64_t> SnapshotRecorder::next_sample_count() const {
  const auto area = double(crop_.area());
  std::optional<uint64_t> next_count;
  for (const SnapshotMoment& moment : pending_) {
    if (moment.unit == Unit::kSeconds) continue;
    const double samples = moment.unit == Unit::kSamplesPerPixel  ? moment.value * area
                           : moment.unit == Unit::kPercentCovered ? moment.value / 100.0 * area
                                                                  : 1.0;
    next_count = std::min(next_count.value_or(uint64_t(-1)), uint64_t(std::ceil(samples)));
  }
  return next_count;
}

void SnapshotRecorder::write_exr(const std::string& file, const std::vector<float>& rgba) const {
  const ExrHeader header = {.width = options_.width,
                            .height = options_.height,
                            .data_window = crop_,
                            .tile_size = tile_size(driver_of(options_), options_.bucket_size),
                            .channels = {{"R"}, {"G"}, {"B"}, {"A"}},
                            .attributes = {}};
  write_exr_file(file, header, rgba);
}

void SnapshotRecorder::write_animation() const {
  constexpr double kFrameSeconds = 0.7;
  constexpr int kMaxSide = 640;
  std::vector<ByteImage> frames;
  for (const Snapshot& snapshot : recorded_) {
    ScaledPicture scaled(crop_, kMaxSide);
    scaled.add(crop_, *snapshot.rgba, 4);
    frames.push_back(scaled.display(*transform_));
  }
  const std::string file = folder_->path(kAnimation);
  const std::vector<unsigned char> bytes = encode_animation(frames, kFrameSeconds, file);
  write_file_atomically(
      file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

std::vector<SnapshotReport> SnapshotRecorder::write(WriteAttempts& attempts) {
  const bool exr = format_ == SnapshotFormat::kExr;
  std::vector<std::string> names, files = {kAnimation};
  for (const Snapshot& snapshot : recorded_) {
    names.push_back(fmt::format("{:03}_{}", names.size(), label(snapshot.moment)));
    files.push_back(names.back() + ".png");
    if (exr) files.push_back(names.back() + ".exr");
  }
  std::vector<SnapshotReport> reports;
  const auto claim = [&] { folder_->claim(files); };
  if (recorded_.empty() || !attempts.attempt(folder_->path(), claim)) return reports;
  for (const Snapshot& snapshot : recorded_) {
    const std::string& name = names[reports.size()];
    const std::string picture = folder_->path(name + ".png");
    const bool written = attempts.attempt(picture, [&] {
      write_display_image(picture, crop_, transform_, options_.transparent, *snapshot.rgba);
    });
    if (exr) {
      const std::string values = folder_->path(name + ".exr");
      attempts.attempt(values, [&] { write_exr(values, *snapshot.rgba); });
    }

    SnapshotReport& report = reports.emplace_back();
    if (written) report.file = name + ".png";
    report.completion = snapshot.progress.completion;
    report.samples = snapshot.progress.samples;
    report.elapsed_s = snapshot.elapsed_s;
    if (!reference_) continue;
    const ErrorMetrics error = compare_images(to_rgb_image(*snapshot.rgba, 4, crop_), *reference_,
                                              {.exposure = options_.display.exposure});
    report.rmse = std::pow(10.0, -error.psnr / 20);  // the peak is 1
    report.mse = error.mse;
    report.rel_mse = error.rel_mse;
  }
  attempts.attempt(folder_->path(kAnimation), [&] { write_animation(); });
  return reports;
}

}  // namespace emberline
