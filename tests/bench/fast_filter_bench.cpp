// Runs the window's fast filter on a finished frame, times it, and compares the result with a
// reference of many samples. This is not a test. tests/bench/results has the figures.
//
//   fast_filter_bench FRAME.exr REFERENCE_A.exr REFERENCE_B.exr [--levels N] [--threads N]
//       [--repetitions N] [--clean FILE]
//
// FRAME needs --aov albedo,N,Z,variance; the references have other seeds. Prints one line of JSON:
// errors of the raw and the filtered picture, and milliseconds of wall time and processor time
// (medians).
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

#include "bench/exr_planes.h"
#include "renderer/core/vector.h"
#include "renderer/reconstruction/fast_filter.h"
#include "renderer/statistics/reference_error.h"

namespace emberline::bench {
namespace {

FastFilter::ReadRow reader(const ExrPlanes& frame) {
  return [&frame](int y, const FeatureRow& row) {
    const size_t first = size_t(y) * size_t(frame.width);
    const auto plane = [&](const char* name) { return &frame.planes.at(name)[first]; };
    const float* albedo[] = {plane("albedo.R"), plane("albedo.G"), plane("albedo.B")};
    const float* normal[] = {plane("N.X"), plane("N.Y"), plane("N.Z")};
    const float* variance[] = {plane("variance.R"), plane("variance.G"), plane("variance.B")};
    const float *z = plane("Z"), *samples = plane("samples");
    for (size_t x = 0; x < size_t(frame.width); ++x) {
      for (size_t c = 0; c < 3; ++c) {
        row.albedo[c][x] = albedo[c][x];
        row.normal[c][x] = normal[c][x];
      }
      row.nearness[x] = z[x] < 1e9f ? 1.0f / z[x] : 0.0f;
      row.samples[x] = samples[x];
      row.variance[x] = samples[x] < 2.0f
                            ? -1.0f
                            : luminance(Rgb(variance[0][x], variance[1][x], variance[2][x]));
    }
  };
}

void write_picture(const std::string& path, const RgbImage& picture) {
  std::array<std::vector<float>, 3> planes;
  for (size_t i = 0; i < picture.rgb.size(); ++i) planes[i % 3].push_back(picture.rgb[i]);
  const NamedPlane named[] = {{"R", planes[0]}, {"G", planes[1]}, {"B", planes[2]}};
  write_exr_planes(path, picture.width, picture.height, named);
}

int run(int argc, char** argv) {
  const ExrPlanes frame = read_exr_planes(argv[1]);
  const RgbImage truth_a = picture_of(read_exr_planes(argv[2]));
  const RgbImage truth_b = picture_of(read_exr_planes(argv[3]));
  std::string clean_file;
  int repetitions = 1, levels = -1, threads = 2;
  for (int i = 4; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    if (name == "--clean") clean_file = argv[i + 1];
    if (name == "--repetitions") repetitions = std::max(std::atoi(argv[i + 1]), 1);
    if (name == "--levels") levels = std::atoi(argv[i + 1]);
    if (name == "--threads") threads = std::atoi(argv[i + 1]);
  }
  if (levels < 0) levels = FastFilter::levels_for(frame.planes.at("samples").front());
  const RgbImage raw = picture_of(frame);
  const size_t pixels = raw.rgb.size() / 3;
  std::vector<float> rgba(4 * pixels, 1.0f), filtered(4 * pixels);
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&raw.rgb[3 * i], 3, &rgba[4 * i]);
  FastFilter filter;
  std::vector<double> milliseconds, processor_ms;
  tbb::task_arena arena(threads);
  for (int i = 0; i < repetitions; ++i) {
    const std::clock_t clock = std::clock();
    const auto start = std::chrono::steady_clock::now();
    arena.execute(
        [&] { filter.filter(frame.width, frame.height, rgba, reader(frame), levels, filtered); });
    processor_ms.push_back(1e3 * double(std::clock() - clock) / CLOCKS_PER_SEC);
    milliseconds.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
            .count());
  }
  std::sort(milliseconds.begin(), milliseconds.end());
  std::sort(processor_ms.begin(), processor_ms.end());
  RgbImage clean = raw;
  for (size_t i = 0; i < pixels; ++i) std::copy_n(&filtered[4 * i], 3, &clean.rgb[3 * i]);
  if (!clean_file.empty()) write_picture(clean_file, clean);
  const ReferencePicture reference(truth_a, truth_b);
  const StudyError before = reference.measure(raw), after = reference.measure(clean);
  const auto words = [](const StudyError& e) {
    return fmt::format(R"({{"relmse": {:.4g}, "trimmed": {:.4g}, "display_mse": {:.4g}, )"
                       R"("flip": {:.4f}, "bias": {:.4f}}})",
                       e.rel_mse, e.rel_mse_trimmed, e.display_mse, e.flip, e.signed_bias);
  };
  fmt::print(R"({{"raw": {}, "clean": {}, "gain": {:.2f}, "trimmed": {:.2f}, "display": {:.2f}, )"
             R"("ms": {:.2f}, "processor_ms": {:.2f}}})"
             "\n",
             words(before), words(after), before.rel_mse / after.rel_mse,
             before.rel_mse_trimmed / after.rel_mse_trimmed, before.display_mse / after.display_mse,
             milliseconds[milliseconds.size() / 2], processor_ms[processor_ms.size() / 2]);
  return 0;
}

}  // namespace
}  // namespace emberline::bench

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr,
               "fast_filter_bench FRAME.exr REFERENCE_A.exr REFERENCE_B.exr [--levels N] "
               "[--threads N] [--repetitions N] [--clean FILE]\n");
    return 2;
  }
  try {
    return emberline::bench::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "fast_filter_bench: {}\n", error.what());
    return 3;
  }
}
