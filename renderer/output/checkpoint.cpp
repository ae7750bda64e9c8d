#include "renderer/output/checkpoint.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/zeroed_array.h"
#include "renderer/output/checkpoint_head.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

constexpr uint64_t kBlockBytes = uint64_t(4) << 20;

// Throws an InputError that lists the differences if the head `now` differs from the file's head.
// Warns if only the processor maker or the Embree version differs.
void check_frame(const RecordFile& file, const Json& now,
                 std::initializer_list<std::string_view> ignored = {}) {
  const Json then = parse_json(file.head(), file.path());
  if (const std::vector<std::string> list = differences(now, then, ignored); !list.empty()) {
    throw InputError(file.path(),
                     "this checkpoint belongs to another frame: {}; use the same settings, or "
                     "remove the checkpoint",
                     fmt::join(list, "; "));
  }
  for (const std::string& difference : machine_differences(now, then)) {
    log_warning(fmt::format("{}: it was made with {}; the result may differ in the last bits",
                            file.path(), difference));
  }
}

using Tiles = std::unordered_map<uint64_t, RecordEntry>;

Tiles tiles_of(const RecordFile& file) {
  Tiles tiles;
  for (const RecordEntry& record : file.records()) {
    if (record.kind == kTileRecord) tiles.insert_or_assign(record.number, record);
  }
  return tiles;
}

// If several records have the same kind and number, checks only the last one, because readers
// ignore the earlier ones. Holds one record in memory at a time.
bool all_records_intact(const RecordFile& file) {
  std::map<std::pair<uint32_t, uint64_t>, RecordEntry> records;
  for (const RecordEntry& record : file.records()) {
    records.insert_or_assign({record.kind, record.number}, record);
  }
  return std::ranges::all_of(records,
                             [&](const auto& entry) { return file.is_intact(entry.second); });
}

void warn_truncated(const std::string& path) {
  log_warning(path + ": it is truncated; the missing tiles are rendered again");
}

void warn_lost_tiles(const std::string& why) {
  log_warning(why + "; the lost tiles are rendered again");
}

// Returns nullopt if the file does not have the tile. If the tile is damaged, also warns.
std::optional<std::vector<std::byte>> load_tile(const RecordFile* file, const Tiles& tiles,
                                                size_t tile, uint64_t max_bytes) {
  const auto at = tiles.find(tile);
  if (at == tiles.end()) return std::nullopt;
  try {
    return file->read(at->second, max_bytes);
  } catch (const InputError& error) {
    warn_lost_tiles(error.what());
    return std::nullopt;
  }
}

}  // namespace

bool is_part(const FrameSettings& settings) {
  return settings.part.has_value() || settings.sample_range.has_value();
}

bool retains_checkpoint(const RenderOptions& options) {
  return options.resumable || is_part(options);
}

std::string checkpoint_path(const RenderOptions& options) {
  if (!options.checkpoint.empty()) return options.checkpoint;
  if (options.outputs.empty() || !(retains_checkpoint(options) || options.resume)) return "";
  std::string path = options.outputs.front();
  if (options.part) path += fmt::format(".part-{}-of-{}", options.part->index, options.part->count);
  if (options.sample_range) {
    path += fmt::format(".samples-{}-{}", options.sample_range->first, options.sample_range->end);
  }
  return path + ".checkpoint";
}

void check_checkpoint(const std::string& path, bool resume) {
  std::error_code none;
  const bool link = std::filesystem::is_symlink(std::filesystem::symlink_status(path, none));
  const bool file_exists = InputFile::try_open(path).has_value();
  if (file_exists ? is_record_file(path) : !link) return;
  if (!file_exists && resume) throw InputError(path, "it is a link to a file that does not exist");
  if (!file_exists) {
    throw UsageError("`checkpoint` {}: it is a link to a file that does not exist; name a file",
                     path);
  }
  if (resume) throw InputError(path, "it is not an Emberline checkpoint");
  throw UsageError(
      "`checkpoint` {}: it is not an Emberline checkpoint and would be replaced; name another file",
      path);
}

bool is_default_checkpoint(const RenderOptions& options) {
  if (options.outputs.empty()) return false;
  RenderOptions unnamed = options;
  unnamed.checkpoint.clear();
  unnamed.resumable = true;
  const std::string path = checkpoint_path(options);
  const auto normalized = [](const std::string& name) {
    return std::filesystem::absolute(name).lexically_normal();
  };
  std::error_code none;
  return normalized(path) == normalized(checkpoint_path(unnamed)) &&
         !std::filesystem::is_symlink(std::filesystem::symlink_status(path, none)) &&
         (!std::filesystem::exists(path, none) ||
          std::filesystem::hard_link_count(path, none) == 1);
}

void check_overwrite(const std::string& path, const Json& head) {
  if (!InputFile::try_open(path)) return;
  std::string why = "the checkpoint is damaged";
  try {
    const RecordFile file(path);
    if (file.records().empty() && !file.has_more()) return;  // replacing it loses nothing
    const Json then = parse_json(file.head(), path);
    Json now = head;
    if (!now.contains("inputs") && then.is_object()) now["inputs"] = then.value("inputs", Json());
    const std::vector<std::string> list = differences(now, then);
    if (list.empty()) return;
    why = fmt::format("this checkpoint belongs to another frame: {}", fmt::join(list, "; "));
  } catch (const InputError&) {
  }
  throw UsageError(
      "`checkpoint` {}: {}; this run would replace it; name another file, or remove the old "
      "checkpoint",
      path, why);
}

std::optional<std::vector<std::byte>> read_film_state(const RecordFile& file, uint64_t max_bytes) {
  const std::span<const RecordEntry> records = file.records();
  const auto damaged = [&] {
    return InputError(file.path(), "the checkpoint is damaged or truncated");
  };
  if (records.empty() && !file.has_more()) return std::nullopt;
  if (records.empty() || file.has_more() || records.back().kind != kEndRecord ||
      records.back().number != records.size() - 1) {
    throw damaged();
  }
  uint64_t size = 0;
  for (const RecordEntry& record : records) {
    if (record.bytes > max_bytes - size) throw damaged();
    size += record.bytes;
  }
  std::vector<std::byte> state;
  state.reserve(size);
  for (size_t i = 0; i + 1 < records.size(); ++i) {
    if (records[i].kind != kBlockRecord || records[i].number != i) throw damaged();
    const std::vector<std::byte> block = file.read(records[i], kBlockBytes);
    state.insert(state.end(), block.begin(), block.end());
  }
  return state;
}

void write_record_blocks(AtomicFile& file, const std::string& head,
                         std::span<const std::byte> bytes) {
  uint64_t at = 0, blocks = 0;
  const auto append = [&](const std::string& piece) {
    file.write_at(piece.data(), piece.size(), at);
    at += piece.size();
  };
  append(head);
  for (size_t begin = 0; begin < bytes.size(); begin += kBlockBytes, ++blocks) {
    const size_t size = std::min<size_t>(kBlockBytes, bytes.size() - begin);
    append(pack_record(kBlockRecord, blocks, bytes.subspan(begin, size)));
  }
  append(pack_record(kEndRecord, blocks, {}));
}

Checkpoint::Checkpoint(const CheckpointOptions& options, const Json& head)
    : path_(options.path),
      head_(pack_file_head(head.dump(2, ' ', false, Json::error_handler_t::replace))),
      interval_s_(options.interval_s),
      next_s_(options.interval_s),
      save_now_(options.save_now) {
  report_.file = path_;
  if (!options.finished.empty()) {
    extended_ = std::make_unique<RecordFile>(options.finished);
    check_frame(*extended_, head, {"spp", "noise-threshold", "min-spp", "max-spp"});
    extended_tiles_ = tiles_of(*extended_);
    if (options.is_tiled && extended_->has_more()) warn_truncated(extended_->path());
  }
  check_checkpoint(path_, options.resume);
  const bool file_exists = InputFile::try_open(path_).has_value();
  created_ = !file_exists;
  file_ = file_exists ? std::make_unique<LockedFile>(path_)
                      : std::make_unique<LockedFile>(path_, head_);
  if (file_exists && options.resume) resumed_ = std::make_unique<RecordFile>(path_);
  // An existing file without records has nothing to resume.
  if (resumed_ && resumed_->end() == file_->size() && resumed_->records().empty()) {
    resumed_.reset();
  }
  if (resumed_) {
    check_frame(*resumed_, head);
    tiles_ = tiles_of(*resumed_);
    if (options.is_tiled && resumed_->has_more()) {
      warn_truncated(path_);
      file_->truncate(resumed_->end());
    }
  } else if (file_exists) {
    if (!options.resume && !options.is_default) check_overwrite(path_, head);
    if (!options.resume) log_info(path_ + ": the frame starts over, because `resume` is not given");
    file_->replace([this](AtomicFile& file) { file.write_at(head_.data(), head_.size(), 0); });
  }
  report_.bytes = file_->size();
  thread_ = std::thread([this] { run(); });
}

// Does nothing after finish(). If finish() was not called, because of an error, completes pending
// writes, and removes the file if this run created it and saved nothing.
Checkpoint::~Checkpoint() {
  if (!thread_.joinable()) return;
  try {
    end_thread();
    finish(false, !created_ || file_->size() > head_.size());
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
}

std::optional<std::vector<std::byte>> Checkpoint::load(size_t tile, uint64_t max_bytes) {
  return load_tile(resumed_.get(), tiles_, tile, max_bytes);
}

std::optional<std::vector<std::byte>> Checkpoint::load_finished(size_t tile, uint64_t max_bytes) {
  return load_tile(extended_.get(), extended_tiles_, tile, max_bytes);
}

void Checkpoint::report_unusable(bool finished) {
  warn_lost_tiles((finished ? *extended_ : *resumed_).path() + ": the checkpoint is damaged");
}

void Checkpoint::save(size_t tile, std::span<const std::byte> state) {
  try {
    const std::string record = pack_record(kTileRecord, tile, state);
    const std::lock_guard lock(mutex_);
    file_->append(record);
    has_unsynced_tiles_ = true;
    report_.bytes = file_->size();
  } catch (const std::exception& error) {  // including std::bad_alloc
    const std::lock_guard lock(mutex_);
    record_failure(error.what());
  }
}

// Rendering continues, because a failed save matters only if this run ends early.
void Checkpoint::record_failure(const std::string& error) {
  error_ = error;
  if (!warned_ && !ending_)
    log_warning(error + "; the frame continues, but unsaved work is lost if the program ends");
  warned_ = true;
}

void Checkpoint::begin(RenderJob& job, uint64_t max_bytes) {
  job.is_tiled() ? job.set_tile_store(this) : begin_film(job, max_bytes);
}

void Checkpoint::begin_film(RenderJob& job, uint64_t max_bytes) {
  job.make_resumable();
  set_copy_size(job.film_bytes());
  const auto state = resumed_ ? read_film_state(*resumed_, max_bytes) : std::nullopt;
  const auto finished = !state && extended_ ? read_film_state(*extended_, max_bytes) : std::nullopt;
  try {
    if (state) job.load(*state);
    if (finished) job.extend(*finished);
  } catch (const InputError& error) {
    throw InputError(state ? path_ : extended_->path(), error.what());
  }
}

bool Checkpoint::is_save_requested() const {
  if (save_now_ && save_now_()) save_requested_ = true;
  return save_requested_;
}

bool Checkpoint::is_due() const {
  return !busy_.load(std::memory_order_relaxed) &&
         (clock_.seconds() >= next_s_.load(std::memory_order_relaxed) || is_save_requested());
}

void Checkpoint::save(RenderJob& job) {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [&] { return !busy_; });  // a caller that checked is_due() does not wait
  const Stopwatch pause;
  save_requested_ = false;
  next_s_ = clock_.seconds() + interval_s_;
  try {
    copy_.reserve(copy_bytes_);
    job.save(copy_);
  } catch (const std::bad_alloc&) {
    copy_ = {};
    return record_failure(path_ + ": not enough memory for a copy of the frame");
  }
  writing_ = true;
  busy_ = true;
  report_.paused_s += pause.seconds();
  report_.longest_pause_s = std::max(report_.longest_pause_s, pause.seconds());
  lock.unlock();
  wake_.notify_all();
}

// Sets the expected size of a copy. The background thread then allocates and touches the memory
// before the first save, while the workers render. The first access to new memory takes longer than
// the copying itself.
void Checkpoint::set_copy_size(uint64_t film_bytes) {
  const std::lock_guard lock(mutex_);
  copy_bytes_ = film_bytes + film_bytes / 8;  // leaves room for the driver's state, which grows
}

void Checkpoint::prefault_copy() {
  try {
    std::vector<std::byte> copy;
    copy.reserve(copy_bytes_);
    advise_huge_pages(copy.data(), copy.capacity());
    copy.resize(copy_bytes_);
    copy_ = std::move(copy);
  } catch (const std::bad_alloc&) {  // then the first save allocates the memory
    copy_bytes_ = 0;
  }
}

void Checkpoint::write_state(const std::vector<std::byte>& state) {
  file_->replace([&](AtomicFile& file) { write_record_blocks(file, head_, state); });
  report_.bytes = file_->size();
  ++report_.written;
}

void Checkpoint::sync_tiles() {
  try {
    file_->sync();
    ++report_.written;
  } catch (const RenderError& error) {
    const std::lock_guard lock(mutex_);
    record_failure(error.what());
  }
}

void Checkpoint::run() {
  constexpr auto kPoll = std::chrono::milliseconds(100);
  std::unique_lock lock(mutex_);
  while (!ending_ || writing_ || has_unsynced_tiles_) {
    wake_.wait_for(lock, kPoll, [&] { return ending_ || writing_; });
    if (writing_) {
      lock.unlock();
      std::string why;
      try {
        write_state(copy_);
      } catch (const RenderError& error) {  // its message names the file
        why = error.what();
      } catch (const std::exception& error) {  // including std::bad_alloc
        why = path_ + ": " + error.what();
      }
      lock.lock();
      error_.clear();  // each write replaces the whole file, so earlier errors no longer matter
      if (!why.empty()) record_failure(why);
      writing_ = false;
      busy_ = false;
      wake_.notify_all();
    }
    if (copy_.capacity() < copy_bytes_ && !ending_ &&
        clock_.seconds() >= next_s_ - interval_s_ / 2) {
      busy_ = true;
      lock.unlock();
      prefault_copy();
      lock.lock();
      busy_ = false;
      wake_.notify_all();
    }
    const bool due = ending_ || clock_.seconds() >= next_s_ || is_save_requested();
    if (!due || !has_unsynced_tiles_) continue;
    has_unsynced_tiles_ = false;
    save_requested_ = false;
    next_s_ = clock_.seconds() + interval_s_;
    lock.unlock();
    sync_tiles();
    lock.lock();
  }
}

// Reads the file back, because another program may have removed, replaced, truncated or overwritten
// it. A file that is truncated while this run appends to it has a hole.
void Checkpoint::check_file() {
  try {
    if (file_->owns_path()) {
      const RecordFile file(path_);
      const bool as_written = file.end() == file_->size() && !file.has_more();
      if (as_written && all_records_intact(file)) return;
      error_ = path_ + ": it was damaged during the render and does not hold the whole frame";
      return;
    }
    error_ = path_ + ": it was removed or replaced during the render";
  } catch (const InputError& error) {
    error_ = error.what();
  }
}

void Checkpoint::end_thread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

CheckpointReport Checkpoint::finish(bool done, bool keep) {
  end_thread();
  if (!keep) file_->remove();
  if (keep && error_.empty()) check_file();
  report_.error = error_;
  if (done && extended_ && error_.empty()) {
    check_checkpoint(extended_->path(), true);
    file_->rename_to(extended_->path());
    report_.file = extended_->path();
  }
  report_.kept = keep;
  return report_;
}

}  // namespace emberline
