// A zero-initialised array. The system allocates the pages of a small array on first use, so a
// small film costs nothing until samples arrive. For a large array, all threads touch the huge
// pages in advance, because the first few samples of a frame would touch every one of them anyway.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

namespace emberline {

// Requests pages of 2 MiB instead of 4 KiB for a large array. With the driver `bisection`, the
// first pass of a 1280 x 720 frame touches 16,000 pages of 4 KiB, which takes a sixth of the pass's
// time.
void advise_huge_pages(void* data, size_t bytes);

// Requests huge pages for memory that is already zero, and touches all of them. Otherwise the
// system would clear the pages one by one as samples arrive, which would delay the first pass of
// the driver `bisection` (tests/bench/results, "Many threads").
void commit_huge_pages(void* zeroes, size_t bytes);

// Sets all bytes to zero, with all threads if the array is large.
void clear_bytes(void* data, size_t bytes);

template <typename T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  // Makes this an array of `size` zeroes. Reuses the memory if it is large enough. Throws
  // std::bad_alloc.
  void reset(size_t size) {
    if (size > capacity_) {
      data_.reset();  // free the old memory first
      capacity_ = 0;
      data_.reset(static_cast<T*>(std::calloc(size, sizeof(T))));
      if (!data_) throw std::bad_alloc();
      commit_huge_pages(data_.get(), size * sizeof(T));
      capacity_ = size;
    } else if (size > 0) {
      clear_bytes(data_.get(), size * sizeof(T));
    }
    size_ = size;
  }

  bool empty() const { return size_ == 0; }
  size_t size() const { return size_; }
  size_t capacity() const { return capacity_; }
  T* begin() const { return data_.get(); }
  T* end() const { return data_.get() + size_; }
  T& operator[](size_t i) const {
    assert(i < size_);
    return data_.get()[i];
  }

 private:
  struct Free {
    void operator()(T* data) const { std::free(data); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0, capacity_ = 0;
};

}  // namespace emberline
