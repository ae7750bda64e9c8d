#include "renderer/output/merged_checkpoint.h"

#include <nlohmann/json.hpp>

#include "io/files/input_file.h"
#include "io/files/record_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/checkpoint.h"
#include "renderer/output/frame_extension.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

// Throws InputError unless the merged frame can be extended. `extend` continues tile by tile, after
// the last sample of a single seed.
void check_mergeable(const FrameMerge& frame) {
  const StoredFrame& first = frame.first();
  if (!is_tiled(first.settings())) {
    throw InputError(first.path(),
                     "`resumable`: a frame merged from ranges of samples or from seeds can be "
                     "extended only with `driver` bucket; render its parts with `driver` bucket, "
                     "which gives the same picture");
  }
  for (const auto& part : frame.frames()) {
    if (part->plan().seed == first.plan().seed) continue;
    throw InputError(part->path(),
                     "`resumable`: its `seed` differs from that of {}, and an average over seeds "
                     "cannot be extended; instead, render more seeds and merge again",
                     first.path());
  }
  check_extensible(frame.settings(), first.path());
  if (!frame.complete()) {
    throw InputError(first.path(),
                     "`resumable`: a frame with holes cannot be extended; render the missing "
                     "parts first");
  }
}

// Converts the head of the first part to the head of the whole frame; see checkpoint_head().
Json whole_head(const FrameMerge& frame) {
  Json head = frame.first().head();
  const FrameSettings& part = frame.first().settings();
  Json& settings = head["settings"];
  if (part.part) {
    settings.erase("part");
    // The bucket order decides which buckets belong to a part, but does not affect the bits of the
    // whole frame.
    Json& schedule = head["schedule"];
    if (!schedule.is_object()) schedule = Json::object();
    if (settings.contains("bucket-order")) schedule["bucket-order"] = settings["bucket-order"];
    settings.erase("bucket-order");
  }
  if (part.sample_range) {
    settings.erase("sample-range");
    settings["spp"] = std::to_string(frame.settings().spp.value());
  }
  return head;
}

}  // namespace

MergedCheckpoint::MergedCheckpoint(const RenderOptions& options, const FrameMerge& frame)
    : end_(0) {
  check_mergeable(frame);
  const std::string path = checkpoint_path(options);
  check_checkpoint(path, false);
  const Json head_json = whole_head(frame);
  if (!is_default_checkpoint(options)) check_overwrite(path, head_json);
  if (InputFile::try_open(path)) {
    replaced_.emplace(path);
    log_info(path + " is replaced");
  }
  file_.emplace(path);
  const std::string head =
      pack_file_head(head_json.dump(2, ' ', false, Json::error_handler_t::replace));
  file_->write_at(head.data(), head.size(), 0);
  end_ = head.size();
}

void MergedCheckpoint::save(size_t tile, std::span<const std::byte> state) {
  try {
    const std::string record = pack_record(kTileRecord, tile, state);
    file_->write_at(record.data(), record.size(), end_.fetch_add(record.size()));
  } catch (const std::exception& error) {  // including std::bad_alloc
    const std::lock_guard lock(mutex_);
    failure_ = error.what();
  }
}

void MergedCheckpoint::commit() {
  if (!failure_.empty()) throw RenderError(failure_);
  file_->commit();
}

}  // namespace emberline
