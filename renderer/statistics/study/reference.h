// The reference of a study. It consists of two halves with independent noise, which are sampled
// uniformly and cached.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/statistics/neyman_limit.h"
#include "renderer/statistics/reference_error.h"
#include "renderer/statistics/study/renderer.h"

namespace emberline {

// A request for one half: its frame and its folder. `key` describes everything that the pixels
// depend on.
struct ReferenceRequest {
  RenderOptions options;  // with the driver, sampler, samples and seed of this half
  std::string key;
  std::string folder;
};

// The channels of study_reference_aovs(), interleaved.
using ReferenceHalf = std::vector<float>;
AovSet study_reference_aovs();

// Returns the names of the half's files, relative to its folder.
std::vector<std::string> reference_files(const ReferenceRequest& request);

// Call this for a folder that several studies share. Throws UsageError if files with the half's
// names exist but are not a reference half, because they would be overwritten.
void check_cached_files(const ReferenceRequest& request);

// Reads a cached half. Returns nothing if it is not in the cache. If it is damaged or belongs to
// another frame, logs this and returns nothing.
std::optional<ReferenceHalf> read_reference_half(const ReferenceRequest& request, const Rect& crop);

// Renders a half and caches it. Returns nothing if a stop was requested. Throws RenderError.
std::optional<ReferenceHalf> render_reference_half(const StudyRenderer& renderer,
                                                   const ReferenceRequest& request,
                                                   const std::stop_token& stop);

RgbImage reference_picture(const ReferenceHalf& half, const Rect& crop);

// Computes the Neyman limits from the variance of the halves' samples, which are treated as
// independent, and from the time of each pixel. Each half has a time for each pixel. The smaller
// one is used, because other work on the machine disturbed its measurement less. `samples` is the
// number of samples per pixel in one half.
NeymanLimits reference_limits(const std::array<ReferenceHalf, 2>& halves, uint32_t samples,
                              const ReferencePicture& reference);

}  // namespace emberline
