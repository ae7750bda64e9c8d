// Denoises a finished frame and compares the result with a reference, which is a frame with many
// samples and another seed. The two halves of the reference serve as two independent pictures, so
// that its own noise does not bias the squared errors. This is not a test. denoise_scenes.py
// renders the frames and runs this program; the figures are in tests/bench/results.
//
//   denoise_bench FRAME.exr REFERENCE.exr [--clean FILE] [--repetitions N]
//
// Both frames need --aov denoising. Prints one line of JSON: errors of the raw and the denoised
// picture, the ratio of estimated to true error (RMS, as displayed) for both, the share of 16-pixel
// blocks whose true error is within twice the estimate, and processor seconds (median).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

#include "bench/exr_planes.h"
#include "renderer/core/display_error.h"
#include "renderer/reconstruction/denoise.h"
#include "renderer/statistics/reference_error.h"

namespace emberline::bench {
namespace {

constexpr const char* kColour[] = {"R", "G", "B"};

void write_picture(const std::string& path, const DenoisedPicture& picture, int width, int height) {
  std::vector<NamedPlane> planes = {{"denoised.error", picture.error}};
  for (size_t c = 0; c < 3; ++c) planes.emplace_back(kColour[c], picture.colour[c]);
  write_exr_planes(path, width, height, planes);
}

const std::vector<float>& plane(const ExrPlanes& frame, int half, const std::string& name) {
  return frame.planes.at(fmt::format("half{}.{}", half, name));
}

DenoiseInput halves(const ExrPlanes& frame) {
  DenoiseInput input;
  input.width = frame.width;
  input.height = frame.height;
  const auto planes = [&](const std::string& name) {
    return HalfPlanes{plane(frame, 1, name), plane(frame, 2, name)};
  };
  input.samples = planes("samples");
  for (size_t c = 0; c < 3; ++c) {
    input.colour[c] = planes(kColour[c]);
    input.albedo[c] = planes(std::string("albedo.") + kColour[c]);
  }
  for (const char* name : {"N.X", "N.Y", "N.Z", "nearness", "visibility"}) {
    input.features.push_back(planes(name));
  }
  for (size_t c = 0; c < 3; ++c) input.shared[c] = planes(std::string("shared.") + kColour[c]);
  return input;
}

template <typename Value>
RgbImage interleaved(int width, int height, const Value& value) {
  RgbImage image = {width, height, {}};
  for (size_t i = 0; i < size_t(width) * size_t(height); ++i) {
    for (size_t c = 0; c < 3; ++c) image.rgb.push_back(value(c, i));
  }
  return image;
}

// Returns the share of whole 16-pixel blocks whose true displayed error is within twice the
// estimate.
double covered_blocks(const RgbImage& clean, const RgbImage& a, const RgbImage& b,
                      const std::vector<float>& error) {
  constexpr int kBlock = 16;
  int blocks = 0, covered = 0;
  for (int y = 0; y + kBlock <= clean.height; y += kBlock) {
    for (int x = 0; x + kBlock <= clean.width; x += kBlock) {
      double truth = 0.0, estimate = 0.0;
      for (int k = 0; k < kBlock * kBlock; ++k) {
        const size_t i = size_t(y + k / kBlock) * size_t(clean.width) + size_t(x + k % kBlock);
        estimate += double(error[i]) * double(error[i]);
        for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
          const double shown = double(display_value(clean.rgb[c]));
          truth += (shown - double(display_value(a.rgb[c]))) *
                   (shown - double(display_value(b.rgb[c]))) / 3;
        }
      }
      ++blocks;
      covered += truth <= 4 * estimate + 1e-12;
    }
  }
  return blocks > 0 ? double(covered) / blocks : 1.0;
}

std::string errors_of(const RgbImage& picture, const ReferencePicture& reference) {
  const StudyError error = reference.measure(picture);
  const ErrorMetrics shown = compare_images(picture, reference.mean(), {});
  return fmt::format(R"({{"relmse": {:.6g}, "relmse_trimmed": {:.6g}, "display_mse": {:.6g}, )"
                     R"("flip": {:.5f}, "ssim": {:.5f}, "bias": {:.5f}}})",
                     error.rel_mse, error.rel_mse_trimmed, error.display_mse, error.flip,
                     shown.ssim, error.signed_bias);
}

int run(int argc, char** argv) {
  const ExrPlanes frame = read_exr_planes(argv[1]), many = read_exr_planes(argv[2]);
  std::string clean_file;
  int repetitions = 1;
  for (int i = 3; i + 1 < argc; i += 2) {
    if (std::string_view(argv[i]) == "--clean") clean_file = argv[i + 1];
    if (std::string_view(argv[i]) == "--repetitions") repetitions = std::atoi(argv[i + 1]);
  }
  const DenoiseInput input = halves(frame);
  DenoisedPicture clean;
  std::vector<double> seconds;
  for (int i = 0; i < std::max(repetitions, 1); ++i) {
    const std::clock_t start = std::clock();
    clean = denoise(input);
    seconds.push_back(double(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::sort(seconds.begin(), seconds.end());
  if (!clean_file.empty()) write_picture(clean_file, clean, frame.width, frame.height);
  const auto truth = [&](int half) {
    return interleaved(frame.width, frame.height,
                       [&](size_t c, size_t i) { return plane(many, half, kColour[c])[i]; });
  };
  const RgbImage truth_a = truth(1), truth_b = truth(2);
  const ReferencePicture reference(truth_a, truth_b);
  const RgbImage raw = picture_of(frame);
  const RgbImage picture = interleaved(frame.width, frame.height,
                                       [&](size_t c, size_t i) { return clean.colour[c][i]; });
  const double pixels = double(frame.width) * double(frame.height);
  const auto calibration = [&](double squared, const RgbImage& image) {
    return std::sqrt(squared / pixels / reference.measure(image).display_mse);
  };
  fmt::print(R"({{"raw": {}, "clean": {}, "estimate_raw": {:.3f}, "estimate_clean": {:.3f}, )"
             R"("blocks": {:.3f}, "kept": {:.4f}, "cpu_s": {:.3f}}})"
             "\n",
             errors_of(raw, reference), errors_of(picture, reference),
             calibration(clean.squared_error_before, raw),
             calibration(clean.squared_error_after, picture),
             covered_blocks(picture, truth_a, truth_b, clean.error),
             double(clean.unchanged_pixels) / pixels, seconds[seconds.size() / 2]);
  return 0;
}

}  // namespace
}  // namespace emberline::bench

int main(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "denoise_bench FRAME.exr REFERENCE.exr [--clean FILE] [--repetitions N]\n");
    return 2;
  }
  try {
    return emberline::bench::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "denoise_bench: {}\n", error.what());
    return 3;
  }
}
