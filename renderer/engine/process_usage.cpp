#include "renderer/engine/process_usage.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <sstream>
#include <string>

#include "io/files/input_file.h"

namespace emberline {

uint64_t peak_rss_bytes() {
  // Not getrusage: its peak lives through exec, so that a render started by a large program (an
  // artist's scene editor) would report that program's memory.
  std::istringstream status(read_kernel_text("/proc/self/status"));
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::strtoull(line.c_str() + 6, nullptr, 10) * 1024;
  }
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return uint64_t(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

double process_cpu_seconds() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::optional<double> process_age_seconds() {
  const std::string text = read_kernel_text("/proc/self/stat");
  // The second field, the name in parentheses, may hold anything; `starttime` is field 22, in clock
  // ticks since boot (proc(5)).
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

}  // namespace emberline
