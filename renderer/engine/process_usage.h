// Memory, processor time and age of this process.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace emberline {

// Peak resident memory and CPU time of this process so far, and the seconds since it was started
// (to the kernel's 10 ms; absent if /proc does not say).
uint64_t peak_rss_bytes();
double process_cpu_seconds();
std::optional<double> process_age_seconds();

std::string host_name();

}  // namespace emberline
