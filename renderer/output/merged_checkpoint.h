// `merge --resumable`: writes a checkpoint of the merged frame, so that `extend` can add samples.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "io/files/atomic_file.h"
#include "renderer/output/frame_merge.h"

namespace emberline {

// Writes the same head and tile records as `render --resumable` would for the whole frame.
class MergedCheckpoint {
 public:
  // The path is checkpoint_path() of the merged frame's options. If a file exists there, locks it
  // until commit() replaces it. Throws InputError if a frame that was merged from these parts
  // cannot be extended. Throws RenderError if the path is not writable or another run has locked
  // the file. Throws UsageError if the checkpoint would replace a file of another kind or, through
  // a link, another frame's checkpoint.
  MergedCheckpoint(const RenderOptions& options, const FrameMerge& frame);

  const std::string& path() const { return file_->path(); }
  // For the argument `save` of FrameMerge::deliver(). Thread-safe. If writing fails, stores the
  // error for commit().
  void save(size_t tile, std::span<const std::byte> state);
  // Throws RenderError.
  void commit();

 private:
  std::optional<LockedFile> replaced_;
  std::optional<AtomicFile> file_;
  std::atomic<uint64_t> end_;
  std::mutex mutex_;
  std::string failure_;  // message of the last failure in save()
};

}  // namespace emberline
