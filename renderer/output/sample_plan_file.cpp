#include "renderer/output/sample_plan_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/files/record_file.h"
#include "io/image/input.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/drivers/driver_choices.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/recorded_settings.h"
#include "samplers/sampler.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

// Marks the file as a plan, so that no frame can resume it as its checkpoint.
constexpr const char* kMark = "plan";

bool is_plan(const Json& head) {
  const auto settings = head.is_object() ? head.find("settings") : head.end();
  return settings != head.end() && settings->is_object() && settings->contains(kMark);
}

// Whether the frame is denoised, so that each pixel needs samples in both halves.
bool has_halves(const Json& head) {
  return find_text(head, "settings", "aov").find("denoising") != std::string::npos;
}

// Whether a setting affects the value of a sample, or the view that it belongs to.
bool decides_samples(const Setting& setting) {
  using enum SettingGroup;
  constexpr SettingGroup kGroups[] = {kLoading, kEdits, kLight, kView, kSample, kSeed, kTurn};
  constexpr std::string_view kMore[] = {"sampler", "sample-range", "catcher", "catcher-plane",
                                        "holdout"},
                             kFewer[] = {"crop", "isa", "resource-root"};
  const auto contains = [](const auto& list, const auto& value) {
    return std::ranges::find(list, value) != std::end(list);
  };
  return !setting.file && (contains(kGroups, setting.group) || contains(kMore, setting.name)) &&
         !contains(kFewer, setting.name);
}

// Lists the settings whose difference makes the samples of the picture differ from those of the
// frame.
std::vector<std::string> sample_changes(const FloatImageRows& picture, const RenderOptions& now,
                                        const std::string& path) {
  const RecordedSettings recorded(picture.text_attributes());
  std::vector<std::string> list = recorded.changes(now, decides_samples);
  if (recorded.settings().unbiased) list.emplace_back("it was rendered with `unbiased`");
  // A weighted sampler's weights depend on the sample count. Only frames that know this count in
  // advance use them.
  const SamplerEntry& sampler = find_named(sampler_table(), "`sampler`", "sampler", now.sampler);
  if (sampler.weighted && samples_uniformly(recorded.settings()) &&
      !recorded.settings().time_budget_s) {
    list.push_back(fmt::format("its samples have weights (`sampler` {})", now.sampler));
  }
  const RenderPlan planned(now);
  const RenderPlan then =
      convert_usage_errors(path, [&] { return RenderPlan(recorded.settings()); });
  if (then.streams != planned.streams || then.half_block != planned.half_block) {
    list.emplace_back("only one of the two is denoised or has `streams` 2");
  }
  return list;
}

}  // namespace

void check_plan_output(const std::string& path) {
  if (InputFile::try_open(path)) {
    bool replaceable = false;
    try {
      replaceable = is_record_file(path) && is_plan(parse_json(RecordFile(path).head(), path));
    } catch (const InputError&) {
    }
    if (!replaceable) {
      throw UsageError("-o {}: it is not a plan and would be replaced; name another file", path);
    }
  }
  check_writable(path);
}

void write_sample_plan(const std::string& path, const Json& head, const SamplePlan& plan) {
  Json marked = head;
  marked["settings"][kMark] = "counts";
  // Without these members, every machine that makes the plan writes the same bytes.
  marked.erase("machine");
  marked.erase("files");
  AtomicFile file(path);
  write_record_blocks(file,
                      pack_file_head(marked.dump(2, ' ', false, Json::error_handler_t::replace)),
                      std::as_bytes(std::span(plan.counts)));
  file.commit();
}

SamplePlanFile::SamplePlanFile(const RenderOptions& options, const LoadLimits& limits)
    : path_(options.plan) {
  is_exr(path_) ? read_picture(options, limits) : read_plan(options, limits);
}

// Checks that the file's pixels, `planned`, contain the frame's crop. Then reserves memory for
// their counts, twice, because they are first read as bytes.
std::shared_ptr<SamplePlan> SamplePlanFile::reserve_counts(const RenderOptions& options,
                                                           const Rect& planned, int width,
                                                           int height, const LoadLimits& limits) {
  const Rect crop = crop_of(options);
  if (width != options.width || height != options.height) {
    throw InputError(path_, "it was made for a frame of {}x{} pixels, but this frame has {}x{}",
                     width, height, options.width, options.height);
  }
  // The file may have any crop, so it is checked before its area is used.
  if (planned.x0 < 0 || planned.y0 < 0 || planned.x1 > width || planned.y1 > height ||
      planned.empty()) {
    throw InputError(path_, "its crop is not inside the frame");
  }
  if (planned.intersect(crop) != crop) {
    throw InputError(
        path_, "it was made for the pixels {},{},{},{}, but this frame has {},{},{},{}", planned.x0,
        planned.y0, planned.x1, planned.y1, crop.x0, crop.y0, crop.x1, crop.y1);
  }
  memory_ = MemoryReservation(limits.memory, MemoryPart::kFilm,
                              bytes_of(uint64_t(planned.area()), 2 * sizeof(uint32_t)), path_);
  auto plan = std::make_shared<SamplePlan>();
  plan->crop = planned;
  plan->counts.resize(size_t(planned.area()));
  return plan;
}

void SamplePlanFile::check_counts(const SamplePlan& plan) const {
  if (std::ranges::any_of(plan.counts, [](uint32_t n) { return n < 1 || n > kMaxSamples; })) {
    throw InputError(path_, "a pixel has an invalid number of samples; valid is 1 to {}",
                     kMaxSamples);
  }
}

void SamplePlanFile::read_plan(const RenderOptions& options, const LoadLimits& limits) {
  if (InputFile::try_open(path_) && !is_record_file(path_)) {
    throw InputError(path_, "it is not a plan; `emberline plan` writes plans");
  }
  const RecordFile file(path_);
  head_ = JsonValue(parse_json(file.head(), path_));
  if (!is_plan(*head_)) throw InputError(path_, "it is a checkpoint, not a plan");
  const FrameSettings planned = settings_of(*head_, path_);
  const auto plan =
      reserve_counts(options, crop_of(planned), planned.width, planned.height, limits);
  const uint64_t bytes = bytes_of(plan->counts.size(), sizeof(uint32_t));
  std::optional<std::vector<std::byte>> state;
  try {
    state = read_film_state(file, bytes);
  } catch (const InputError&) {
  }
  const auto is_intact = [&](const RecordEntry& record) { return file.is_intact(record); };
  if (!state || state->size() != bytes || !std::ranges::all_of(file.records(), is_intact)) {
    throw InputError(path_, "the plan is damaged or truncated");
  }
  std::memcpy(plan->counts.data(), state->data(), bytes);
  check_counts(*plan);
  plan_ = plan;
}

void SamplePlanFile::read_picture(const RenderOptions& options, const LoadLimits& limits) {
  const LoadProgress progress({}, {}, limits);
  FloatImageRows file(path_, progress);
  const FloatImage& image = file.image();
  const int channel = image.find_channel("samples");
  if (channel < 0) throw InputError(path_, "it has no channel samples, so it is not a plan");
  const std::vector<std::string> list = sample_changes(file, options, path_);
  if (!list.empty()) {
    throw InputError(path_, "its samples are not those of this frame: {}", fmt::join(list, "; "));
  }
  const auto plan =
      reserve_counts(options, image.data_window, image.frame_width, image.frame_height, limits);
  std::vector<float> values;
  const auto channels = size_t(image.channels());
  const int most_rows = std::min(file.rows_at_once(), image.height);
  const MemoryReservation memory(
      limits.memory, MemoryPart::kTextures,
      bytes_of(uint64_t(image.width) * uint64_t(most_rows), channels * sizeof(float)), path_);
  for (int y = 0; y < image.height;) {
    const int rows = std::min(most_rows, image.height - y);
    file.read(rows, values);
    uint32_t* const counts = &plan->counts[size_t(y) * size_t(image.width)];
    for (size_t i = 0; i < size_t(rows) * size_t(image.width); ++i) {
      const float samples = values[i * channels + size_t(channel)];
      // Anything but a whole number becomes 0, which is invalid.
      const bool is_count = samples >= 1.0f && samples <= float(kMaxSamples);
      counts[i] = is_count && samples == std::floor(samples) ? uint32_t(samples) : 0;
    }
    y += rows;
  }
  check_counts(*plan);
  plan_ = plan;
}

void SamplePlanFile::check(const Json& now) const {
  if (head_->is_null()) return;
  Json frame = now;
  frame["inputs"].erase(plan_input_name());
  const std::vector<std::string> list =
      differences(frame, *head_,
                  {kMark, "crop", "part", "bucket-size", "bucket-order", "aov", "cryptomatte",
                   "cryptomatte-levels", "light-groups", "isa"});
  if (has_halves(frame) && !has_halves(*head_)) {
    throw InputError(path_, "it was made without `denoise`; make a new plan with `denoise`");
  }
  if (list.empty()) return;
  throw InputError(path_, "this plan was made for another frame: {}; make a new plan",
                   fmt::join(list, "; "));
}

}  // namespace emberline
