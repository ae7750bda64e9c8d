// The results of a view's light survey (renderer/scene/light_survey.h), which LightSampler uses:
// factors for choosing a kind of light (environment, directional or finite), and the visible parts
// of the environment. The results affect only the noise of an image.
#pragma once

#include <memory>
#include <string>

namespace emberline {

class EnvironmentGuide;  // environment_guide.h

// A kind of light is chosen in proportion to its unoccluded irradiance times a factor, which is 1
// for finite lights.
struct KindFactors {
  float environment = 1.0f, directional = 1.0f;
  // Infinite lights (environment and directional) get at least this fraction of the samples, and so
  // do finite lights. Without a survey, both irradiances are rough estimates: walls may hide the
  // sky from a room, or a lamp may face away. We chose the value.
  float min_share = 0.2f;
  // The minimum number of samples for directional lights above the horizon, as a fraction of the
  // number of samples for the environment.
  float min_directional = 0.0f;

  bool operator==(const KindFactors&) const = default;
};

struct LightGuide {
  KindFactors factors = {};
  std::shared_ptr<const EnvironmentGuide> environment = {};  // null: visibility is ignored

  std::string describe() const;  // for the report
};

}  // namespace emberline
