#include "renderer/engine/run_limits.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

#include "io/files/input_file.h"
#include "io/image/library.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/engine/process_usage.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

// Reads a number. Returns nullopt for "max" and for a missing file.
std::optional<uint64_t> read_number_from(const fs::path& path) {
  std::istringstream text(read_kernel_text(path.c_str()));
  uint64_t number = 0;
  return text >> number ? std::optional(number) : std::nullopt;
}

}  // namespace

std::optional<uint64_t> cgroup_memory_limit(std::string_view groups, const fs::path& root) {
  std::optional<uint64_t> lowest;
  std::istringstream lines{std::string(groups)};
  for (std::string line; std::getline(lines, line);) {
    // The format is hierarchy:controllers:path; in version 2, controllers is empty.
    const size_t first = line.find(':');
    const size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool unified = controllers.empty();
    if (!unified && controllers.find("memory") == std::string::npos) continue;
    const fs::path mount = unified ? root : root / "memory";
    const char* const name = unified ? "memory.max" : "memory.limit_in_bytes";
    // Parent groups limit their children, so each of them is checked. In a container, the path may
    // be a path on the host. Its folders are then missing, and the root is the container's own
    // group.
    for (fs::path group = fs::path(line.substr(second + 1)).relative_path();;
         group = group.parent_path()) {
      if (const auto limit = read_number_from(mount / group / name)) {
        lowest = std::min(lowest.value_or(*limit), *limit);
      }
      if (group.empty()) break;
    }
  }
  return lowest;
}

LoadLimits read_back_limits(int64_t pixels) {
  // Enough for the picture's encoded and decoded channels, plus the codec's rows.
  constexpr uint64_t kBytesPerPixel = 256, kBaseBytes = uint64_t(64) << 20;
  return {.memory = std::make_shared<MemoryBudget>(
              kBaseBytes + bytes_of(uint64_t(std::max<int64_t>(0, pixels)), kBytesPerPixel)),
          .timeout_s = {},
          .scene = {}};
}

void check_memory_growth(uint64_t before, const MemoryBudget& budget, const std::string& scene) {
  constexpr uint64_t kThreadBytes = uint64_t(64) << 20;  // for the threads of Embree and TBB
  const uint64_t now = peak_rss_bytes(), libraries = kThreadBytes + image_library_bytes();
  if (now < before + libraries) return;
  const uint64_t growth = now - before - libraries;
  if (growth <= budget.limit() || growth - budget.limit() <= budget.limit() / 10) return;
  throw InputError(scene,
                   "loading took {} of memory, more than the limit of {}; raise `memory-limit`",
                   readable_bytes(growth), readable_bytes(budget.limit()));
}

void raise_open_file_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  (void)setrlimit(RLIMIT_NOFILE, &limit);  // if this fails, opening too many files throws later
}

uint64_t default_memory_limit() {
  uint64_t memory = bytes_of(uint64_t(std::max(0L, sysconf(_SC_PHYS_PAGES))),
                             uint64_t(std::max(0L, sysconf(_SC_PAGESIZE))));
  if (const auto limit =
          cgroup_memory_limit(read_kernel_text("/proc/self/cgroup"), "/sys/fs/cgroup")) {
    memory = std::min(memory, *limit);
  }
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit limit = {};
    if (getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
      memory = std::min(memory, uint64_t(limit.rlim_cur));
    }
  }
  if (const auto job = slurm_memory_bytes(); job && *job <= memory) {
    memory = *job;
    log_verbose("`memory-limit` " + readable_bytes(memory / 4 * 3) +
                ": three quarters of SLURM_MEM_PER_NODE");
  }
  return memory / 4 * 3;
}

LoadLimits limits_of(const LimitOptions& options, const std::string& scene) {
  const uint64_t bytes = options.memory_bytes ? *options.memory_bytes : default_memory_limit();
  return {std::make_shared<MemoryBudget>(bytes), options.load_timeout_s, scene,
          options.texture_bytes};
}

}  // namespace emberline
