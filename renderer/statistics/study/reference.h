// The reference of a study: two halves of independent noise, rendered evenly, and kept.
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

// One half: which frame, and where it is kept. Everything that its pixels depend on is in `key`.
struct ReferenceRequest {
  RenderOptions options;  // driver, sampler, samples of this half, its seed
  std::string key;
  std::string folder;
};

// The channels of study_reference_aovs(), interleaved.
using ReferenceHalf = std::vector<float>;
AovSet study_reference_aovs();

// The names of its files in that folder.
std::vector<std::string> reference_files(const ReferenceRequest& request);

// Of a folder that several studies share: throws UsageError where these files are there and are no
// half of any reference, which would be lost.
void check_cached_files(const ReferenceRequest& request);

// A half that was kept; nothing if there is none, or only a damaged one or one of something else,
// which is then said.
std::optional<ReferenceHalf> read_reference_half(const ReferenceRequest& request, const Rect& crop);

// Renders a half and keeps it. Nothing if a stop was requested. Throws RenderError.
std::optional<ReferenceHalf> render_reference_half(const StudyRenderer& renderer,
                                                   const ReferenceRequest& request,
                                                   const std::stop_token& stop);

// The picture of a half.
RgbImage reference_picture(const ReferenceHalf& half, const Rect& crop);

// From the spread of the halves' samples, taken for independent, and the time of each pixel (of the
// two that which was disturbed less). `samples` of each half.
NeymanLimits reference_limits(const std::array<ReferenceHalf, 2>& halves, uint32_t samples,
                              const ReferencePicture& reference);

}  // namespace emberline
