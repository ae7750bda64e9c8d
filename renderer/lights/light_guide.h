// What a survey of a view found out about its lights (renderer/scene/light_survey.h), for
// LightSampler: how often to choose which kind of light, and where in the environment to look. All
// of it is a matter of noise alone.
#pragma once

#include <memory>
#include <string>

namespace emberline {

class EnvironmentGuide;  // environment_guide.h

// A kind of light is chosen by the irradiance that it would give with nothing in the way, times its
// factor; finite lights' is 1.
struct KindFactors {
  float environment = 1.0f, directional = 1.0f;
  // Of the samples, for infinite lights and for finite ones each. Without a survey neither kind's
  // irradiance is known well: walls hide the sky from a room, a lamp faces away. Ours.
  float least_share = 0.2f;
  // Of the environment's samples, for directional lights that can shine there.
  float least_directional = 0.0f;

  bool operator==(const KindFactors&) const = default;
};

struct LightGuide {
  KindFactors factors = {};
  std::shared_ptr<const EnvironmentGuide> environment = {};  // null: by its light alone

  std::string describe() const;  // for the report
};

}  // namespace emberline
