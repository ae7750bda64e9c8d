#include "renderer/engine/slurm_allocation.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "renderer/core/log.h"
#include "renderer/core/option_values.h"
#include "renderer/engine/process_usage.h"

namespace emberline {
namespace {

template <typename T>
std::optional<T> positive(const char* variable) {
  const char* const text = std::getenv(variable);
  const std::optional<T> value = text ? parse_number<T>(text) : std::nullopt;
  return value && *value > 0 ? value : std::nullopt;
}

}  // namespace

std::optional<uint64_t> slurm_memory_bytes() {
  constexpr int64_t kMost = int64_t(1) << 40;  // MiB; --mem=0, all of the node, says 0
  const auto mebibytes = positive<int64_t>("SLURM_MEM_PER_NODE");
  return mebibytes && *mebibytes < kMost ? std::optional(uint64_t(*mebibytes) << 20) : std::nullopt;
}

std::optional<int> slurm_cpus() {
  const auto cpus = positive<int>("SLURM_CPUS_PER_TASK");
  return cpus && *cpus <= 4096 ? cpus : std::nullopt;
}

std::optional<double> slurm_seconds_left() {
  constexpr double kForCheckpoint = 60;
  const auto end = positive<double>("SLURM_JOB_END_TIME");
  if (!end) return std::nullopt;
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  double left = *end - now;
  const auto start = positive<double>("SLURM_JOB_START_TIME");
  if (start && *start < *end && (left < 0 || left > *end - *start + 1)) {
    log_warning("this machine's clock and that of Slurm differ; the job's time is told without it");
    left = *end - *start - process_age_seconds().value_or(0);
  }
  return std::max(0.0, left - kForCheckpoint);
}

}  // namespace emberline
