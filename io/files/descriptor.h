// A file descriptor that is closed when its owner is destroyed.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace emberline {

class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}  // -1: none
  Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }

  operator int() const { return number_; }
  int release() { return std::exchange(number_, -1); }

  // Reads up to `count` bytes. Returns their number, or -1 on error, with errno set. Thread-safe.
  int64_t read_at(void* bytes, uint64_t count, uint64_t offset) const noexcept;
  // Writes all bytes. Returns 0 or an errno value. Thread-safe for disjoint ranges.
  int write_at(const void* bytes, size_t count, uint64_t offset) const noexcept;

 private:
  int number_;
};

}  // namespace emberline
