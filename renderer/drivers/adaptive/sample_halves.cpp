#include "renderer/drivers/adaptive/sample_halves.h"

#include <bit>
#include <cmath>

#include "renderer/core/archive.h"
#include "renderer/core/parallel.h"

namespace emberline {
namespace {

// Blocks of 8 samples are the smallest that are stratified in all dimensions.
constexpr float kMinPartSamples = 8.0f;

uint32_t significand(float count) { return std::bit_cast<uint32_t>(count) & 0x7fffffu; }
bool is_power_of_two(float count) { return significand(count) == 0; }
bool is_half_step(float count) { return (significand(count) & 0x3fffffu) == 0; }

}  // namespace

void SampleHalves::update(PixelStatistics* pixels, const ReadMeans& read_more) {
  const size_t size = pixels->size();
  std::vector<std::vector<float>*> planes = {&count_, &weight_};
  for (auto* channels : {&mean_, &difference_}) {
    for (std::vector<float>& channel : *channels) planes.push_back(&channel);
  }
  resize_planes(planes, size);
  constexpr size_t kGrain = 4096;
  parallel_ranges(size, kGrain,
                  [&](size_t begin, size_t end) { update_range(begin, end, read_more, pixels); });
}

// Two parts with a and b samples have the mean M = (a M1 + b M2) / n, so M1 - M2 = (M1 - M) n / b.
// Example: for 8 samples of 1 and then 8 samples of 3, M = 2 and M1 - M2 = (1 - 2) 16 / 8 = -2.
void SampleHalves::update_range(size_t begin, size_t end, const ReadMeans& read_more,
                                PixelStatistics* pixels) {
  const bool every_update = parts_ == SampleParts::kEveryUpdate;
  std::vector<float> means(mean_.size());
  for (size_t i = begin; i < end; ++i) {
    const float n = pixels->count[i], a = count_[i], b = n - a;
    if (b >= kMinPartSamples && (every_update || is_half_step(n))) {
      const bool second = a > 0.0f, first = every_update || is_power_of_two(n);
      if (second) weight_[i] = a * b / n;
      for (size_t c = 0; c < 3; ++c) means[c] = pixels->mean[c][i];
      if (read_more) read_more(i, &means[3]);
      for (size_t c = 0; c < means.size(); ++c) {
        if (second) difference_[c][i] = (mean_[c][i] - means[c]) * (n / b);
        if (first) mean_[c][i] = means[c];
      }
      if (first) count_[i] = n;
    }
    const float scale = n > 0.0f ? std::sqrt(4.0f * weight_[i] / n) : 0.0f;
    pixels->second_count[i] = weight_[i] > 0.0f ? 0.5f * n : 0.0f;
    for (size_t c = 0; c < 3; ++c) pixels->stream_difference[c][i] = scale * difference_[c][i];
  }
}

void SampleHalves::archive(Archive& archive, size_t pixels) {
  for (auto* plane : {&count_, &weight_}) {
    archive.array(*plane, pixels);
    for (const float value : *plane) archive.check(value >= 0.0f && value <= 0x1p24f);
  }
  for (auto* planes : {&mean_, &difference_}) {
    for (auto& plane : *planes) archive.array(plane, pixels);
  }
}

uint64_t SampleHalves::bytes() const {
  return (2 + 2 * mean_.size()) * count_.capacity() * sizeof(float);
}

}  // namespace emberline
