// Storage for one object per sample of a batch. An object is constructed only if its sample needs
// it.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <new>
#include <type_traits>

#include "renderer/core/ray.h"

namespace emberline {

template <class T>
class LaneArray {
  static_assert(std::is_trivially_destructible_v<T>);  // destructors are never called

 public:
  T& emplace(int lane) { return *::new (static_cast<void*>(slots_[lane].bytes)) T(); }
  // Constructs the result of `make` in place.
  template <class Make>
  T& emplace_result(int lane, const Make& make) {
    return *::new (static_cast<void*>(slots_[lane].bytes)) T(make());
  }
  T& operator[](int lane) { return *std::launder(reinterpret_cast<T*>(slots_[lane].bytes)); }

 private:
  struct Slot {
    alignas(T) std::byte bytes[sizeof(T)];
  };
  Slot slots_[kRayBatch];
};

// A list of lanes (indices of samples in a batch), in the order in which they were added.
class LaneList {
 public:
  // A lane may be added only once.
  void add(int lane) {
    assert(count_ < kRayBatch);
    lanes_[count_++] = lane;
  }
  bool contains(int lane) const { return std::find(begin(), end(), lane) != end(); }
  bool empty() const { return count_ == 0; }
  int size() const { return count_; }
  int operator[](int i) const { return lanes_[i]; }
  const int* begin() const { return lanes_; }
  const int* end() const { return lanes_ + count_; }
  // Removes the lanes for which keep(lane) returns false.
  template <class Keep>
  void filter(const Keep& keep) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const int lane = lanes_[i];
      if (keep(lane)) lanes_[kept++] = lane;
    }
    count_ = kept;
  }

 private:
  int lanes_[kRayBatch];
  int count_ = 0;
};

}  // namespace emberline
