#include "renderer/app/commands.h"

#include <array>

#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/output/frame_explanation.h"

namespace emberline {
namespace {

// Returns the pixel; nothing for "worst".
std::optional<Vec2i> parse_pixel(const std::string& text) {
  if (text == "worst") return std::nullopt;
  std::array<int, 2> v;
  if (!parse_numbers(text, ',', v) || v[0] < 0 || v[1] < 0) {
    throw UsageError("pixel '{}': valid is X,Y in whole pixels of the frame, or worst", text);
  }
  return Vec2i(v[0], v[1]);
}

}  // namespace

int run_explain(const ExplainOptions& options) {
  const std::optional<Vec2i> pixel = parse_pixel(options.pixel);
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  print_result(explain_frame(options.image, pixel, progress));
  return kExitDone;
}

}  // namespace emberline
