// Numbers in [0, 1) for a path tracer, addressed by (pixel, sample, slot, dimension, seed).
//
// A slot holds the numbers of one scattering event: slot 0 is the camera's, and slot b is the b-th
// surface's. A sampler fills a slot for up to 16 consecutive samples of one pixel at a time. So
// there is one virtual call per slot and 16 samples, never one per number, and the loop vectorises
// over the samples (the hash follows Burley 2020, "Practical Hash-based Owen Scrambling", JCGT
// 9(4)).
//
// No state is carried from one sample to the next: fill() is const, and its result for a sample
// does not depend on which other samples are filled with it (law 1). The early passes of a
// progressive render need one sample each of many pixels. For these, fill_scattered() computes the
// same numbers as fill().
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace emberline {

inline constexpr int kSampleLanes = 16;    // samples filled together: an aligned block of indices
inline constexpr int kSlotDimensions = 8;  // four pairs of dimensions per slot

// The dimension plan. A pair is two adjacent dimensions that start at an even index; the two are
// stratified together. Dimensions from 4 on are used one by one, so samplers may treat them as
// single dimensions.
namespace camera_dim {
enum : int {
  kPixelX = 0,
  kPixelY = 1,
  kLensX = 2,
  kLensY = 3,
  kTime = 4,
  kUnused = 5,
  kTexture = 6,
  kEnvironment = 7
};
}
namespace surface_dim {
enum : int {
  kBsdfX = 0,
  kBsdfY = 1,
  kLightX = 2,
  kLightY = 3,
  kLobe = 4,
  kLightPick = 5,
  kRoulette = 6,
  kTexture = 7
};
}

// A pixel of a frame, and the frame's seed.
struct PixelKey {
  uint32_t x = 0, y = 0;
  uint32_t seed = 0;
};

struct SampleAddress {
  uint32_t x = 0, y = 0;
  uint32_t sample = 0;
  bool operator==(const SampleAddress&) const = default;
};

// values[dimension][lane]. The lane is the sample's index modulo kSampleLanes.
struct alignas(64) SlotBlock {
  float values[kSlotDimensions][kSampleLanes];
};

// Number of independent randomisations of a pixel's samples. With one stream, the samples are best
// stratified. Two streams allow an unbiased error estimate; sample k then belongs to stream
// (k >> 3) & 1.
enum class StreamCount : uint8_t { kOne = 1, kTwo = 2 };

// A sample's position in its stream. With the independent sampler, each sample is its own stream.
struct StreamIndex {
  uint32_t stream, index;
};

class Sampler {
 public:
  virtual ~Sampler() = default;
  // Writes lanes [first_sample % 16, first_sample % 16 + count) of at least the first `dimensions`
  // dimensions of `slot`; the values do not depend on `dimensions`. The lanes must not wrap:
  // first_sample % 16 + count <= 16. Thread-safe.
  virtual void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                    SlotBlock& out, int dimensions = kSlotDimensions) const = 0;
  // Computes the same numbers as fill() for up to 16 samples of any pixels. Writes the numbers of
  // samples[i] to lane first_lane + i. The default calls fill() for each sample, which is correct
  // but slow.
  virtual void fill_scattered(std::span<const SampleAddress> samples, uint32_t seed, uint32_t slot,
                              int first_lane, SlotBlock& out,
                              int dimensions = kSlotDimensions) const;

  // Returns the stream that `sample` belongs to, and the index of `sample` in that stream. The
  // samples of a stream are stratified together; so decisions outside the dimension plan can be
  // stratified in the same way. Thread-safe.
  virtual StreamIndex stream_of(uint32_t sample) const = 0;

  // Returns the weight of `sample` when a pixel takes exactly `count` samples (sample < count).
  // Only samplers whose points represent unequal volumes override this. The mean weight of a
  // pixel's samples is 1, so the weighted sum is still divided by `count`. Thread-safe.
  virtual float integration_weight(uint32_t /*sample*/, uint32_t /*count*/) const { return 1.0f; }
};

// The sample counts that a sampler supports. kAny: any count, which need not be known in advance.
// kFixed: exactly SamplerSettings::samples_per_pixel. kPowerOfTwo: exactly samples_per_pixel, which
// must be a power of two. Samples beyond a fixed count are valid too: each further group of
// samples_per_pixel samples is a new randomisation.
enum class SampleCounts : uint8_t { kAny, kFixed, kPowerOfTwo };

// How fast a sampler's variance converges, where theory or long measurements have established it
// (renderer/statistics/convergence.h).
enum class ConvergenceRate : uint8_t { kUnknown, kIndependent, kJittered, kSobol };

struct SamplerSettings {
  StreamCount streams = StreamCount::kOne;
  uint32_t samples_per_pixel = 64;  // at least 1; samplers with SampleCounts::kAny ignore it
  int width = 1, height = 1;        // frame size in pixels, for sampling across pixels
};

// The table of samplers. The factory, --help, the "valid names are" message and the tests use it.
struct SamplerEntry {
  std::string_view name;
  std::string_view summary;
  SampleCounts counts;
  ConvergenceRate rate;
  std::unique_ptr<Sampler> (*create)(const SamplerSettings&);
  bool weighted = false;  // Sampler::integration_weight() is not always 1
};
std::span<const SamplerEntry> sampler_table();

// Names of the samplers whose first samples and weights do not depend on the sample count. Only
// these can extend a frame or split it into ranges of samples.
std::vector<std::string_view> extensible_samplers();

// Throws UsageError for an unknown name, with the valid names, or for an unsupported sample count,
// with the counts that the sampler supports.
std::unique_ptr<Sampler> create_sampler(std::string_view name, const SamplerSettings& settings);

}  // namespace emberline
