// Reads and writes EXR files for the benchmarks of filters, with a plane of floats for each
// channel.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/statistics/error_metrics.h"

namespace emberline::bench {

struct ExrPlanes {
  int width = 0, height = 0;
  std::map<std::string, std::vector<float>> planes;
};

ExrPlanes read_exr_planes(const std::string& path);
RgbImage picture_of(const ExrPlanes& frame);  // R G B
using NamedPlane = std::pair<const char*, std::span<const float>>;
void write_exr_planes(const std::string& path, int width, int height,
                      std::span<const NamedPlane> planes);

}  // namespace emberline::bench
