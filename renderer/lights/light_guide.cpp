#include "renderer/lights/light_guide.h"

#include <fmt/format.h>

#include "renderer/lights/environment_guide.h"

namespace emberline {

std::string LightGuide::describe() const {
  if (factors == KindFactors{}) return environment->describe();
  std::string text =
      fmt::format("samples by kind of light (environment x {:g}, directional x {:g})",
                  factors.environment, factors.directional);
  if (environment) text += ", " + environment->describe();
  return text;
}

}  // namespace emberline
