#include "renderer/core/memory_budget.h"

#include <fmt/format.h>

#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/readable.h"

namespace emberline {

std::string_view name_of(MemoryPart part) {
  static constexpr std::string_view kNames[kMemoryParts] = {"file", "geometry", "textures",
                                                            "bvh",  "lights",   "film"};
  return kNames[size_t(part)];
}

const std::shared_ptr<MemoryBudget>& MemoryBudget::unlimited() {
  static const auto budget = std::make_shared<MemoryBudget>(kUnlimited);
  return budget;
}

std::shared_ptr<MemoryBudget> MemoryBudget::child_budget() const {
  auto child_budget = std::make_shared<MemoryBudget>(limit_);
  child_budget->inherited_ = reserved();
  child_budget->reserved_ = child_budget->inherited_;
  return child_budget;
}

bool MemoryBudget::try_reserve(MemoryPart part, uint64_t bytes, uint64_t* left) noexcept {
  if (limit_ == kUnlimited) return true;
  uint64_t before = reserved_.load(std::memory_order_relaxed);
  do {
    if (bytes > limit_ - before) {
      if (left) *left = limit_ - before;
      return false;
    }
  } while (!reserved_.compare_exchange_weak(before, before + bytes, std::memory_order_relaxed));
  parts_[size_t(part)].fetch_add(bytes, std::memory_order_relaxed);
  uint64_t peak = peak_.load(std::memory_order_relaxed);
  while (peak < before + bytes &&
         !peak_.compare_exchange_weak(peak, before + bytes, std::memory_order_relaxed)) {
  }
  return true;
}

void MemoryBudget::reserve(MemoryPart part, uint64_t bytes, const std::string& place) {
  uint64_t left = 0;
  if (!try_reserve(part, bytes, &left)) throw LimitError(place, limit_message(part, bytes, left));
}

void MemoryBudget::release(MemoryPart part, uint64_t bytes) noexcept {
  if (limit_ == kUnlimited) return;
  parts_[size_t(part)].fetch_sub(bytes, std::memory_order_relaxed);
  reserved_.fetch_sub(bytes, std::memory_order_relaxed);
}

std::string MemoryBudget::limit_message(MemoryPart part, uint64_t bytes, uint64_t left) const {
  std::string needed = readable_bytes(bytes), available = readable_bytes(left);
  if (needed == available) {  // different numbers, but equal once rounded
    needed = readable_count(bytes) + " B";
    available = readable_count(left) + " B";
  }
  const std::string what = left == limit_ ? "more than the limit of " + available
                                          : fmt::format("but only {} of the limit of {} is left",
                                                        available, readable_bytes(limit_));
  return fmt::format("needs {} of memory ({}), {}; raise `memory-limit`", needed, name_of(part),
                     what);
}

MemoryReservation& MemoryReservation::operator=(MemoryReservation&& other) noexcept {
  if (this == &other) return *this;
  release();
  budget_ = std::move(other.budget_);
  part_ = other.part_;
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

void MemoryReservation::add(uint64_t bytes, const std::string& place) {
  if (!budget_) return;
  budget_->reserve(part_, bytes, place);
  bytes_ += bytes;
}

void MemoryReservation::release() noexcept {
  if (budget_) budget_->release(part_, std::exchange(bytes_, 0));
}

uint64_t bytes_of(uint64_t count, uint64_t size) {
  uint64_t bytes = 0;
  return __builtin_mul_overflow(count, size, &bytes) ? UINT64_MAX : bytes;
}

}  // namespace emberline
