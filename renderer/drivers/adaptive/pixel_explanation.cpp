#include "renderer/drivers/adaptive/pixel_explanation.h"

#include <fmt/format.h>

#include <iterator>

#include "renderer/core/setting_names.h"
#include "renderer/drivers/adaptive/pixel_errors.h"

namespace emberline {
namespace {

std::string error_text(float error) {
  return error < kUnknownError ? fmt::format("{:.4g}", error) : "unknown";
}

// Whether an explanation must say which channel an error belongs to.
bool names_channels(const JudgedChannels* judged) { return judged && judged->size() > 1; }

// Converts an error from the scale of the frame's threshold to the channel's own scale.
std::string judged_error_text(const PixelHistory& history, float error, uint32_t channel) {
  if (!names_channels(history.judged)) return error_text(error);
  const bool limited = history.threshold > 0.0f && error < kUnknownError;
  const float scale = limited ? history.judged->threshold(channel) / history.threshold : 1.0f;
  return fmt::format("{} in {}", error_text(error * scale), (*history.judged)[channel].name);
}

// Says why the round gave the pixel more samples. Pixels that met the threshold also get more
// samples, because their few samples may have overlooked light.
std::string describe_growth(const RoundRecord& round, float threshold, uint32_t reached) {
  const bool met = threshold > 0.0f && round.error <= threshold;
  const bool doubled = round.target == 2 * round.samples && reached == round.target;
  if (met) {
    return fmt::format(
        ", which meets the threshold; extra samples for the whole frame {}",
        doubled ? "doubled its count" : fmt::format("raised its count to {}", round.target));
  }
  if (threshold <= 0.0f) {
    return fmt::format(
        ", and its share of the frame's samples {}",
        doubled ? "doubled its count" : fmt::format("raised its count to {}", round.target));
  }
  return doubled ? ", so its samples were doubled"
                 : fmt::format(", so its target was {} samples", round.target);
}

std::string describe_end(PixelStop stop) {
  switch (stop) {
    case PixelStop::kThreshold:
      return ", so the pixel was finished";
    case PixelStop::kBudget:
      return spell_setting_names(" when all samples of the frame (`spp`) had been taken");
    case PixelStop::kMaximum:
      return spell_setting_names(", and it had reached `max-spp`");
    default:
      return fmt::format(" when {} ended the frame", pixel_stop_name(stop));
  }
}

}  // namespace

std::string describe_history(const PixelHistory& history) {
  std::string text;
  const auto add_error = [&](uint32_t samples, float error, uint32_t channel) {
    const std::string error_and_channel = judged_error_text(history, error, channel);
    if (!text.empty()) {
      text += fmt::format("; at {} it was {}", samples, error_and_channel);
      return;
    }
    text = fmt::format("At {} samples its error was {}", samples, error_and_channel);
    if (history.threshold > 0.0f && !names_channels(history.judged)) {
      text += fmt::format(" (threshold {:.4g})", history.threshold);
    }
  };
  for (size_t i = 0; i < history.rounds.size(); ++i) {
    const RoundRecord& round = history.rounds[i];
    if (round.target <= round.samples) continue;
    const bool last = i + 1 == history.rounds.size();
    const uint32_t reached = last ? history.samples : history.rounds[i + 1].samples;
    add_error(round.samples, round.error, round.judged);
    text += describe_growth(round, history.threshold, reached);
  }
  if (history.end) {
    add_error(history.samples, history.error,
              history.judged ? history.judged->recorded_channel() : 0);
    return text + describe_end(*history.end) + ".\n";
  }
  return text.empty() ? "" : text + fmt::format("; it has {} so far.\n", history.samples);
}

std::string judged_errors(const JudgedChannels& judged) {
  if (judged.size() == 1 || judged.recorded_errors().empty()) return "";
  std::string text = "judged by";
  for (size_t k = 0; k < judged.size(); ++k) {
    text += fmt::format("{} {} {}", k > 0 ? "," : "", judged[k].name,
                        error_text(judged.recorded_errors()[k]));
    if (judged.threshold(k) > 0.0f) text += fmt::format(" (threshold {:.4g})", judged.threshold(k));
  }
  return text + "\n";
}

std::string rounds_table(const PixelHistory& history) {
  std::string text = "rounds";
  const auto out = std::back_inserter(text);
  if (history.recorded_since > 0) {
    fmt::format_to(out, " (recorded from round {} on)", history.recorded_since);
  }
  const bool names = names_channels(history.judged);
  fmt::format_to(out, "\n  {:>5} {:>8} {:>10} {:>10} {:>6} {:>8}{}\n", "round", "samples", "error",
                 "deviation", "cost", "target", names ? "  channel" : "");
  for (const RoundRecord& r : history.rounds) {
    fmt::format_to(out, "  {:>5} {:>8} {:>10.4g} {:>10.4g} {:>6.3g} {:>8}{}\n", r.round, r.samples,
                   r.error, r.deviation, r.cost, r.target,
                   names ? "  " + (*history.judged)[r.judged].name : "");
  }
  text += spell_setting_names(
      "  round      number of the round in the frame\n"
      "  samples    the pixel's samples when the round was planned\n"
      "  error      the error that is compared with `noise-threshold`\n"
      "  deviation  standard deviation of one sample; more samples go where it is "
      "high\n"
      "  cost       rays per sample; a camera ray counts as 0.17\n"
      "  target     the pixel's samples after the round\n");
  if (names) {
    text +=
        "  channel    the channel with the largest error in comparison with its threshold; the "
        "error\n"
        "             is scaled such that it can be compared with that of R G B\n";
  }
  return text;
}

std::string tree_table(std::span<const RefinementNode> path) {
  std::string text = "refinement tree, from the crop down to the leaf with this pixel\n";
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "  {:>24} {:>10} {:>10} {:>10} {:>6}  {}\n", "rectangle", "v_int", "v_ext",
                 "priority", "round", "phase");
  for (const RefinementNode& step : path) {
    const Rect& r = step.rect;
    fmt::format_to(out, "  {:>24} {:>10.3g} {:>10.3g} {:>10.3g} {:>6}  {}{}\n",
                   fmt::format("{},{} {}x{}", r.x0, r.y0, r.width(), r.height()), step.v_int,
                   step.v_ext, step.priority, step.round, refinement_phase_name(step.phase),
                   step.leaf ? ", leaf" : "");
  }
  return text +
         "  rectangle  corner and size in pixels; the next row shows the half that contains the "
         "pixel\n"
         "  v_int      variance of the displayed values of the two samples that the last cut "
         "separated\n"
         "  v_ext      variance of the displayed values of the rectangle and its neighbours\n"
         "  priority   area x (the higher variance + 0.001); rectangles with the highest priority "
         "are cut first\n"
         "  round      how many times the tree had been refined before the cut\n"
         "  phase      the kind of rectangles that were being cut: large ones (coverage), those\n"
         "             with variance (features) or all others (pixel level); finished means a\n"
         "             single pixel\n";
}

}  // namespace emberline
