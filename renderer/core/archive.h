// Saves and loads an object's state; the object needs only one function for both:
//
//   void Planner::archive(Archive& archive) {
//     archive.number(round_, 0, kMaxRounds);
//     archive.array(targets_, pixels);
//   }
//   std::vector<std::byte> bytes;
//   Archive saving(bytes);                       Archive loading(std::span(bytes));
//   planner.archive(saving);                     restored.archive(loading);
//   saving.end();                                loading.end();
//
// The bytes are in this machine's byte order. The bytes may come from an untrusted file, so the
// caller tells each function which values are allowed. Loading throws InputError for any other
// value; the caller must then discard the object.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/parallel.h"

namespace emberline {

class Archive {
 public:
  // Saves into `to` and overwrites its contents.
  explicit Archive(std::vector<std::byte>& to) : to_(&to) {}
  explicit Archive(std::span<const std::byte> from) : from_(from) {}

  bool loading() const { return to_ == nullptr; }

  // Saves or loads an integer, an enum or a bool within [minimum, maximum].
  template <typename T>
  requires std::is_integral_v<T> || std::is_enum_v<T>
  void number(T& value, T minimum, T maximum) {
    using Raw = decltype(widen(value));
    Raw raw = widen(value);
    bytes(&raw, sizeof raw);
    check(raw >= widen(minimum) && raw <= widen(maximum));
    value = T(raw);
  }
  // Saves or loads a number within [minimum, maximum], or NaN if `may_be_nan`.
  void number(double& value, double minimum, double maximum, bool may_be_nan = false) {
    bytes(&value, sizeof value);
    check((value >= minimum && value <= maximum) || (may_be_nan && std::isnan(value)));
  }
  // Saves or loads exactly values.size() elements; the number of elements is not stored.
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void values(std::span<T> values) { bytes(values.data(), values.size_bytes()); }
  // Saves or loads an array that is empty or has exactly `size` elements. Floating-point elements
  // must not be NaN. If the elements are structs, the caller must check their members.
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void array(std::vector<T>& values, size_t size) {
    list(values, size);
    check(values.empty() || values.size() == size);
  }
  // Like array(), but with any number of elements up to `maximum`.
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void list(std::vector<T>& values, size_t maximum) {
    size_t count = values.size();
    number(count, size_t(0), maximum);
    if (loading()) {
      check(count <= from_.size() / sizeof(T));
      values.resize(count);
    }
    bytes(values.data(), count * sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {
      for (const T& value : values) check(!std::isnan(value));
    }
  }

  // The bytes that have not been loaded yet.
  std::span<const std::byte> rest() const { return from_; }

  void check(bool accepted) const {
    if (loading() && !accepted) throw_damaged();
  }
  // Call this last. When saving, it truncates the buffer to the bytes written; when loading, it
  // checks that all bytes have been loaded.
  void end() const {
    check(from_.empty());
    if (!loading()) to_->resize(size_);
  }

 private:
  template <typename T>
  static auto widen(T value) {
    if constexpr (std::is_enum_v<T>) {
      return widen(std::underlying_type_t<T>(value));
    } else {
      return std::conditional_t<std::is_signed_v<T>, int64_t, uint64_t>(value);
    }
  }
  [[noreturn]] static void throw_damaged() {
    throw InputError("saved frame state", "it is damaged or belongs to another frame");
  }
  // Copies large arrays, such as a film, with all threads.
  static void copy(const void* from, std::byte* to, size_t size) {
    constexpr size_t kLarge = size_t(32) << 20, kGrain = size_t(1) << 20;
    if (size < kLarge) {
      std::memcpy(to, from, size);
    } else {
      parallel_ranges(size, kGrain, [&](size_t begin, size_t end) {
        std::memcpy(to + begin, static_cast<const std::byte*>(from) + begin, end - begin);
      });
    }
  }
  void bytes(void* data, size_t size) {
    if (size == 0) return;
    if (loading()) {
      check(size <= from_.size());
      std::memcpy(data, from_.data(), size);
      from_ = from_.subspan(size);
    } else {
      if (to_->size() - size_ < size) to_->resize(size_ + size);
      copy(data, to_->data() + size_, size);
      size_ += size;
    }
  }

  std::vector<std::byte>* to_ = nullptr;
  size_t size_ = 0;  // bytes written
  std::span<const std::byte> from_;
};

}  // namespace emberline
