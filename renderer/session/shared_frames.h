// Writes pictures to memory shared with another process: an anonymous file (memfd_create) that
// disappears as soon as no process holds it, even if a process crashes. The other process opens the
// file read-only as /proc/PID/fd/N. Only processes of the same user can do this.
//
// There are two slots, which are written alternately. So each picture stays intact while the next
// one is written, and the one after that overwrites it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "renderer/core/memory_budget.h"

namespace emberline {

class SharedFrames {
 public:
  // Where a picture is stored.
  struct Location {
    std::string path;
    uint64_t segment = 0;  // number of the file; it increases when a new file is created
    uint64_t bytes = 0;    // size of the file
    uint64_t offset = 0;   // offset in the file
  };

  SharedFrames() = default;
  ~SharedFrames();
  SharedFrames(const SharedFrames&) = delete;
  SharedFrames& operator=(const SharedFrames&) = delete;

  // Creates a new file if the size or the budget has changed. Throws an InputError that names
  // `place` if the budget is exceeded. Throws RenderError. After an error there is no file.
  Location write(std::span<const std::byte> picture, const std::shared_ptr<MemoryBudget>& budget,
                 const std::string& place);

 private:
  void create(uint64_t slot_bytes);
  void close();

  int file_ = -1;
  std::byte* mapped_ = nullptr;
  uint64_t slot_bytes_ = 0, segment_ = 0, written_ = 0;
  MemoryReservation memory_;
};

}  // namespace emberline
