// `--replay X,Y,SAMPLE`: repeats one sample exactly as the render computed it.
#include <fmt/format.h>

#include <array>
#include <iterator>

#include "renderer/app/command_frame.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"
#include "renderer/engine/setting_table.h"

namespace emberline {

int CommandFrame::replay() {
  const std::string& address = *options_.replay;
  const Frame& frame = job_->frame();
  std::array<int64_t, 3> numbers{};
  if (!parse_numbers(address, ',', numbers)) {
    throw UsageError("--replay: '{}' is not X,Y,SAMPLE", shortened(address));
  }
  if (numbers[0] < 0 || numbers[0] >= frame.width || numbers[1] < 0 || numbers[1] >= frame.height) {
    throw UsageError("--replay: pixel {},{} is outside the {} x {} frame", numbers[0], numbers[1],
                     frame.width, frame.height);
  }
  if (numbers[2] < 0 || numbers[2] >= int64_t(kMaxSamples)) {
    throw UsageError("--replay: sample {} is not from 0 to {}", numbers[2], kMaxSamples - 1);
  }
  const int x = int(numbers[0]), y = int(numbers[1]);
  const auto sample = uint32_t(numbers[2]);
  const auto [value, ray, rays] = job_->replay(x, y, sample);
  std::string text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "pixel {},{} sample {} seed {}", x, y, sample, options_.seed);
  if (sampling_seed(options_) != options_.seed) {
    for (const char* name : {"frame", "turntable"}) {
      const std::string given = find_setting(name)->text(options_);
      if (!given.empty()) fmt::format_to(out, " {} {}", name, given);
    }
  }
  text += '\n';
  fmt::format_to(
      out, "ray origin {:.9g} {:.9g} {:.9g} direction {:.9g} {:.9g} {:.9g} (internal space)\n",
      ray.origin.x, ray.origin.y, ray.origin.z, ray.direction.x, ray.direction.y, ray.direction.z);
  if (frame.moves()) {
    fmt::format_to(out, "time {:.9g} (0: the shutter opens, 1: it closes)\n", ray.time);
  }
  // {:a} prints numbers exactly, so that two replays can be compared bit by bit.
  fmt::format_to(out, "radiance {:.9g} {:.9g} {:.9g} ({:a} {:a} {:a})\n", value.radiance.x,
                 value.radiance.y, value.radiance.z, value.radiance.x, value.radiance.y,
                 value.radiance.z);
  fmt::format_to(out, "alpha {:.9g}\nrays camera {} scatter {} shadow {}\n", value.alpha,
                 rays.camera, rays.scatter, rays.shadow);
  print_result(text);
  return is_finite(value.radiance) ? kExitDone : kExitRenderFailed;
}

}  // namespace emberline
