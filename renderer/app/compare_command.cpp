#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <vector>

#include "io/exr/writer.h"
#include "io/files/register.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/utf8.h"
#include "renderer/engine/worker_threads.h"
#include "renderer/output/flip_picture.h"
#include "renderer/output/outputs.h"
#include "renderer/output/rgb_file.h"
#include "renderer/statistics/error_metrics.h"
#include "renderer/statistics/flip.h"

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

void print_json(const RgbImage& image, const ErrorMetrics& metrics) {
  nlohmann::ordered_json json = {{"width", image.width}, {"height", image.height}};
  // The JSON library writes values that are not finite as null.
  for (const MetricRow& row : kMetrics) json[row.key] = metrics.*row.value;
  json["non_finite"] = metrics.non_finite;
  json["different_pixels"] = metrics.different_pixels;
  print_result(json.dump(2) + "\n");
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

}  // namespace

int run_compare(const CompareOptions& options) {
  const WorkerThreads workers(0);
  if (!std::isfinite(options.exposure)) throw UsageError("--exposure must be a finite number");
  if (!options.difference.empty()) {
    check_picture_format(options.difference, {});
    FileRegister files;
    files.write("-o", options.difference);
    for (const std::string& input : {options.image, options.reference}) {
      files.read(input, "it is one of the pictures compared");
    }
  }
  const LoadProgress progress({}, {}, limits_of(options.limits, options.image));
  LayerChoice choice = {.layer = options.layer, .remedy = "choose one with `layer`"};
  const RgbFile file = read_rgb(options.image, progress, choice);
  const RgbImage& image = file.pixels;
  choice.is_reference = true;
  const RgbImage reference =
      reference_pixels(read_rgb(options.reference, progress, choice), options.image, file.crop,
                       file.frame_width, file.frame_height);
  if (options.layer.empty() && file.has_denoised) {
    log_info(
        fmt::format("measuring R, G and B of {}, which are not denoised; --layer {} measures "
                    "the denoised picture",
                    options.image, kDenoisedLayer));
  }
  if (!file.is_whole_frame()) {
    const Rect& w = file.crop;
    log_info(fmt::format("comparing only the pixels in {}: --crop {},{},{},{}", options.image, w.x0,
                         w.y0, w.x1, w.y1));
  }

  progress.budget()->reserve(MemoryPart::kFilm,
                             bytes_of(image.rgb.size() / 3, kComparisonBytesPerPixel),
                             "the metrics of " + options.image);
  const ErrorMetrics metrics = compare_images(image, reference, {options.exposure});
  if (!options.difference.empty()) {
    const std::vector<uint8_t> masked = non_finite_pixels(image, reference);
    const std::vector<float> flip = flip_map(to_display(image, options.exposure, masked),
                                             to_display(reference, options.exposure, masked));
    if (is_exr(options.difference)) {
      write_difference_exr(options, image, reference, flip);
    } else {
      write_flip_picture(options.difference, image, flip, masked);
    }
  }
  if (options.json) {
    print_json(image, metrics);
  } else {
    print_table(options, image, metrics);
  }
  return kExitDone;
}

}  // namespace emberline
