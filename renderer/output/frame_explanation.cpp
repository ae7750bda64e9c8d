#include "renderer/output/frame_explanation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "io/image/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/readable.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/utf8.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/engine/render_plan.h"
#include "renderer/film/pixel_stop.h"
#include "renderer/output/option_rules.h"
#include "renderer/output/recorded_settings.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/heatmap_quantity.h"

namespace emberline {
namespace {

std::string number(double value) { return readable_number(value, 4); }

// The settings that the frame's header states.
struct StatedSettings {
  explicit StatedSettings(const FloatImageRows& file)
      : recorded(file.text_attributes()),
        is_uniform(!recorded.text("driver").empty() && samples_uniformly(recorded.settings())),
        threshold(recorded.settings().noise_threshold) {}

  RecordedSettings recorded;
  bool is_uniform;
  std::optional<float> threshold;
};

// Computes one quantity of a pixel, if the file has the channels for it.
class PixelQuantity {
 public:
  PixelQuantity(const char* name, const std::vector<std::string>& channels)
      : quantity_(find_heatmap_quantity(name)),
        sources_(QuantityPlane::find_channels(quantity_, channels)) {}

  bool is_known() const { return sources_.has_value(); }
  std::optional<float> of(const float* pixel) const {
    if (!sources_) return std::nullopt;
    std::array<float, QuantityPlane::kMaxChannels> values{};
    for (size_t c = 0; c < sources_->size(); ++c) values[c] = pixel[(*sources_)[c]];
    return quantity_.value(values.data());
  }

 private:
  const HeatmapQuantity& quantity_;
  std::optional<std::vector<size_t>> sources_;
};

// Sums and extremes over all pixels, and the values of the pixel to explain.
struct FrameSummary {
  Vec2i pixel = {};
  std::vector<float> values;  // the pixel's channels
  double pixels = 0, samples = 0, least = INFINITY, most = 0;
  double errors = 0, error_squares = 0, above = 0;  // only over pixels with a known error
  float largest_error = -1;
};

class FrameReader {
 public:
  FrameReader(const std::string& name, const LoadProgress& progress)
      : path(name),
        file(name, progress),
        settings(file),
        samples("samples", image().channel_names),
        error("error", image().channel_names) {
    if (!samples.is_known()) {
      throw InputError(
          name, "it has no channel named \"samples\"; use an .exr that `emberline render` wrote");
    }
  }

  const FloatImage& image() const { return file.image(); }

  FrameSummary read(std::optional<Vec2i> pixel, const LoadProgress& progress) {
    const Rect& crop = image().data_window;
    const int most_rows = file.tile_size();
    const MemoryReservation memory(
        progress.budget(), MemoryPart::kTextures,
        bytes_of(uint64_t(crop.width()) * uint64_t(std::min(most_rows, crop.height())),
                 image().channel_names.size() * sizeof(float)),
        path);
    FrameSummary summary;
    std::vector<float> values;
    for (int y = crop.y0; y < crop.y1; y += most_rows) {
      const Rect rows = {crop.x0, y, crop.x1, std::min(y + most_rows, crop.y1)};
      file.read(rows.height(), values);
      add(rows, values, pixel, summary);
    }
    return summary;
  }

  const std::string path;
  FloatImageRows file;
  const StatedSettings settings;
  const PixelQuantity samples, error;

 private:
  // Adds these rows to the summary. If no `pixel` is given, chooses the pixel with the largest
  // error.
  void add(const Rect& rows, const std::vector<float>& values, std::optional<Vec2i> pixel,
           FrameSummary& summary) const {
    const size_t channels = image().channel_names.size();
    for (size_t i = 0; i < size_t(rows.area()); ++i) {
      const float* at = &values[i * channels];
      const double count = double(*samples.of(at));
      summary.pixels += 1;
      summary.samples += count;
      summary.least = std::min(summary.least, count);
      summary.most = std::max(summary.most, count);
      const Vec2i position(rows.x_of(i), rows.y_of(i));
      bool chosen = pixel && position.x == pixel->x && position.y == pixel->y;
      const float own_error = error.of(at).value_or(NAN);
      if (own_error >= 0) {
        summary.errors += 1;
        summary.error_squares += double(own_error) * double(own_error);
        summary.above += own_error > settings.threshold.value_or(INFINITY);
        chosen |= !pixel && own_error > summary.largest_error;
        summary.largest_error = std::max(summary.largest_error, own_error);
      }
      if (!chosen) continue;
      summary.pixel = position;
      summary.values.assign(at, at + channels);
    }
  }
};

std::string describe_samples(const FrameReader& frame, const FrameSummary& s) {
  const double samples = double(*frame.samples.of(s.values.data()));
  return fmt::format("pixel {},{}: {} sample{}; the frame has {} to {}, {} on average\n", s.pixel.x,
                     s.pixel.y, number(samples), samples == 1 ? "" : "s", number(s.least),
                     number(s.most), number(s.samples / s.pixels));
}

std::string describe_stop(float stop, const StatedSettings& settings) {
  const std::string threshold =
      settings.threshold ? " " + number(double(*settings.threshold)) : std::string();
  if (stop == float(PixelStop::kNone)) return "It got no sample.\n";
  if (stop == float(PixelStop::kBudget)) {
    if (!settings.recorded.text("plan").empty()) {
      return "It stopped at the number of samples that the plan gives it.\n";
    }
    return settings.is_uniform
               ? "It stopped at the number of samples that every pixel gets (`spp`).\n"
               : "It stopped when the sample budget of the frame (`spp`) was used up.\n";
  }
  if (stop == float(PixelStop::kThreshold)) {
    return "It stopped because its error met `noise-threshold`" + threshold + ".\n";
  }
  if (stop == float(PixelStop::kMaximum)) {
    return "It stopped because it had as many samples as `max-spp` allows.\n";
  }
  if (stop == float(PixelStop::kTimeLimit))
    return "It stopped when `time-limit` ended the frame.\n";
  if (stop == float(PixelStop::kTimeBudget)) return "It stopped at the end of `time-budget`.\n";
  if (stop == float(PixelStop::kUser)) return "It stopped when the user stopped the frame.\n";
  if (stop == float(PixelStop::kUnfinished)) {
    return "It was unfinished when a window saved the frame.\n";
  }
  return fmt::format("The value {} of its channel stop is unknown.\n", number(double(stop)));
}

// Returns a sentence that names the channel for which the pixel got its last samples. Returns ""
// unless several channels of `judge` decided the samples.
std::string describe_judged(float channel, const StatedSettings& settings) {
  const std::vector<JudgedChannel> judged = judged_channels_of(settings.recorded.settings());
  const bool has_decided = settings.recorded.text("plan").empty() && judged.size() > 1;
  if (!has_decided || !(channel >= 0 && channel < float(judged.size()))) return "";
  return fmt::format("Its last samples were for {}, one of the channels of `judge` {}.\n",
                     judged[size_t(channel)].name, settings.recorded.settings().judge);
}

// Returns a description of the error that the driver compares with `noise-threshold`. The file does
// not contain this error itself.
std::string threshold_error(const StatedSettings& s) {
  for (const EstimatorEntry& entry : estimator_table()) {
    if (entry.name != s.recorded.settings().estimator) continue;
    return entry.halves || entry.name == "two-stream"
               ? "an average over 5 x 5 pixels, because the error of one pixel is unreliable"
               : fmt::format("the estimate of `estimator` {}", entry.name);
  }
  return "the driver's own estimate";
}

std::string describe_error(const FrameReader& frame, const FrameSummary& s) {
  const std::optional<float> error = frame.error.of(s.values.data());
  if (!error) return "Its error is not in the file; render it with `aov` variance.\n";
  if (!(*error >= 0)) return "Its error is unknown: an estimate needs two samples.\n";
  std::string text = fmt::format(
      "Its error, estimated from its own samples alone, is {} (RMS as displayed, 0 to 1); all "
      "pixels: RMS {}, maximum {}.\n",
      number(double(*error)), number(std::sqrt(s.error_squares / s.errors)),
      number(double(s.largest_error)));
  if (frame.settings.is_uniform) {
    return text +
           "Unless `streams` is 2, this treats samples as independent and is an upper estimate.\n";
  }
  if (!frame.settings.threshold) return text;
  return text + fmt::format(
                    "The driver compares `noise-threshold` {} with a different error: {}. By the "
                    "estimates from their own samples alone, {} of {} pixels are above the "
                    "threshold.\n",
                    number(double(*frame.settings.threshold)), threshold_error(frame.settings),
                    number(s.above), number(s.errors));
}

std::string describe_history(const StatedSettings& settings, const Vec2i& pixel) {
  const std::string place = fmt::format("{},{}", pixel.x, pixel.y);
  const std::string explanation = settings.recorded.text("explanation");
  if (explanation.starts_with(place + ": ")) {
    return printable(explanation.substr(place.size() + 2)) + "\n";
  }
  if (settings.recorded.text("driver") != "adaptive") return "";
  return fmt::format("The history of its error is not in the file; render it with `explain` {}.\n",
                     place);
}

std::string describe_cost(const FrameReader& frame, const FrameSummary& s) {
  const std::vector<std::string>& channels = frame.image().channel_names;
  std::string text;
  const float* values = s.values.data();
  if (const auto seconds = PixelQuantity("time", channels).of(values)) {
    text += fmt::format("It took {}.\n", readable_seconds(double(*seconds)));
  }
  if (const auto rays = PixelQuantity("rays", channels).of(values)) {
    text += fmt::format("It took {} rays.\n", number(double(*rays)));
  }
  if (const auto bad = PixelQuantity("non_finite", channels).of(values); bad && *bad > 0) {
    text += fmt::format("{} of its samples were NaN or infinite and count as black.\n",
                        number(double(*bad)));
  }
  if (const auto error = PixelQuantity("denoised_error", channels).of(values)) {
    text += fmt::format("Its error when denoised is {}.\n", number(double(*error)));
  }
  return text;
}

void check_pixel(const std::optional<Vec2i>& pixel, const FrameReader& frame) {
  if (!pixel) {
    if (frame.error.is_known()) return;
    throw InputError(frame.path,
                     "it has no layer named \"variance\", which is needed to find the worst pixel; "
                     "render it with `aov` variance");
  }
  const std::string error = outside_message(*pixel, frame.image().data_window);
  if (!error.empty()) throw UsageError(error);
}

}  // namespace

std::string explanation_attribute(const Vec2i& pixel, std::string text) {
  text = fmt::format("{},{}: {}", pixel.x, pixel.y, text);
  if (!text.empty() && text.back() == '\n') text.pop_back();
  if (text.size() <= kMaxExplanation) return text;
  constexpr std::string_view kCut = " ...";
  return text.substr(0, kMaxExplanation - kCut.size()) + std::string(kCut);
}

std::string explain_frame(const std::string& path, std::optional<Vec2i> pixel,
                          const LoadProgress& progress) {
  FrameReader frame(path, progress);
  check_pixel(pixel, frame);
  warn_if_stopped(path, frame.image());
  const FrameSummary summary = frame.read(pixel, progress);
  if (summary.values.empty()) {
    throw InputError(path, "no pixel has two samples, which an error estimate needs");
  }
  std::string text = describe_samples(frame, summary);
  const std::vector<std::string>& channels = frame.image().channel_names;
  const std::optional<float> stop = PixelQuantity("stop", channels).of(summary.values.data());
  text += stop ? describe_stop(*stop, frame.settings)
               : "Why it stopped is not in the file; render it with `aov` stop.\n";
  const std::optional<float> judged = PixelQuantity("judge", channels).of(summary.values.data());
  if (judged && stop != float(PixelStop::kUnfinished))
    text += describe_judged(*judged, frame.settings);
  text += describe_history(frame.settings, summary.pixel);
  text += describe_error(frame, summary) + describe_cost(frame, summary);
  return spell_setting_names(text);
}

}  // namespace emberline
