// Memory and load-time limits of a run.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// Ranges of --threads and --load-timeout. The timeout is in seconds, from a millisecond to thirty
// years.
inline constexpr int kMaxThreads = 4096;
inline constexpr double kMinLoadTimeout = 0.001, kMaxLoadTimeout = 1e9;

struct LimitOptions {
  std::optional<uint64_t> memory_bytes;        // absent: default_memory_limit()
  std::optional<double> load_timeout_s;        // absent: none
  std::optional<uint64_t> texture_bytes = {};  // absent: all textures stay in memory
};

// Returns limits with a new budget. The timeout starts when a LoadProgress is created with these
// limits.
LoadLimits limits_of(const LimitOptions& options, const std::string& scene);

// Returns limits for reading back a picture of this many pixels. Another file may have replaced the
// picture, so its size is not trusted.
LoadLimits read_back_limits(int64_t pixels);

// Throws InputError if the memory estimates were too low: if the peak memory of the process,
// without its libraries, has grown from `before` by more than the limit plus 10 %.
void check_memory_growth(uint64_t before, const MemoryBudget& budget, const std::string& scene);

// Raises this process's open-file limit to the system's maximum.
void raise_open_file_limit();

// Returns three quarters of the machine's memory, or of the limit set by a container, the shell or
// a Slurm job. Uses the total memory rather than the free memory, so that loading does not depend
// on other processes.
uint64_t default_memory_limit();

// Returns the lowest limit that a process's control groups set, or nothing if they set none.
// Supports versions 1 and 2 (Linux: Documentation/admin-guide/cgroup-v2.rst and
// cgroup-v1/memory.rst). `groups` is the text of /proc/self/cgroup; `root` is the mount point.
std::optional<uint64_t> cgroup_memory_limit(std::string_view groups,
                                            const std::filesystem::path& root);

}  // namespace emberline
