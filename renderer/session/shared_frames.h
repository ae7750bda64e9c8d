// Pictures for another process, in memory that both share: a file without a name (memfd_create),
// which is gone when neither process holds it, however they end. The other process opens it by this
// one's descriptor, /proc/PID/fd/N, which only the same user can, and only to read.
//
// Two slots, written in turn: a picture stays until the one after the next.
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
  // Where a picture is.
  struct Place {
    std::string path;
    uint64_t segment = 0;  // counts files
    uint64_t bytes = 0;    // of the file
    uint64_t offset = 0;   // in it
  };

  SharedFrames() = default;
  ~SharedFrames();
  SharedFrames(const SharedFrames&) = delete;
  SharedFrames& operator=(const SharedFrames&) = delete;

  // In a new file if it has another size than the one before. Throws InputError for what is beyond
  // the budget, with `place`, and RenderError; there is no file then.
  Place write(std::span<const std::byte> picture, const std::shared_ptr<MemoryBudget>& budget,
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
