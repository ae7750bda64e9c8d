// What a run may take of the machine's memory. Whoever is about to allocate what a file or an
// option asks for reserves it first, from the sizes that are announced, so that a small file that
// unfolds to gigabytes is refused before anything of it exists.
//
// Reached through LoadProgress::budget(), which everything that loads gets. What is reserved stays
// so as long as the budget lives, unless it is given back.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace emberline {

// What memory is for, in messages and reports.
enum class MemoryPart : uint8_t { kFile, kGeometry, kTextures, kBvh, kLights, kFilm };
inline constexpr size_t kMemoryParts = 6;
std::string_view name_of(MemoryPart part);

// Thread-safe.
class MemoryBudget {
 public:
  static constexpr uint64_t kUnlimited = UINT64_MAX;  // and nothing is counted

  explicit MemoryBudget(uint64_t limit) : limit_(limit) {}
  MemoryBudget(const MemoryBudget&) = delete;
  MemoryBudget& operator=(const MemoryBudget&) = delete;

  static const std::shared_ptr<MemoryBudget>& unlimited();

  // Throws InputError that names `place` if so much is not left; nothing is reserved then.
  void reserve(MemoryPart part, uint64_t bytes, const std::string& place);
  // False instead of an exception: for callbacks.
  bool try_reserve(MemoryPart part, uint64_t bytes) noexcept;
  void give_back(MemoryPart part, uint64_t bytes) noexcept;
  // What reserve() says beside the place.
  std::string refusal(MemoryPart part, uint64_t bytes) const;

  // A budget of its own with the same limit, in which what is reserved here is gone: for a load,
  // which reserves here what it took() when it is through.
  std::shared_ptr<MemoryBudget> rest() const;
  uint64_t took() const { return reserved() - before_; }

  uint64_t limit() const { return limit_; }
  uint64_t reserved() const { return reserved_.load(std::memory_order_relaxed); }
  uint64_t reserved(MemoryPart part) const {
    return parts_[size_t(part)].load(std::memory_order_relaxed);
  }
  uint64_t peak() const { return peak_.load(std::memory_order_relaxed); }  // of reserved()

 private:
  const uint64_t limit_;
  uint64_t before_ = 0;
  std::atomic<uint64_t> reserved_{0}, peak_{0};
  std::array<std::atomic<uint64_t>, kMemoryParts> parts_{};
};

// Memory that is only needed for a while: given back when this goes out of scope.
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

  // More of the same. Throws as MemoryBudget::reserve does.
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

// count * size, or the largest number where that is more: counts come from files.
uint64_t bytes_of(uint64_t count, uint64_t size);

}  // namespace emberline
