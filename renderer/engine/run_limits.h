// Limits of a run: memory and load time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// Ranges of --threads and --load-timeout, the latter in seconds: a millisecond to thirty years.
inline constexpr int kMostThreads = 4096;
inline constexpr double kLeastLoadTimeout = 0.001, kMostLoadTimeout = 1e9;

struct LimitOptions {
  std::optional<uint64_t> memory_bytes;        // absent: default_memory_limit()
  std::optional<double> load_timeout_s;        // absent: none
  std::optional<uint64_t> texture_bytes = {};  // absent: all of them are held in memory
};

// A new budget. The time runs from the LoadProgress that gets the limits.
LoadLimits limits_of(const LimitOptions& options, const std::string& scene);

// Limits for reading a picture of this many pixels that a run wrote: no more than such a picture
// takes, since another file may have replaced it.
LoadLimits limits_of_own_picture(int64_t pixels);

// Throws InputError if the process has grown by more than the limit and a tenth since its peak was
// `before`, apart from its libraries' own memory: the check behind all estimates.
void check_growth(uint64_t before, const MemoryBudget& budget, const std::string& scene);

// As many open files as the system lets this process have.
void allow_many_files();

// Three quarters of the memory of the machine, or of the limit set by a container, the shell or a
// Slurm job. Counts all memory, not only free memory: whether a scene loads must not depend on
// other processes.
uint64_t default_memory_limit();

// The least limit that the control groups of a process set, of both versions (Linux:
// Documentation/admin-guide/cgroup-v2.rst and cgroup-v1/memory.rst); absent: none. `groups` is the
// text of /proc/self/cgroup, `root` where the groups are mounted.
std::optional<uint64_t> cgroup_memory_limit(std::string_view groups,
                                            const std::filesystem::path& root);

}  // namespace emberline
