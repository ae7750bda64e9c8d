#include "renderer/engine/process_usage.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <sstream>

#include "io/files/input_file.h"
#include "renderer/core/log.h"
#include "renderer/core/option_values.h"

namespace emberline {
namespace {

template <typename T>
std::optional<T> read_positive(const char* variable) {
  const char* const text = std::getenv(variable);
  const std::optional<T> value = text ? parse_number<T>(text) : std::nullopt;
  return value && *value > 0 ? value : std::nullopt;
}

}  // namespace

uint64_t peak_rss_bytes() {
  // getrusage() is only the fallback, because exec does not reset the peak that it returns. A
  // render that a large program has started would report that program's memory.
  std::istringstream status(read_kernel_text("/proc/self/status"));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::strtoull(line.c_str() + 6, nullptr, 10) * 1024;
  }
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return uint64_t(usage.ru_maxrss) * 1024;  // Linux reports KiB
}

double process_cpu_seconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::optional<double> process_age_seconds() {
  const std::string text = read_kernel_text("/proc/self/stat");
  // Searches backwards, because the second field, the name in parentheses, may contain any
  // character. Field 22 is `starttime`, in clock ticks since boot (proc(5)).
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  for (int i = 3; i <= 22; ++i) fields >> field;
  timespec now = {};
  if (!fields || clock_gettime(CLOCK_BOOTTIME, &now) != 0) return std::nullopt;
  const double started = std::strtod(field.c_str(), nullptr) / double(sysconf(_SC_CLK_TCK));
  const double age = double(now.tv_sec) + 1e-9 * double(now.tv_nsec) - started;
  return age >= 0 ? std::optional(age) : std::nullopt;
}

std::string host_name() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

std::optional<uint64_t> slurm_memory_bytes() {
  constexpr int64_t kMaxMebibytes = int64_t(1) << 40;  // MiB; 0 (--mem=0: whole node) is ignored
  const auto mebibytes = read_positive<int64_t>("SLURM_MEM_PER_NODE");
  return mebibytes && *mebibytes < kMaxMebibytes ? std::optional(uint64_t(*mebibytes) << 20)
                                                 : std::nullopt;
}

std::optional<int> slurm_cpus() {
  const auto cpus = read_positive<int>("SLURM_CPUS_PER_TASK");
  return cpus && *cpus <= 4096 ? cpus : std::nullopt;
}

std::optional<double> slurm_seconds_left() {
  constexpr double kCheckpointReserve = 60;
  const auto end = read_positive<double>("SLURM_JOB_END_TIME");
  if (!end) return std::nullopt;
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  double left = *end - now;
  const auto start = read_positive<double>("SLURM_JOB_START_TIME");
  if (start && *start < *end && (left < 0 || left > *end - *start + 1)) {
    log_warning(
        "this machine's clock differs from Slurm's; the remaining time is estimated from the job's "
        "start");
    left = *end - *start - process_age_seconds().value_or(0);
  }
  return std::max(0.0, left - kCheckpointReserve);
}

}  // namespace emberline
