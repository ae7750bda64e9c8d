// The memory budget of a run. If a file or an option determines the size of an allocation, code
// first reserves the size that the file's header or the option declares. Therefore a small file
// that expands to gigabytes is rejected before anything is allocated.
//
// Loading code gets the budget from LoadProgress::budget(). Memory stays reserved until release()
// or until the budget is destroyed.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace emberline {

// Purpose of a reservation, for messages and reports.
enum class MemoryPart : uint8_t { kFile, kGeometry, kTextures, kBvh, kLights, kFilm };
inline constexpr size_t kMemoryParts = 6;
std::string_view name_of(MemoryPart part);

// Thread-safe.
class MemoryBudget {
 public:
  static constexpr uint64_t kUnlimited = UINT64_MAX;  // also disables counting

  explicit MemoryBudget(uint64_t limit) : limit_(limit) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  static const std::shared_ptr<MemoryBudget>& unlimited();

  // If not enough memory is left, reserves nothing and throws a LimitError that names `place`.
  void reserve(MemoryPart part, uint64_t bytes, const std::string& place);
  // For use in callbacks: if not enough memory is left, returns false instead of throwing, and sets
  // `left` to the number of bytes left.
  bool try_reserve(MemoryPart part, uint64_t bytes, uint64_t* left = nullptr) noexcept;
  void release(MemoryPart part, uint64_t bytes) noexcept;
  // Returns the message of reserve() without the place. For `left`, pass the value that the failed
  // try_reserve() set; other threads may have released memory since then.
  std::string limit_message(MemoryPart part, uint64_t bytes, uint64_t left) const;

  // Returns a child budget with the same limit, which starts with the reservations of this budget.
  // A load reserves its memory in the child. If the load succeeds, the caller reserves the child's
  // newly_reserved() bytes in this budget.
  std::shared_ptr<MemoryBudget> child_budget() const;
  uint64_t newly_reserved() const { return reserved() - inherited_; }

  uint64_t limit() const { return limit_; }
  uint64_t reserved() const { return reserved_.load(std::memory_order_relaxed); }
  uint64_t reserved(MemoryPart part) const {
    return parts_[size_t(part)].load(std::memory_order_relaxed);
  }
  uint64_t peak() const { return peak_.load(std::memory_order_relaxed); }  // largest reserved()

 private:
  const uint64_t limit_;
  uint64_t inherited_ = 0;
  std::atomic<uint64_t> reserved_{0}, peak_{0};
  std::array<std::atomic<uint64_t>, kMemoryParts> parts_{};
};

// A temporary reservation; the destructor releases it.
class MemoryReservation {
 public:
  MemoryReservation() = default;
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryPart part)
      : budget_(std::move(budget)), part_(part) {}
  MemoryReservation(std::shared_ptr<MemoryBudget> budget, MemoryPart part, uint64_t bytes,
                    const std::string& place)
      : MemoryReservation(std::move(budget), part) {
    add(bytes, place);
  }
  MemoryReservation(MemoryReservation&& other) noexcept { *this = std::move(other); }
  MemoryReservation& operator=(MemoryReservation&& other) noexcept;
  ~MemoryReservation() { release(); }

  // Extends the reservation. Throws as MemoryBudget::reserve() does.
  void add(uint64_t bytes, const std::string& place);
  void release() noexcept;
  uint64_t bytes() const { return bytes_; }
  const std::shared_ptr<MemoryBudget>& budget() const {
    return budget_ ? budget_ : MemoryBudget::unlimited();
  }

 private:
  std::shared_ptr<MemoryBudget> budget_;
  MemoryPart part_ = MemoryPart::kFile;
  uint64_t bytes_ = 0;
};

// Returns count * size, or UINT64_MAX if this overflows, which is possible since counts come from
// files.
uint64_t bytes_of(uint64_t count, uint64_t size);

}  // namespace emberline
