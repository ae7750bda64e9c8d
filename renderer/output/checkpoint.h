// What there is of a frame, in a file, so that a later run goes on from there to the same bits.
//
// A frame of tiles appends each as it is finished; another replaces the whole file from time to
// time. The file (io/files/record_file.h) has a head in JSON (checkpoint_head.h):
//   "bits"        kBitsVersion; "emberline" the version for people
//   "settings"    all that decide bits, as texts by name (setting_table.h); "schedule" the others
//   "inputs"      fingerprints of the files that were read; "files" where they were
//   "machine"     host, instruction sets, processor's maker, Embree's version
//   "light layers"  names, with light groups
// and records. Of tiles: one each, whose bytes are those of a TileResult, the film and the driver's
// state; of two of one tile the later counts. Of one film: blocks of at most 4 MiB that together
// are what RenderJob::save() makes, and an empty record behind the last. What these classes save
// is theirs to say (archive()); numbers are the machine's own, little-endian.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
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

// Kinds of records. A tile's number is its own (bucket_number()); of a frame of one film, blocks of
// its state are numbered from 0 on, and an empty record with their number ends them.
inline constexpr uint32_t kTileRecord = 1, kBlockRecord = 2, kEndRecord = 3;

// Refuses a name under which there is another file than a checkpoint, or a link to nothing: it
// would be replaced, or made through the link. Throws UsageError; InputError for a file that
// `resume` is to go on with.
void check_checkpoint(const std::string& path, bool resume);

// Whether a name may hold what an earlier run of this output has left, whatever its settings:
// OUTPUT.checkpoint, and no link, which may be the file of another frame.
bool is_own_checkpoint(const RenderOptions& options);
// Refuses to begin a checkpoint anew that is of another frame and not this output's own. A `head`
// without "inputs" is compared in its settings alone. Throws UsageError.
void check_begins_anew(const std::string& path, const nlohmann::json& head);

// Of a frame of one film, at most so many bytes; nothing if none was saved yet. Throws InputError.
std::optional<std::vector<std::byte>> film_state(const RecordFile& file, uint64_t most);

struct CheckpointReport {
  std::string file;                          // empty: none was asked for
  int written = 0;                           // how often; of a frame of tiles: brought to the disk
  uint64_t bytes = 0;                        // the file's last size
  double paused_s = 0, longest_pause_s = 0;  // while nothing rendered
  bool kept = false;
  std::string error;  // why not all is saved that was to be; empty: all is
};

struct CheckpointOptions {
  std::string path;
  bool by_tiles = false;
  bool resume = false;      // goes on with one that is there
  double interval_s = 300;  // between two
  bool own = true;          // is_own_checkpoint()
  // The checkpoint of an equal frame that is finished, and had fewer samples or a higher threshold:
  // it goes on in this one, which takes its place when it is done. Empty: none.
  std::string finished;
  // Whether a checkpoint was asked for since this was asked last. Any thread. Empty: nobody does.
  std::function<bool()> save_now = {};
};

class Checkpoint final : public TileStore {
 public:
  // Takes the file for this run, which goes on with what is there or begins a new one. Throws
  // RenderError where another run has it or it cannot be written, InputError for one that is
  // damaged or of another frame: with the list of what differs.
  Checkpoint(const CheckpointOptions& options, const nlohmann::json& head);
  ~Checkpoint() override;

  bool goes_on() const { return earlier_ != nullptr; }

  // Tiles: any thread.
  std::optional<std::vector<std::byte>> load(size_t tile, uint64_t most) override;
  std::optional<std::vector<std::byte>> load_finished(size_t tile, uint64_t most) override;
  void unusable(bool finished) override;
  void save(size_t tile, std::span<const std::byte> state) override;

  // Before the job renders: it goes on with what an earlier run has left, or with the frame that is
  // extended, whose states are of at most `most` bytes. Throws InputError that names the file.
  void begin(RenderJob& job, uint64_t most);
  // One film: whether it is time to save. Then the job is to pause. Any thread.
  bool wanted() const;
  // Copies the frame at once and writes it behind, when the one before is written.
  void save(RenderJob& job);

  // Waits until all is on the disk. The file goes if it is not to be kept. It takes the place of
  // what was extended if the frame is done and the file whole.
  CheckpointReport finish(bool done, bool keep);

 private:
  void begin_film(RenderJob& job, uint64_t most);
  void copies(uint64_t film_bytes);
  void run();
  void end_thread();
  void touch_copy();
  void write_behind(const std::vector<std::byte>& state);
  void sync_tiles();
  void failed(const std::string& error);
  void check_file();
  bool asked() const;

  const std::string path_;
  const std::string head_;
  const double interval_s_;
  std::unique_ptr<LockedFile> file_;
  std::unique_ptr<RecordFile> earlier_;   // what was there
  std::unique_ptr<RecordFile> finished_;  // what is extended
  std::unordered_map<uint64_t, RecordEntry> tiles_, finished_tiles_;
  CheckpointReport report_;
  Stopwatch clock_;
  std::atomic<double> next_s_;
  const std::function<bool()> save_now_;
  mutable std::atomic<bool> asked_{false};
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::byte> copy_;  // to be written; the thread's alone while it is busy
  uint64_t copy_bytes_ = 0;
  bool writing_ = false, ending_ = false, warned_ = false, tiles_waiting_ = false;
  bool made_ = false;              // by this run
  std::string error_;              // why not all is saved
  std::atomic<bool> busy_{false};  // with the copy
  std::thread thread_;
};

}  // namespace emberline
