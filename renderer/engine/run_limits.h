// What a run may take of the machine: --memory-limit and --load-timeout.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "renderer/core/load_progress.h"

namespace emberline {

// What --threads and --load-timeout take: the latter a millisecond to thirty years, in seconds.
inline constexpr int kMostThreads = 4096;
inline constexpr double kLeastLoadTimeout = 0.001, kMostLoadTimeout = 1e9;

struct LimitOptions {
  std::optional<uint64_t> memory_bytes;        // absent: default_memory_limit()
  std::optional<double> load_timeout_s;        // absent: none
  std::optional<uint64_t> texture_bytes = {};  // absent: all of them are held in memory
};

// A new budget, and the time from now on.
LoadLimits limits_of(const LimitOptions& options, const std::string& scene);

// For reading a picture that a run of ours wrote, of so many pixels: what it takes, and no more,
// since somebody may have put another in its place.
LoadLimits limits_of_own_picture(int64_t pixels);

// Throws InputError if the process has grown by more than the limit and a tenth since its peak was
// `before`, what its libraries take for themselves left out: the check behind all estimates.
void check_growth(uint64_t before, const MemoryBudget& budget, const std::string& scene);

// As many open files as the system lets this process have.
void allow_many_files();

// Three quarters of what the machine has, or of what the container, the shell or a job of Slurm
// leaves this process. Of all memory, not of what happens to be free: whether a scene loads must
// not depend on who else is at work.
uint64_t default_memory_limit();

// The least limit that the control groups of a process set, of both versions (Linux:
// Documentation/admin-guide/cgroup-v2.rst and cgroup-v1/memory.rst); absent: none. `groups` is the
// text of /proc/self/cgroup, `root` where the groups are mounted.
std::optional<uint64_t> cgroup_memory_limit(std::string_view groups,
                                            const std::filesystem::path& root);

}  // namespace emberline
