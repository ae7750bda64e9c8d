#include "renderer/scene/indirect_guide.h"

#include <Imath/ImathBox.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "renderer/core/flush_denormals.h"
#include "renderer/core/parallel.h"
#include "renderer/core/ray.h"

namespace emberline {
namespace {

// We chose the following constants; tests/bench/results has results for other values.
//
// With N vertices, a cell usually has at least kMinVertices sqrt(N) of them, and at least half as
// many unless it is the only one of its orientation. So both the number of cells and the number of
// vertices in each grow with N, as in Müller et al. 2017.
constexpr double kMinVertices = 1.25;
constexpr int kIterations = 8;  // of the radiosity system
// The mean of a bin is mixed with that of the bin's parent (a block of four bins), which counts as
// this many rays.
constexpr double kParentRays = 2;
// Part of the samples that the guide chooses. The rest is as in the plain cosine lobe, so that
// light that the survey missed causes only noise.
constexpr double kGuidedFraction = 0.75;
constexpr int kSize = CosineGuide::kSize, kBins = CosineGuide::kBins;
constexpr int kLevels = 4;  // with 1, 2, 4 and 8 blocks of bins per side
static_assert(1 << kLevels == kSize);

using BinValues = std::array<double, kBins>;

// The rays of a cell, by bin. Rays are weighted by the BSDF over their density, since guided rays
// go to bright directions more often than others.
struct BinnedRays {
  BinValues counts{}, weights{}, sums{}, squares{};

  void add(int bin, double weight, double light) {
    const auto i = size_t(bin);
    counts[i] += 1;
    weights[i] += weight;
    sums[i] += weight * light;
    squares[i] += weight * square(light);
  }
};

// Returns the weighted mean of each bin. A bin with few rays is mostly like its neighbours.
BinValues smoothed_means(const BinnedRays& rays, const BinValues& sums) {
  // Level l has 4^l blocks; the last level has the bins.
  struct Level {
    BinValues counts, weights, sums;
  };
  std::array<Level, kLevels + 1> levels;
  levels[kLevels] = {rays.counts, rays.weights, sums};
  for (size_t l = kLevels; l-- > 0;) {
    const size_t size = size_t(1) << l;
    for (BinValues Level::*values : {&Level::counts, &Level::weights, &Level::sums}) {
      const BinValues& fine = levels[l + 1].*values;
      for (size_t i = 0; i < size * size; ++i) {
        const size_t first = i / size * 4 * size + i % size * 2;
        (levels[l].*values)[i] =
            fine[first] + fine[first + 1] + fine[first + 2 * size] + fine[first + 2 * size + 1];
      }
    }
  }
  const auto mean = [](const Level& level, size_t i, double none) {
    return level.weights[i] > 0 ? level.sums[i] / level.weights[i] : none;
  };
  BinValues means{}, finer;
  means[0] = mean(levels[0], 0, 0.0);
  for (size_t l = 1; l <= kLevels; ++l) {
    const size_t size = size_t(1) << l;
    for (size_t i = 0; i < size * size; ++i) {
      const double parent = means[i / size / 2 * (size / 2) + i % size / 2];
      const double count = levels[l].counts[i];
      finer[i] =
          (count * mean(levels[l], i, parent) + kParentRays * parent) / (count + kParentRays);
    }
    means = finer;
  }
  return means;
}

size_t min_vertices(uint64_t vertices) {
  return size_t(kMinVertices * std::sqrt(double(vertices)));
}

double mean_of(const BinValues& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / kBins;
}

}  // namespace

class IndirectGuideBuilder {
 public:
  IndirectGuideBuilder(IndirectGuide& guide, std::vector<SurveyVertex>& vertices)
      : guide_(guide),
        vertices_(vertices),
        min_vertices_(min_vertices(vertices.size())),
        cell_of_(vertices.size(), kNoCell) {}

  void build() {
    const FlushDenormals flush;  // as the render workers do
    find_cells();
    if (guide_.empty()) return;
    gather_direct_light();
    for (int i = 0; i < kIterations; ++i) {
      find_incoming_light();
      gather_indirect_light(i + 1 == kIterations);
    }
    guide_.indirect_fraction_ = indirect_fraction();
  }

 private:
  static constexpr uint32_t kNoCell = ~0u;

  std::span<const uint32_t> vertices_of(size_t cell) const {
    return std::span(order_).subspan(first_[cell], first_[cell + 1] - first_[cell]);
  }
  // Calls body(cell) for each cell.
  template <typename Body>
  void for_each_cell(const Body& body) const {
    parallel_each(guide_.cells_.size(), [&](size_t cell) {
      const FlushDenormals flush;
      body(cell);
    });
  }

  void find_cells() {
    order_.reserve(vertices_.size());
    for (size_t i = 0; i < vertices_.size(); ++i) {
      if (vertices_[i].albedo > 0.0f) order_.push_back(uint32_t(i));
    }
    const auto orientation = [&](uint32_t i) { return vertices_[i].orientation; };
    std::ranges::stable_sort(order_, {}, orientation);
    for (uint8_t k = 0; k < IndirectGuide::kOrientations; ++k) {
      const auto list = std::ranges::equal_range(order_, k, {}, orientation);
      guide_.roots_[k] = list.empty() ? IndirectGuide::kNothing : split(std::span(list));
    }
    guide_.cells_.resize(first_.size());
    first_.push_back(order_.size());
    for_each_cell([&](size_t cell) {
      for (const uint32_t i : vertices_of(cell)) cell_of_[i] = uint32_t(cell);
    });
  }

  // Divides the vertices into cells. Returns the index of a node, or the negative code of a cell.
  int32_t split(std::span<uint32_t> list) {
    Imath::Box3f bounds;
    for (const uint32_t i : list) bounds.extendBy(vertices_[i].position);
    std::array<int, 3> axes = {0, 1, 2};
    std::ranges::stable_sort(axes, std::ranges::greater(),
                             [&](int axis) { return bounds.size()[axis]; });
    for (const int axis : axes) {
      if (list.size() < 2 * min_vertices_ || !(bounds.size()[axis] > 0.0f)) break;
      const float at = median(list, axis);
      const auto upper = std::ranges::partition(
          list, [&](uint32_t i) { return vertices_[i].position[axis] < at; });
      const size_t below = list.size() - upper.size();
      if (std::min(below, upper.size()) <= min_vertices_ / 2) continue;
      const size_t node = guide_.nodes_.size();
      guide_.nodes_.push_back({at, axis, {}});
      const int32_t lower_child = split(list.first(below));
      const int32_t upper_child = split(list.subspan(below));
      guide_.nodes_[node].children = {lower_child, upper_child};
      return int32_t(node);
    }
    first_.push_back(size_t(list.data() - order_.data()));
    return IndirectGuide::kFirstCell - int32_t(first_.size() - 1);
  }

  // Returns the median of the vertices' coordinates. If that is the smallest one, as on a wall
  // across the axis, returns the next larger one.
  float median(std::span<uint32_t> list, int axis) const {
    const auto coordinate = [&](uint32_t i) { return vertices_[i].position[axis]; };
    const auto middle = list.begin() + std::ptrdiff_t(list.size() / 2);
    std::ranges::nth_element(list, middle, {}, coordinate);
    const float at = coordinate(*middle);
    if (at > coordinate(std::ranges::min(list, {}, coordinate))) return at;
    float next = kInfinity;
    for (const uint32_t i : list) {
      if (coordinate(i) > at) next = std::min(next, coordinate(i));
    }
    return next;
  }

  void gather_direct_light() {
    for_each_cell([&](size_t cell) {
      double sum = 0, count = 0;
      for (const uint32_t i : vertices_of(cell)) {
        if (!vertices_[i].samples_lights) continue;
        sum += double(std::min(vertices_[i].direct / vertices_[i].albedo, SurveyVertex::kMaxLight));
        ++count;
      }
      guide_.cells_[cell].direct = float(sum / std::max(count, 1.0));
    });
  }

  float light_at(uint32_t cell) const {
    return guide_.cells_[cell].direct + guide_.cells_[cell].indirect;
  }

  // Finds the light along each ray. A path is walked from its end, because light that is not
  // reflected diffusely comes from the path's next vertex.
  void find_incoming_light() {
    float leaving = -1.0f;  // from the vertex after this one towards it; -1 if unknown
    for (size_t i = vertices_.size(); i-- > 0;) {
      SurveyVertex& v = vertices_[i];
      if (v.next == SurveyVertex::Next::kSurface) v.incoming = leaving;
      if (const uint32_t cell = cell_of_[i]; cell != kNoCell) {
        leaving = v.emitted + v.albedo * light_at(cell);
      } else if (v.next == SurveyVertex::Next::kUnknown || v.incoming < 0.0f) {
        leaving = -1.0f;
      } else {
        leaving = v.emitted + v.direct + v.weight * v.incoming;
      }
      leaving = std::min(leaving, SurveyVertex::kMaxLight);
    }
  }

  // Measures each cell's indirect light. At the end, also makes the cell's guide, with densities
  // in proportion to the root mean square of the light (Rath et al. 2020, "Variance-Aware Path
  // Guiding").
  void gather_indirect_light(bool last) {
    for_each_cell([&](size_t cell) {
      BinnedRays rays;
      for (const uint32_t i : vertices_of(cell)) {
        const SurveyVertex& v = vertices_[i];
        if (!v.is_diffuse || v.incoming < 0.0f) continue;
        rays.add(v.bin, double(v.weight) / double(v.albedo), double(v.incoming));
      }
      guide_.cells_[cell].indirect = float(mean_of(smoothed_means(rays, rays.sums)));
      if (last) guide_.cells_[cell].directions = guide_to(smoothed_means(rays, rays.squares));
    });
  }

  static CosineGuide guide_to(BinValues squares) {
    for (double& value : squares) value = std::sqrt(value);
    const double mean = mean_of(squares);
    std::array<float, kBins> weights;
    for (size_t i = 0; i < kBins; ++i) {
      const double guided = mean > 0 ? squares[i] / mean : 1;
      weights[i] = float((1 - kGuidedFraction) + kGuidedFraction * guided);
    }
    return CosineGuide(weights);
  }

  double indirect_fraction() const {
    double indirect = 0, total = 0;
    for (size_t i = 0; i + 1 < vertices_.size(); ++i) {
      const SurveyVertex& v = vertices_[i];
      if (!v.is_first) continue;
      total += double(v.albedo * light_at(cell_of_[i]));
      if (v.next == SurveyVertex::Next::kSurface && v.incoming >= 0.0f) {
        indirect += double(v.weight * (v.incoming - vertices_[i + 1].emitted));
      }
    }
    return total > 0 ? indirect / total : 0;
  }

  IndirectGuide& guide_;
  std::vector<SurveyVertex>& vertices_;
  const size_t min_vertices_;
  std::vector<uint32_t> order_;  // indices of the vertices that have a cell, by cell
  std::vector<size_t> first_;    // for each cell, its first place in order_; then the end
  std::vector<uint32_t> cell_of_;
};

IndirectGuide::IndirectGuide(std::vector<SurveyVertex>& vertices) {
  IndirectGuideBuilder(*this, vertices).build();
}

uint64_t IndirectGuide::bytes(uint64_t vertices) {
  // Each cell has more than half of min_vertices, and a tree has fewer nodes than cells. The third
  // list is for sorting.
  const uint64_t cells = vertices / (min_vertices(vertices) / 2 + 1) + kOrientations;
  const uint64_t lists = 3 * sizeof(uint32_t) * vertices + 2 * sizeof(size_t) * cells;
  return cells * (sizeof(GuideCell) + 2 * sizeof(Node)) + lists;
}

std::string IndirectGuide::describe() const {
  return fmt::format("paths guided in {} cells", cells_.size());
}

}  // namespace emberline
