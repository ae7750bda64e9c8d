// The results of a view's light survey (renderer/scene/light_survey.h) for LightSampler:
// probabilities of the kinds of light, and the visible parts of the environment. They only affect
// noise.
#pragma once

#include <memory>
#include <string>

namespace emberline {

class EnvironmentGuide;  // environment_guide.h

// Kinds of light are chosen by unoccluded irradiance times a factor (1 for finite lights).
struct KindFactors {
  float environment = 1.0f, directional = 1.0f;
  // Minimum fraction of the samples for infinite lights and for finite ones. Without a survey
  // neither irradiance is known well: walls hide the sky from a room, a lamp faces away. Chosen by
  // us.
  float min_share = 0.2f;
  // As a fraction of the environment's samples, for directional lights above the horizon.
  float min_directional = 0.0f;

  bool operator==(const KindFactors&) const = default;
};

struct LightGuide {
  KindFactors factors = {};
  std::shared_ptr<const EnvironmentGuide> environment = {};  // null: by its light alone

  std::string describe() const;  // for the report
};

}  // namespace emberline
