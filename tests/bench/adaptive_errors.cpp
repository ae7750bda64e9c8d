#include "bench/adaptive_errors.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include "renderer/core/errors.h"
#include "renderer/core/moments.h"
#include "renderer/drivers/adaptive/error_estimator.h"
#include "renderer/statistics/neyman_limit.h"

namespace emberline::bench {
namespace {

// Reads planes from a file. Returns false if the file does not exist.
bool read_planes(const std::string& path,
                 std::initializer_list<std::pair<Floats*, size_t>> planes) {
  std::ifstream in(path, std::ios::binary);
  if (path.empty() || !in) return false;
  for (const auto& [plane, size] : planes) {
    plane->resize(size);
    in.read(reinterpret_cast<char*>(plane->data()), std::streamsize(size * sizeof(float)));
  }
  if (!in || in.peek() != EOF)
    throw RenderError(path + ": written for another frame; remove the file");
  return true;
}

void write_planes(const std::string& path, std::initializer_list<const Floats*> planes) {
  if (path.empty()) return;
  std::ofstream out(path, std::ios::binary);
  for (const Floats* plane : planes) {
    out.write(reinterpret_cast<const char*>(plane->data()),
              std::streamsize(plane->size() * sizeof(float)));
  }
}

void render_reference(const BenchFrame& frame, uint32_t spp, int threads, Reference* r) {
  const size_t n = frame.pixels();
  FrameSampling s;
  s.spp = spp;
  s.aovs = AovSet::parse("variance,time");
  r->variance.assign(3 * n, 0.0f);
  r->cost.assign(n, 1e30f);
  for (const uint32_t half : {0u, 1u}) {
    s.seed = 0x5eed0u + half;
    ImageSink image(frame, s.aovs);
    frame.run(threads, s, image);
    (half == 0 ? r->a : r->b) = image.rgb();
    const Floats seconds = image.plane(8);
    for (size_t i = 0; i < n; ++i) {
      for (size_t c = 0; c < 3; ++c) {
        r->variance[3 * i + c] += 0.5f * float(spp) * image.values[9 * i + 5 + c];
      }
      // Takes the run that was less disturbed.
      r->cost[i] = std::min(r->cost[i], seconds[i] / float(spp));
    }
  }
}

// Returns the mean over channels of weight x value, for each pixel.
std::vector<double> weigh(const Floats& values, const Reference& r, Error error) {
  std::vector<double> pixels(values.size() / 3);
  for (size_t k = 0; k < values.size(); ++k) {
    pixels[k / 3] += std::max(0.0, double(values[k])) * r.weight(error, k) / 3;
  }
  return pixels;
}

std::vector<double> weigh(const UniformErrors& uniform, const Reference& r, Error error) {
  if (error != kDisplay) return weigh(uniform.linear, r, error);
  return weigh(uniform.display, r, kMse);
}

Floats variances(const std::vector<Moments>& spread) {
  Floats out(spread.size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = float(spread[i].variance());
  return out;
}

}  // namespace

double Reference::weight(Error error, size_t i) const {
  if (error == kRelMse) return 1 / (mean(i) * mean(i) + epsilon);
  if (error == kDisplay) {
    return double(display_error_weight(float(mean(i)), 1e-3f));
  }
  return 1;
}

Reference make_reference(const BenchFrame& frame, uint32_t spp, int threads,
                         const std::string& cache) {
  Reference r;
  const size_t n = frame.pixels();
  if (!read_planes(cache, {{&r.a, 3 * n}, {&r.b, 3 * n}, {&r.variance, 3 * n}, {&r.cost, n}})) {
    render_reference(frame, spp, threads, &r);
    write_planes(cache, {&r.a, &r.b, &r.variance, &r.cost});
  }
  double sum = 0;
  for (size_t i = 0; i < 3 * n; ++i) sum += 2 * r.mean(i);
  r.epsilon = 0.01 * std::pow(sum / (6 * double(n)), 2);
  return r;
}

int uniform_frames(uint32_t spp) { return int(std::clamp(1024u / spp, 6u, 16u)); }

UniformErrors measure_uniform(const BenchFrame& frame, uint32_t spp, int threads,
                              const std::string& cache) {
  UniformErrors out;
  const size_t n = 3 * frame.pixels();
  const std::string file = cache.empty() ? cache : cache + "." + std::to_string(spp);
  if (read_planes(file, {{&out.linear, n}, {&out.display, n}})) return out;
  std::vector<Moments> linear(n), display(n);
  for (int i = 0; i < uniform_frames(spp); ++i) {
    FrameSampling s;
    s.spp = spp;
    s.seed = 0xf4a3e1u + uint32_t(i);
    ImageSink image(frame, s.aovs);
    frame.run(threads, s, image);
    const Floats rgb = image.rgb();
    for (size_t k = 0; k < n; ++k) {
      linear[k].add(double(rgb[k]));
      display[k].add(double(display_value(rgb[k])));
    }
  }
  out = {variances(linear), variances(display)};
  write_planes(file, {&out.linear, &out.display});
  return out;
}

double mean_error(const UniformErrors& uniform, const Reference& reference, Error error) {
  double sum = 0;
  const std::vector<double> pixels = weigh(uniform, reference, error);
  for (const double v : pixels) sum += v;
  return sum / double(pixels.size());
}

double independent_limit(const Reference& reference, Error error) {
  const std::vector<double> cost(reference.cost.begin(), reference.cost.end());
  return neyman_limit(weigh(reference.variance, reference, error), cost);
}

double stratified_limit(const UniformErrors& uniform, uint32_t spp, const Reference& reference,
                        Error error, double slope) {
  const std::vector<double> cost(reference.cost.begin(), reference.cost.end());
  const double limit = neyman_limit(weigh(uniform, reference, error), cost, slope);
  // The expectation of v^p, for a variance v with k degrees of freedom, is the true variance to the
  // power p, times `root`. The limit raises the mean of the p-th powers to -(1 + slope) / slope =
  // -1 / (slope p).
  const double half = 0.5 * (uniform_frames(spp) - 1), p = 1 / (1 + slope);
  const double root = std::exp(std::lgamma(half + p) - std::lgamma(half)) / std::pow(half, p);
  return limit * std::pow(root, 1 / (slope * p));
}

}  // namespace emberline::bench
