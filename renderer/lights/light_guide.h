// The results of a view's light survey (renderer/scene/light_survey.h) for LightSampler: the
// probabilities of the kinds of light, and the visible parts of the environment. They affect only
// the noise of an image.
#pragma once

#include <memory>
#include <string>

namespace emberline {

class EnvironmentGuide;  // environment_guide.h

// A kind of light is chosen in proportion to its unoccluded irradiance times a factor, which is 1
// for finite lights.
struct KindFactors {
  float environment = 1.0f, directional = 1.0f;
  // Infinite lights get at least this fraction of the samples, and so do finite lights. Without a
  // survey, neither kind's irradiance is known well: walls may hide the sky from a room, or a lamp
  // may face away. We chose the value.
  float min_share = 0.2f;
  // The minimum number of samples for directional lights above the horizon, as a fraction of the
  // number of samples for the environment.
  float min_directional = 0.0f;

  bool operator==(const KindFactors&) const = default;
};

struct LightGuide {
  KindFactors factors = {};
  std::shared_ptr<const EnvironmentGuide> environment = {};  // null: sampled by light alone

  std::string describe() const;  // for the report
};

}  // namespace emberline
