// Streams and blocks of a pixel's samples, and the hash that separates them.
//
// With two streams, sample k belongs to stream (k >> 3) & 1, at index ((k >> 4) << 3) | (k & 7).
// Example: samples 40..47 are indices 16..23 of stream 1.
#pragma once

#include <algorithm>
#include <cstdint>

#include "renderer/core/hash.h"
#include "samplers/sampler.h"

namespace emberline {

constexpr StreamIndex stream_index(StreamCount streams, uint32_t sample) {
  if (streams == StreamCount::kOne) return {0, sample};
  return {(sample >> 3) & 1u, ((sample >> 4) << 3) | (sample & 7u)};
}

// How many of a pixel's first `count` samples belong to `stream`. Example: of 27 samples with two
// streams, stream 0 has 0..7 and 16..23 (16 samples), and stream 1 has the other 11.
constexpr uint32_t stream_length(StreamCount streams, uint32_t stream, uint32_t count) {
  if (streams == StreamCount::kOne) return count;
  const uint32_t rest = count & 15u, before = 8 * stream;
  return (count >> 4) * 8 + std::min(std::max(rest, before) - before, 8u);
}

// Consecutive samples of a pixel that also have consecutive indices in one block of one stream.
struct SampleRun {
  uint32_t stream;
  uint32_t block;  // number of the block; each holds block_size[stream] indices
  uint32_t index;  // index of the first sample within the block
  int lane;        // lane of the first sample
  int count;
};

// Cuts samples [first_sample, first_sample + count) into runs, and visits these in order. The
// samples must be within one batch. There are at most kSampleLanes runs, and only one per stream if
// no block ends inside the batch.
template <typename Visit>
void for_each_run(StreamCount streams, const uint32_t (&block_size)[2], uint32_t first_sample,
                  int count, Visit&& visit) {
  while (count > 0) {
    const auto [stream, index] = stream_index(streams, first_sample);
    const uint32_t size = block_size[stream];
    uint32_t length = std::min(uint32_t(count), size - index % size);
    if (streams == StreamCount::kTwo) length = std::min(length, 8 - (first_sample & 7u));
    visit(SampleRun{stream, index / size, index % size, int(first_sample % kSampleLanes),
                    int(length)});
    first_sample += length;
    count -= int(length);
  }
}

// The hash shared by all samples of a run. `salt` separates samplers that may be used together.
constexpr uint32_t run_hash(const PixelKey& pixel, const SampleRun& run, uint32_t salt) {
  const uint32_t pixel_hash =
      hash_combine(hash_combine(hash32(pixel.seed ^ salt), pixel.x), pixel.y);
  return hash_combine(hash_combine(pixel_hash, run.stream), run.block);
}

}  // namespace emberline
