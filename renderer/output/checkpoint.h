// Saves an unfinished frame to a file, so that a later run can resume it with a bit-identical
// result.
//
// A tiled frame appends each tile to the file when the tile is finished. A frame with one film
// replaces the whole file at intervals. The file (io/files/record_file.h) starts with a JSON head
// (checkpoint_head.h):
//   "bits"        kBitsVersion; "emberline" has the readable version
//   "settings"    settings that affect the bits, by name (setting_table.h)
//   "schedule"    the other settings
//   "inputs"      fingerprints of the input files; "files" has their paths
//   "machine"     host, instruction sets, processor maker, Embree version
//   "light layers"  layer names, if there are light groups
// Records follow the head. A tiled frame has one record per tile, with the bytes of the TileResult,
// of the tile's film and of the driver's state. If a tile has two records, the later record counts.
// A frame with one film stores the result of RenderJob::save() in blocks of at most 4 MiB, followed
// by an empty end record. Each class defines its byte layout in archive(). Numbers are in native
// byte order (little-endian).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "io/files/atomic_file.h"
#include "io/files/record_file.h"
#include "renderer/engine/render_clock.h"
#include "renderer/engine/render_job.h"
#include "renderer/output/render_options.h"

namespace emberline {

// The kinds of records. The number of a tile record is the tile's bucket_index(). Block records are
// numbered from 0, and the end record has the next number.
inline constexpr uint32_t kTileRecord = 1, kBlockRecord = 2, kEndRecord = 3;

// Throws UsageError (with `resume`: InputError) if saving to the path would replace a file that is
// not a checkpoint, or would create the target of a dangling link.
void check_checkpoint(const std::string& path, bool resume);

// Whether the checkpoint's path is the default path, OUTPUT.checkpoint. A frame may replace a
// checkpoint at its default path even if the settings differ. Returns false if the file is a
// symbolic link or has several hard links, because it could then be another frame's checkpoint.
bool is_default_checkpoint(const RenderOptions& options);
// Throws UsageError if a new checkpoint with this head would replace a damaged checkpoint or the
// checkpoint of another frame. Does not compare "inputs" if `head` has none.
void check_overwrite(const std::string& path, const nlohmann::json& head);

// Returns the saved state of a frame with one film, or nullopt if none was saved. Throws InputError
// if the state is damaged or larger than `max_bytes` bytes.
std::optional<std::vector<std::byte>> read_film_state(const RecordFile& file, uint64_t max_bytes);

// Writes a packed head (pack_file_head()) and the bytes in blocks, for read_film_state(). Throws
// RenderError.
void write_record_blocks(AtomicFile& file, const std::string& head,
                         std::span<const std::byte> bytes);

struct CheckpointReport {
  std::string file;    // empty: no checkpoint was requested
  int written = 0;     // number of saves; for a tiled frame, number of syncs to disk
  uint64_t bytes = 0;  // final file size
  double paused_s = 0, longest_pause_s = 0;  // total and longest pause of rendering
  bool kept = false;
  std::string error;  // why the save is incomplete; empty if it is complete
};

struct CheckpointOptions {
  std::string path;
  bool is_tiled = false;
  bool resume = false;      // resume from an existing file
  double interval_s = 300;  // between two saves
  bool is_default = true;   // result of is_default_checkpoint()
  // Path of the checkpoint of the finished frame that this frame extends; empty if it extends none.
  // The finished frame has fewer samples or a higher threshold; its other settings are the same.
  // When this frame is done, its own checkpoint replaces that of the finished frame.
  std::string finished;
  // Returns whether a save was requested since the last call. Any thread may call it. May be empty.
  std::function<bool()> save_now = {};
};

class Checkpoint final : public TileStore {
 public:
  // Locks the file. Then resumes from its contents or starts a new checkpoint. Throws RenderError
  // if another run has locked the file or if the file cannot be written. Throws InputError if the
  // file is damaged or belongs to another frame; the message lists the differences.
  Checkpoint(const CheckpointOptions& options, const nlohmann::json& head);
  ~Checkpoint() override;

  bool is_resumed() const { return resumed_ != nullptr; }

  // The next four functions are for tiled frames. They are thread-safe.
  std::optional<std::vector<std::byte>> load(size_t tile, uint64_t max_bytes) override;
  std::optional<std::vector<std::byte>> load_finished(size_t tile, uint64_t max_bytes) override;
  void report_unusable(bool finished) override;
  void save(size_t tile, std::span<const std::byte> state) override;

  // Makes the job resume from an earlier run or from the frame that it extends. Call before the
  // job renders. The saved state must not be larger than `max_bytes` bytes. Throws an InputError
  // that names the file.
  void begin(RenderJob& job, uint64_t max_bytes);
  // Whether a save is due. Only for frames with one film. The job must pause before it is saved.
  // Thread-safe.
  bool is_due() const;
  // Waits until the previous write has finished. Then copies the frame's state, and writes the copy
  // in the background.
  void save(RenderJob& job);

  // Waits until everything is on disk. Removes the file unless `keep` is set. If the frame extends
  // another frame, moves the file over that frame's checkpoint, provided that this frame is done
  // and its file is intact.
  CheckpointReport finish(bool done, bool keep);

 private:
  void begin_film(RenderJob& job, uint64_t max_bytes);
  void set_copy_size(uint64_t film_bytes);
  void run();
  void end_thread();
  void prefault_copy();
  void write_state(const std::vector<std::byte>& state);
  void sync_tiles();
  void record_failure(const std::string& error);
  void check_file();
  bool is_save_requested() const;

  const std::string path_;
  const std::string head_;
  const double interval_s_;
  std::unique_ptr<LockedFile> file_;
  std::unique_ptr<RecordFile> resumed_;   // the file that an earlier run left
  std::unique_ptr<RecordFile> extended_;  // checkpoint of the frame that is extended
  std::unordered_map<uint64_t, RecordEntry> tiles_, extended_tiles_;
  CheckpointReport report_;
  Stopwatch clock_;
  std::atomic<double> next_s_;
  const std::function<bool()> save_now_;
  mutable std::atomic<bool> save_requested_{false};
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::byte> copy_;  // state to be written; while busy_ is set, only thread_ uses it
  uint64_t copy_bytes_ = 0;
  bool writing_ = false, ending_ = false, warned_ = false, has_unsynced_tiles_ = false;
  bool created_ = false;           // the file was created by this run
  std::string error_;              // why the save is incomplete
  std::atomic<bool> busy_{false};  // thread_ is using copy_
  std::thread thread_;
};

}  // namespace emberline
