#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "io/exr/writer.h"
#include "io/files/atomic_file.h"
#include "io/files/register.h"
#include "renderer/app/frame_range.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/rect_values.h"
#include "renderer/core/utf8.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/flip_picture.h"
#include "renderer/output/outputs.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/flicker.h"
#include "renderer/statistics/flip.h"
#include "renderer/statistics/svg_chart.h"
#include "renderer/statistics/value_list.h"

namespace emberline {
namespace {

// One row per metric, used for both the table and the JSON.
struct MetricRow {
  const char* key;
  double ErrorMetrics::*value;
  const char* meaning;
};
constexpr MetricRow kMetrics[] = {
    {"mse", &ErrorMetrics::mse, "mean squared error"},
    {"rmse", &ErrorMetrics::rmse, "square root of mse"},
    {"relmse", &ErrorMetrics::rel_mse, "mean of (x - r)^2 / (r^2 + epsilon)"},
    {"relmse_epsilon", &ErrorMetrics::rel_mse_epsilon, "epsilon of relmse"},
    {"relmse_trimmed", &ErrorMetrics::rel_mse_trimmed,
     "relmse without the worst 0.1 % of the pixels"},
    {"signed_bias", &ErrorMetrics::signed_bias, "sum(x - r) / sum(r)"},
    {"psnr", &ErrorMetrics::psnr, "dB, as displayed"},
    {"ssim", &ErrorMetrics::ssim, "structural similarity, 1 if equal, as displayed"},
    {"flip", &ErrorMetrics::flip, "mean FLIP, 0 if equal, as displayed"},
    {"max_abs", &ErrorMetrics::max_absolute, "largest difference"},
};

using Json = nlohmann::ordered_json;

// The JSON library writes values that are not finite as null.
void add_metrics(const RgbImage& image, const ErrorMetrics& metrics, Json* json) {
  (*json)["width"] = image.width;
  (*json)["height"] = image.height;
  for (const MetricRow& row : kMetrics) (*json)[row.key] = metrics.*row.value;
  (*json)["non_finite"] = metrics.non_finite;
  (*json)["different_pixels"] = metrics.different_pixels;
}

void print_table(const CompareOptions& options, const RgbImage& image,
                 const ErrorMetrics& metrics) {
  std::string text = fmt::format("{}\nagainst {}\n{} x {} pixels\n\n", printable(options.image),
                                 printable(options.reference), image.width, image.height);
  const auto line = [&](const char* key, const std::string& value, const std::string& meaning) {
    fmt::format_to(std::back_inserter(text), "{:<17}{:>14}   {}\n", key, value, meaning);
  };
  for (const MetricRow& row : kMetrics) {
    line(row.key, fmt::format("{:.6g}", metrics.*row.value), row.meaning);
  }
  const double percent_per_pixel = 100.0 / (double(image.width) * double(image.height));
  line("different_pixels", std::to_string(metrics.different_pixels),
       fmt::format("pixels whose bits differ ({:.4g} %)",
                   double(metrics.different_pixels) * percent_per_pixel));
  line("non_finite", std::to_string(metrics.non_finite),
       metrics.non_finite == 0 ? "pixels with a NaN or infinity"
                               : "pixels with a NaN or infinity, excluded from the metrics above");
  print_result(text);
}

void write_difference_exr(const CompareOptions& options, const RgbImage& image,
                          const RgbImage& reference, const std::vector<float>& flip) {
  const ExrHeader header = {.width = image.width,
                            .height = image.height,
                            .data_window = {0, 0, image.width, image.height},
                            .channels = {{"R"}, {"G"}, {"B"}, {"flip"}},
                            .attributes = {{"emberline.image", options.image},
                                           {"emberline.reference", options.reference}}};
  std::vector<float> pixels;
  pixels.reserve(4 * flip.size());
  for (size_t i = 0; i < flip.size(); ++i) {
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) pixels.push_back(image.rgb[c] - reference.rgb[c]);
    pixels.push_back(flip[i]);
  }
  write_exr_file(options.difference, header, pixels);
}

// A picture, its reference and its metrics.
struct ComparedFrame {
  RgbFile image;
  RgbImage reference;
  PixelMotion motion;  // the reference's motion if it covers these pixels, else the image's
  ErrorMetrics metrics;
};

// If `explains` is set, logs what is measured.
ComparedFrame compare_frame(const CompareOptions& options, bool explains, bool reads_motion,
                            const LoadProgress& progress) {
  LayerChoice choice = {
      .layer = options.layer, .reads_motion = reads_motion, .remedy = "choose one with `layer`"};
  ComparedFrame frame;
  frame.image = read_rgb(options.image, progress, choice);
  const RgbFile& image = frame.image;
  choice.is_reference = true;
  RgbFile reference = read_rgb(options.reference, progress, choice);
  frame.motion = std::exchange(frame.image.motion, {});
  const bool is_same_frame =
      reference.frame_width == image.frame_width && reference.frame_height == image.frame_height;
  if (!reference.motion.empty() && is_same_frame &&
      reference.crop.intersect(image.crop) == image.crop) {
    frame.motion = {extract_rect(reference.motion.right, reference.crop, image.crop),
                    extract_rect(reference.motion.down, reference.crop, image.crop)};
  }
  frame.reference = reference_pixels(std::move(reference), options.image, image.crop,
                                     image.frame_width, image.frame_height);
  if (explains && options.layer.empty() && image.has_denoised) {
    log_info(
        fmt::format("measuring R, G and B of {}, which are not denoised; --layer {} measures "
                    "the denoised picture",
                    options.image, kDenoisedLayer));
  }
  if (explains && !image.is_whole_frame()) {
    const Rect& w = image.crop;
    log_info(fmt::format("comparing only the pixels in {}: --crop {},{},{},{}", options.image, w.x0,
                         w.y0, w.x1, w.y1));
  }
  progress.budget()->reserve(MemoryPart::kFilm,
                             bytes_of(image.pixels.rgb.size() / 3, kComparisonBytesPerPixel),
                             "the metrics of " + options.image);
  frame.metrics = compare_images(image.pixels, frame.reference, {options.exposure});
  if (!options.difference.empty()) {
    const std::vector<uint8_t> masked = non_finite_pixels(image.pixels, frame.reference);
    const std::vector<float> flip = flip_map(to_display(image.pixels, options.exposure, masked),
                                             to_display(frame.reference, options.exposure, masked));
    if (is_exr(options.difference)) {
      write_difference_exr(options, image.pixels, frame.reference, flip);
    } else {
      write_flip_picture(options.difference, image.pixels, flip, masked);
    }
  }
  return frame;
}

// The metrics of one frame of a sequence.
struct SequenceRow {
  int frame = 0;
  Json json;
};

constexpr const char* kSequenceMetrics[] = {"relmse", "relmse_trimmed", "flip", "flicker"};

double value_of(const SequenceRow& row, const char* metric) {
  const Json& value = row.json.at(metric);
  return value.is_number() ? value.get<double>() : ErrorMetrics::kNone;
}

// Returns the numbers of the frames that both sequences have. Logs the frames without a reference.
std::vector<int> frames_to_compare(const CompareOptions& options) {
  std::vector<int> frames = existing_frames(options.image);
  if (!is_sequence(options.reference)) return frames;
  const std::vector<int> references = existing_frames(options.reference);
  std::vector<int> both, without;
  std::ranges::set_intersection(frames, references, std::back_inserter(both));
  std::ranges::set_difference(frames, references, std::back_inserter(without));
  if (both.empty()) {
    throw InputError(options.reference, "no frame of {} has a reference", options.image);
  }
  if (!without.empty()) {
    log_info(fmt::format("{}: frames without a reference are left out: {}", options.image,
                         format_frames(without)));
  }
  return both;
}

CompareOptions options_of_frame(const CompareOptions& options, int number) {
  CompareOptions one = options;
  one.image = expand_frame_number(options.image, number);
  if (is_sequence(options.reference)) {
    one.reference = expand_frame_number(options.reference, number);
  }
  one.difference = expand_frame_number(options.difference, number);
  return one;
}

// Throws UsageError if an output is one of the pictures or another output.
void check_files(const CompareOptions& options, std::span<const int> frames) {
  FileRegister files;
  const char* const kInput = "it is one of the pictures compared";
  files.read(options.reference, kInput);
  for (const int number : frames) {
    const CompareOptions one = options_of_frame(options, number);
    files.read(one.image, kInput);
    files.read(one.reference, kInput);
  }
  for (const int number : frames) {
    const std::string difference = options_of_frame(options, number).difference;
    if (!difference.empty()) files.write("-o", difference);
  }
  if (!options.chart.empty()) files.write("--chart", options.chart);
}

// Returns the flicker between two consecutive frames, or nullopt if it cannot be measured.
std::optional<Flicker> flicker_between(const ComparedFrame& frame, const ComparedFrame& next) {
  if (frame.image.crop != next.image.crop) {
    log_info(fmt::format("{}: flicker is not measured, because the previous frame has another crop",
                         next.image.path));
    return std::nullopt;
  }
  const Flicker measured =
      flicker({frame.image.pixels, frame.reference, frame.motion},
              {next.image.pixels, next.reference, next.motion}, frame.metrics.rel_mse_epsilon);
  return measured.share > 0 ? std::optional(measured) : std::nullopt;
}

std::vector<SequenceRow> compare_frames(const CompareOptions& options,
                                        std::span<const int> frames) {
  std::vector<SequenceRow> rows;
  std::optional<ComparedFrame> last;
  for (const int number : frames) {
    const CompareOptions one = options_of_frame(options, number);
    const LoadProgress progress({}, {}, limits_of(options.limits, one.image));
    if (last) {
      constexpr uint64_t kBytesPerPixel = 8 * sizeof(float);  // two pictures and the motion
      progress.budget()->reserve(MemoryPart::kFilm,
                                 bytes_of(last->reference.rgb.size() / 3, kBytesPerPixel),
                                 "the frame before " + one.image);
    }
    ComparedFrame frame = compare_frame(one, rows.empty(), true, progress);
    SequenceRow row{number, {{"frame", number}}};
    add_metrics(frame.image.pixels, frame.metrics, &row.json);
    row.json["flicker"] = row.json["flicker_share"] = nullptr;
    if (last && number == rows.back().frame + 1) {
      if (const std::optional<Flicker> measured = flicker_between(*last, frame)) {
        rows.back().json["flicker"] = measured->value;
        rows.back().json["flicker_share"] = measured->share;
      }
    }
    rows.push_back(std::move(row));
    last = std::move(frame);
  }
  if (last && last->motion.empty() && rows.size() > 1) {
    log_info("the pictures have no layer velocity; flicker is measured as if nothing moved");
  }
  return rows;
}

// Returns the median, mean and largest value of a metric over the frames that have it, or null if
// no frame has it.
Json summary_of(const std::vector<SequenceRow>& rows, const char* metric) {
  std::vector<double> values;
  for (const SequenceRow& row : rows) values.push_back(value_of(row, metric));
  const std::optional<ValueSummary> summary = summary_of_finite(std::move(values));
  if (!summary) return nullptr;
  return {{"median", summary->median}, {"mean", summary->mean}, {"largest", summary->largest}};
}

void print_sequence(const CompareOptions& options, const std::vector<SequenceRow>& rows) {
  Json summary;
  for (const char* metric : kSequenceMetrics) summary[metric] = summary_of(rows, metric);
  if (options.json) {
    Json json = {{"frames", Json::array()}, {"summary", summary}};
    for (const SequenceRow& row : rows) json["frames"].push_back(row.json);
    print_result(json.dump(2) + "\n");
    return;
  }
  std::string text = fmt::format("{}\nagainst {}\n\n{:>9}", printable(options.image),
                                 printable(options.reference), "frame");
  const auto out = std::back_inserter(text);
  for (const char* metric : kSequenceMetrics) fmt::format_to(out, "{:>16}", metric);
  text += '\n';
  const auto line = [&](const std::string& name, const auto& value) {
    fmt::format_to(out, "{:>9}", name);
    for (const char* metric : kSequenceMetrics) {
      const Json number = value(metric);
      const double shown = number.is_number() ? number.template get<double>() : ErrorMetrics::kNone;
      text += std::isfinite(shown) ? fmt::format("{:>16.6g}", shown) : fmt::format("{:>16}", "-");
    }
    text += '\n';
  };
  for (const SequenceRow& row : rows) {
    line(std::to_string(row.frame), [&](const char* metric) { return row.json.at(metric); });
  }
  text += '\n';
  for (const char* name : {"median", "mean", "largest"}) {
    line(name, [&](const char* metric) {
      const Json& values = summary.at(metric);
      return values.is_null() ? values : values.at(name);
    });
  }
  text +=
      "\nflicker: how much the relative error changes until the next frame, at points that move\n"
      "with the scene, without the worst 0.1 % of the pixels. Independent errors give about the\n"
      "sum of both relmse_trimmed; errors that move with things give about 0.\n";
  print_result(text);
}

void write_chart(const std::string& path, const std::vector<SequenceRow>& rows) {
  LineChart chart{.title = "Error of each frame",
                  .x = {"frame"},
                  .y = {"squared error, relative", AxisScale::kLog},
                  .series = {}};
  for (const char* metric : {"relmse_trimmed", "flicker"}) {
    ChartSeries series{metric};
    for (const SequenceRow& row : rows) {
      series.points.push_back({double(row.frame), value_of(row, metric)});
    }
    chart.series.push_back(std::move(series));
  }
  write_file_atomically(path, line_chart(chart).html + "\n");
}

int run_sequence(const CompareOptions& options) {
  if (!options.difference.empty() && !has_frame_number(options.difference)) {
    throw UsageError("-o: {} needs a frame number, such as ####, because each frame gets a file",
                     options.difference);
  }
  if (!options.chart.empty()) check_writable(options.chart);
  const std::vector<int> frames = frames_to_compare(options);
  check_files(options, frames);
  const std::vector<SequenceRow> rows = compare_frames(options, frames);
  print_sequence(options, rows);
  if (!options.chart.empty()) write_chart(options.chart, rows);
  return kExitDone;
}

}  // namespace

int run_compare(const CompareOptions& options) {
  const WorkerThreads workers(0);
  if (!std::isfinite(options.exposure)) throw UsageError("--exposure must be a finite number");
  if (!options.difference.empty()) check_picture_format(options.difference, {});
  if (!options.chart.empty() && lower_suffix(options.chart) != ".svg") {
    throw UsageError("--chart: {} is no .svg file", options.chart);
  }
  if (is_sequence(options.image)) return run_sequence(options);
  if (!options.chart.empty()) throw UsageError("--chart needs a sequence, such as shot.####.exr");
  if (is_sequence(options.reference)) {
    throw UsageError("{} is a sequence, but {} is not", options.reference, options.image);
  }
  FileRegister files;
  for (const std::string& input : {options.image, options.reference}) {
    files.read(input, "it is one of the pictures compared");
  }
  if (!options.difference.empty()) files.write("-o", options.difference);
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  const ComparedFrame frame = compare_frame(options, true, false, progress);
  if (options.json) {
    Json json;
    add_metrics(frame.image.pixels, frame.metrics, &json);
    print_result(json.dump(2) + "\n");
  } else {
    print_table(options, frame.image.pixels, frame.metrics);
  }
  return kExitDone;
}

}  // namespace emberline
