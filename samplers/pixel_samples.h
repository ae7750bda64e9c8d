// The numbers of a batch of up to 16 samples, filled slot by slot on first use. A batch holds
// consecutive samples of one pixel. If each pixel needs only a few samples, it holds samples of
// several pixels instead.
//
// Each worker thread has one PixelSamples and reuses it. A PixelSamples allocates nothing after its
// construction.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <span>

#include "renderer/core/hash.h"
#include "samplers/coverage_key.h"
#include "samplers/sampler.h"

namespace emberline {

class PixelSamples {
 public:
  // Number of extra slots, besides the slots of the path's events. They serve work that is repeated
  // within one scattering event, such as further light samples.
  static constexpr int kAuxiliarySlots = 15;

  // `camera_dimensions`: number of dimensions of slot 0 that the camera uses.
  explicit PixelSamples(const Sampler& sampler, int camera_dimensions = kSlotDimensions)
      : sampler_(sampler), camera_dimensions_(camera_dimensions) {}

  // Starts a batch: samples [first_sample, first_sample + count), all within one aligned 16-block.
  void start_batch(const PixelKey& pixel, uint32_t first_sample, int count) {
    assert(first_sample % kSampleLanes + uint32_t(count) <= kSampleLanes);
    pixel_ = pixel;
    first_sample_ = first_sample;
    first_lane_ = int(first_sample % kSampleLanes);
    start(count, false);
  }

  // Starts a batch of up to 16 samples of any pixels.
  void start_batch(std::span<const SampleAddress> samples, uint32_t seed) {
    assert(!samples.empty() && samples.size() <= size_t(kSampleLanes));
    std::copy(samples.begin(), samples.end(), addresses_.begin());
    pixel_.seed = seed;
    first_lane_ = 0;
    start(int(samples.size()), true);
  }

  // Selects a sample of the batch, counted from 0, and starts its camera slot.
  void start_sample(int index) {
    choose(index);
    start_slot(0);
  }

  // Selects a sample that was started before, and continues in the slot where it stopped.
  void resume_sample(int index) {
    choose(index);
    current_ = &blocks_[std::min(slot_[lane_], kCachedSlots)];
  }

  // Moves the selected sample to the slot of a scattering event. Slot 0 is the camera's.
  void start_slot(uint32_t slot) {
    slot_[lane_] = slot;
    extra_[lane_] = 0;
    if (slot < kCachedSlots) {
      if (!(filled_ & (1u << slot))) {
        fill_slot(slot, &blocks_[slot]);
        filled_ |= 1u << slot;
      }
      current_ = &blocks_[slot];
    } else {
      // Few paths get this long, so these slots are not cached. A sample fills only its own lane of
      // the last block, because the other samples may be in other slots.
      fill_lane(slot);
      current_ = &blocks_[kCachedSlots];
    }
  }

  float get(int dimension) const { return current_->values[dimension][lane_]; }

  // A number from one of the kAuxiliarySlots extra slots, independent of the sample's current slot.
  float get_auxiliary(int slot, int dimension) {
    assert(slot >= 0 && slot < kAuxiliarySlots);
    if (!(filled_auxiliary_ & (1u << slot))) {
      fill_slot(kFirstAuxiliarySlot + uint32_t(slot), &auxiliary_[size_t(slot)]);
      filled_auxiliary_ |= 1u << slot;
    }
    return auxiliary_[size_t(slot)].values[dimension][lane_];
  }

  // Returns an independent number outside the dimension plan, for decisions whose count depends on
  // the data. The number is a hash of (seed, pixel, sample, slot, number of earlier calls).
  float extra() { return to_unit_float(extra_bits()); }
  uint32_t extra_bits() {
    if (!hashed_) hash_samples();
    return hash_combine(sample_hash_[lane_], slot_[lane_] * 0x51ed270bu + extra_[lane_]++);
  }
  // Like extra(), but stratified over the samples, for the coverage decisions of one ray.
  CoverageKey coverage_key() {
    if (!streams_hashed_) hash_streams();
    const uint32_t ray = slot_[lane_] * 0x51ed270bu + extra_[lane_]++;
    return {hash_combine(streams_[lane_].seed, ray), streams_[lane_].index};
  }

 private:
  void start(int count, bool scattered) {
    count_ = count;
    scattered_ = scattered;
    filled_ = filled_auxiliary_ = 0;
    hashed_ = streams_hashed_ = false;
  }
  void choose(int index) {
    assert(index >= 0 && index < count_);
    lane_ = first_lane_ + index;
  }
  SampleAddress address(int lane) const {
    if (scattered_) return addresses_[size_t(lane)];
    return {pixel_.x, pixel_.y, first_sample_ + uint32_t(lane - first_lane_)};
  }
  void fill_slot(uint32_t slot, SlotBlock* block) {
    const int dimensions = slot == 0 ? camera_dimensions_ : kSlotDimensions;
    if (scattered_) {
      sampler_.fill_scattered({addresses_.data(), size_t(count_)}, pixel_.seed, slot, 0, *block,
                              dimensions);
    } else {
      sampler_.fill(pixel_, slot, first_sample_, count_, *block, dimensions);
    }
  }
  void fill_lane(uint32_t slot) {
    if (scattered_) {
      sampler_.fill_scattered({&addresses_[size_t(lane_)], 1}, pixel_.seed, slot, lane_,
                              blocks_[kCachedSlots]);
    } else {
      sampler_.fill(pixel_, slot, first_sample_ + uint32_t(lane_ - first_lane_), 1,
                    blocks_[kCachedSlots]);
    }
  }
  // Hashes all samples of the batch, since that costs little more than hashing one.
  void hash_samples() {
    const uint32_t seed_hash = hash32(pixel_.seed);
    if (scattered_) {
      for (int lane = 0; lane < count_; ++lane) {
        const SampleAddress& a = addresses_[size_t(lane)];
        sample_hash_[lane] =
            hash_combine(hash_combine(hash_combine(seed_hash, a.x), a.y), a.sample);
      }
    } else {
      const uint32_t pixel_hash = hash_combine(hash_combine(seed_hash, pixel_.x), pixel_.y);
      const uint32_t first = first_sample_ - first_sample_ % kSampleLanes;
      for (uint32_t lane = 0; lane < kSampleLanes; ++lane) {
        sample_hash_[lane] = hash_combine(pixel_hash, first + lane);
      }
    }
    hashed_ = true;
  }

  void hash_streams() {
    const uint32_t seed_hash = hash32(pixel_.seed);
    uint32_t pixel_hash = hash_combine(hash_combine(seed_hash, pixel_.x), pixel_.y);
    for (int lane = first_lane_; lane < first_lane_ + count_; ++lane) {
      const SampleAddress a = address(lane);
      if (scattered_) pixel_hash = hash_combine(hash_combine(seed_hash, a.x), a.y);
      const auto [stream, index] = sampler_.stream_of(a.sample);
      streams_[lane] = {hash_combine(pixel_hash, stream), index};
    }
    streams_hashed_ = true;
  }

  static constexpr uint32_t kFirstAuxiliarySlot = 1u << 24;  // above the slots of any path
  static constexpr uint32_t kCachedSlots = 8;

  const Sampler& sampler_;
  int camera_dimensions_;
  bool scattered_ = false;
  PixelKey pixel_;  // of a batch of one pixel; in a scattered batch only the seed is used
  uint32_t first_sample_ = 0;                          // of a batch of one pixel
  std::array<SampleAddress, kSampleLanes> addresses_;  // of a scattered batch
  int first_lane_ = 0;
  int count_ = 0;
  int lane_ = 0;
  uint32_t slot_[kSampleLanes] = {};   // current slot of each sample of the batch
  uint32_t extra_[kSampleLanes] = {};  // how many extra numbers the sample has drawn in that slot
  uint32_t sample_hash_[kSampleLanes] = {};  // hash of (seed, pixel, sample), if hashed_
  bool hashed_ = false;
  CoverageKey streams_[kSampleLanes] = {};  // hash of (seed, pixel, stream), if streams_hashed_
  bool streams_hashed_ = false;
  uint32_t filled_ = 0;
  const SlotBlock* current_ = nullptr;
  std::array<SlotBlock, kCachedSlots + 1> blocks_;
  uint32_t filled_auxiliary_ = 0;
  std::array<SlotBlock, kAuxiliarySlots> auxiliary_;
};

}  // namespace emberline
