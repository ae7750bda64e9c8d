// The memory of this process, to check a report's figures.
#pragma once

#include <malloc.h>
#include <unistd.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "support/sanitized.h"

namespace emberline::test {

// Bytes of private memory in use. The allocator's free pages are returned first, so that temporary
// memory does not count.
struct ProcessMemory {
  double resident = 0;   // pages touched, the whole process
  double allocated = 0;  // handed out by malloc and not yet freed

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

// The largest number of pages since the last reset_peak(). A sanitizer adds its own.
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
