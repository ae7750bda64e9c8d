// Numbers in [0, 1) for a path tracer, addressed by (pixel, sample, slot, dimension, seed).
//
// A slot is one scattering event's worth of numbers: slot 0 is the camera's, slot b the b-th
// surface's. A sampler fills a slot for up to 16 consecutive samples of one pixel at a time, so the
// one virtual call is paid per (16 samples, slot), never per number, and the loop vectorises over
// the samples (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), for the hash).
//
// No state is carried from one sample to the next: fill() is const and its result for a sample
// does not depend on which other samples are filled with it (law 1). Early passes of a progressive
// render want one sample each of many pixels: fill_scattered() gives them the same numbers.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace emberline {

inline constexpr int kSampleLanes = 16;    // samples filled together; an aligned block of indices
inline constexpr int kSlotDimensions = 8;  // four pairs of dimensions per slot

// The dimension plan. Pairs are stratified together; a pair is two neighbouring dimensions that
// start at an even one. Samplers may take the dimensions from 4 on, which are used one by one, as
// single ones.
namespace camera_dim {
enum : int {
  kPixelX = 0,
  kPixelY = 1,
  kLensX = 2,
  kLensY = 3,
  kTime = 4,
  kSpare = 5,
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

// Which pixel of which frame; the frame's seed included.
struct PixelKey {
  uint32_t x = 0, y = 0;
  uint32_t seed = 0;
};

// Which sample of which pixel.
struct SampleAddress {
  uint32_t x = 0, y = 0;
  uint32_t sample = 0;
  bool operator==(const SampleAddress&) const = default;
};

// values[dimension][lane], lane = sample index modulo kSampleLanes.
struct alignas(64) SlotBlock {
  float values[kSlotDimensions][kSampleLanes];
};

// How many independent randomisations a pixel's samples come from. One is best stratified; two
// give an honest error estimate: sample k belongs to stream (k >> 3) & 1.
enum class StreamCount : uint8_t { kOne = 1, kTwo = 2 };

// A sample's place in its stream; of samples that have nothing to do with each other each is a
// stream.
struct StreamIndex {
  uint32_t stream, index;
};

class Sampler {
 public:
  virtual ~Sampler() = default;
  // Writes lanes [first_sample % 16, first_sample % 16 + count) of at least the first `dimensions`
  // dimensions of `slot`, whose values do not depend on how many are asked for. The lanes must not
  // wrap: first_sample % 16 + count <= 16. Thread-safe.
  virtual void fill(const PixelKey& pixel, uint32_t slot, uint32_t first_sample, int count,
                    SlotBlock& out, int dimensions = kSlotDimensions) const = 0;
  // The same numbers for up to 16 samples of any pixels: writes samples[i] to lane first_lane + i.
  // The default asks fill() for each alone, which is right for every sampler and fast for none.
  virtual void fill_scattered(std::span<const SampleAddress> samples, uint32_t seed, uint32_t slot,
                              int first_lane, SlotBlock& out,
                              int dimensions = kSlotDimensions) const;

  // Which samples are stratified together: for decisions beside the plan, which are then, too.
  // Thread-safe.
  virtual StreamIndex stream_of(uint32_t sample) const = 0;

  // The factor on the value of `sample` when a pixel takes exactly `count` samples (sample <
  // count), for samplers whose points do not all stand for equal volumes. The mean over a pixel's
  // samples is 1, so that the weighted sum is still divided by `count`. Thread-safe.
  virtual float integration_weight(uint32_t /*sample*/, uint32_t /*count*/) const { return 1.0f; }
};

// How many samples a pixel may take: as many as one likes, known at any time; or exactly
// SamplerSettings::samples_per_pixel, of any size or a power of two. Samples beyond a fixed count
// are valid too: each further samples_per_pixel of them are a fresh randomisation.
enum class SampleCounts : uint8_t { kAny, kFixed, kPowerOfTwo };

// Whose rate of convergence a sampler's variance has, where theory or long measurement knows it
// (renderer/statistics/convergence.h).
enum class ConvergenceRate : uint8_t { kUnknown, kIndependent, kJittered, kSobol };

struct SamplerSettings {
  StreamCount streams = StreamCount::kOne;
  uint32_t samples_per_pixel = 64;  // at least 1; samplers of any count do not look at it
  int width = 1, height = 1;        // of the frame in pixels, for those that spread error over it
};

// The table of samplers: feeds the factory, --help, the "valid names are" message and the tests.
struct SamplerEntry {
  std::string_view name;
  std::string_view summary;
  SampleCounts counts;
  ConvergenceRate rate;
  std::unique_ptr<Sampler> (*create)(const SamplerSettings&);
  bool weighted = false;  // Sampler::integration_weight() is not always 1
};
std::span<const SamplerEntry> sampler_table();

// Those whose first samples are the same, and weigh the same, however many come: what frames can be
// extended with, and cut into ranges of samples.
std::vector<std::string_view> extensible_samplers();

// Throws UsageError that lists the valid names, or says which counts the sampler can take.
std::unique_ptr<Sampler> create_sampler(std::string_view name, const SamplerSettings& settings);

}  // namespace emberline
