// Measures the memory of this process, to check the numbers in a report.
#pragma once

#include <malloc.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "support/sanitized.h"

namespace emberline::test {

// The memory in use, in bytes. now() first returns the allocator's free pages to the system, so
// memory that was in use only temporarily does not count.
struct ProcessMemory {
  double resident = 0;   // in resident pages of the whole process
  double allocated = 0;  // allocated by malloc and not yet freed

  static ProcessMemory now() {
    malloc_trim(0);
    ProcessMemory memory;
    uint64_t pages = 0, resident_pages = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident_pages;
    memory.resident = double(resident_pages) * double(sysconf(_SC_PAGESIZE));
    const struct mallinfo2 info = mallinfo2();
    memory.allocated = double(info.uordblks) + double(info.hblkhd);
    return memory;
  }
  ProcessMemory operator-(const ProcessMemory& o) const {
    return {resident - o.resident, allocated - o.allocated};
  }
};

// peak_resident_bytes() returns the largest resident memory since the last reset_peak(). This
// includes the memory of a sanitizer.
inline void reset_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}
inline double peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word && word != "VmHWM:") {
  }
  double kilobytes = 0;
  status >> kilobytes;
  return 1024 * kilobytes;
}

}  // namespace emberline::test
