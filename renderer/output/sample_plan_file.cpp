#include "renderer/output/sample_plan_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/files/record_file.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/drivers/driver_choices.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/checkpoint_head.h"

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
  if (InputFile::try_open(path_) && !is_record_file(path_)) {
    throw InputError(path_, "it is not a plan; `emberline plan` writes plans");
  }
  const RecordFile file(path_);
  head_ = JsonValue(parse_json(file.head(), path_));
  if (!is_plan(*head_)) throw InputError(path_, "it is a checkpoint, not a plan");
  const FrameSettings planned = settings_of(*head_, path_);
  auto plan = std::make_shared<SamplePlan>();
  plan->crop = crop_of(planned);
  const Rect crop = crop_of(options);
  if (planned.width != options.width || planned.height != options.height) {
    throw InputError(path_, "it was made for a frame of {}x{} pixels, but this frame has {}x{}",
                     planned.width, planned.height, options.width, options.height);
  }
  // The file may have any crop, so it is checked before its area is used.
  if (plan->crop.x0 < 0 || plan->crop.y0 < 0 || plan->crop.x1 > planned.width ||
      plan->crop.y1 > planned.height || plan->crop.empty()) {
    throw InputError(path_, "its crop is not inside the frame");
  }
  if (plan->crop.intersect(crop) != crop) {
    throw InputError(path_,
                     "it was made for the pixels {},{},{},{}, but this frame has {},{},{},{}",
                     plan->crop.x0, plan->crop.y0, plan->crop.x1, plan->crop.y1, crop.x0, crop.y0,
                     crop.x1, crop.y1);
  }
  const uint64_t pixels = uint64_t(plan->crop.area()), bytes = bytes_of(pixels, sizeof(uint32_t));
  // The counts are read as bytes first.
  memory_ = MemoryReservation(limits.memory, MemoryPart::kFilm,
                              bytes_of(pixels, 2 * sizeof(uint32_t)), path_);
  std::optional<std::vector<std::byte>> state;
  try {
    state = read_film_state(file, bytes);
  } catch (const InputError&) {
  }
  const auto is_intact = [&](const RecordEntry& record) { return file.is_intact(record); };
  if (!state || state->size() != bytes || !std::ranges::all_of(file.records(), is_intact)) {
    throw InputError(path_, "the plan is damaged or truncated");
  }
  plan->counts.resize(size_t(plan->crop.area()));
  std::memcpy(plan->counts.data(), state->data(), bytes);
  if (std::ranges::any_of(plan->counts, [](uint32_t n) { return n < 1 || n > kMaxSamples; })) {
    throw InputError(path_, "a pixel has an invalid number of samples; valid is 1 to {}",
                     kMaxSamples);
  }
  plan_ = std::move(plan);
}

void SamplePlanFile::check(const Json& now) const {
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
