#include "renderer/scene/light_survey.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "renderer/core/frame.h"
#include "renderer/core/hash.h"
#include "renderer/core/moments.h"
#include "renderer/core/parallel.h"
#include "renderer/core/warps.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/light_guide.h"
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace emberline {
namespace {

// We chose the following constants; tests/bench/results has results for other values.
//
// The number of camera paths (log2) and the number of surfaces per path. The "pilot" decides
// whether a guide is worthwhile; the "survey" builds a guide. A guide takes no more paths than the
// frame has pixels, but always at least as many as the pilot.
constexpr int kPilotBits = 9, kPilotSurfaces = 2;
constexpr int kSurveyBits = 14, kSurveySurfaces = 4;
// An environment guide is worthwhile if the relative variance of samples at one surface point is at
// least kMinRelativeVariance, and the environment contributes at least kMinEnvironmentFraction of
// the light.
constexpr double kMinRelativeVariance = 3, kMinEnvironmentFraction = 0.3;
constexpr int kPilotSamples = 8;
// For KindFactors, we try powers of two from 2^-kMaxDoublings to 2^kMaxDoublings, with kKindSamples
// light samples per surface point. These paths have more surfaces than the pilot's, because a
// sunlit patch may light a room that does not see the sun. Each doubling or halving must reduce the
// noise by the fraction kDoublingPenalty. If even the best factors leave kMaxNoiseRatio of the
// noise or more, no factors are used.
constexpr int kKindSurfaces = 4, kKindSamples = 16, kMaxDoublings = 8;
// Number of cells of the frame over which samples are pooled. The low bits of a path's index give
// its cell.
constexpr uint32_t kCells = 32;
constexpr float kMinKindFraction = 0.05f;
constexpr double kDoublingPenalty = 0.01, kMaxNoiseRatio = 0.95;
// Shadow rays stop at this fraction of the distance, so that they do not hit the lamp itself.
constexpr float kShadowRayFraction = 0.999f;
constexpr size_t kMinPlaces = 64;
// Fraction of the surface points that is cut off at each end of each axis. These outliers get no
// region.
constexpr double kTrimFraction = 0.01;
// Number of rays from a region into each tile of the environment (sky_regions.h). There are
// kBaseRays, plus a number proportional to the tile's fraction of the light (at most
// kMaxLightRays), plus kExtraRays if the tile or a neighbour was visible. In a tile's visibility,
// the mean of its neighbours counts as kNeighbourRays rays.
constexpr int kBaseRays = 2, kRaysOfAllLight = 256, kMaxLightRays = 32, kExtraRays = 8;
constexpr float kNeighbourRays = 4;
// Maximum number of smooth thin walls, such as window panes, that a ray passes through.
constexpr int kMaxPanes = 8;

// A sequence of random numbers that depends only on the seed.
class Rng {
 public:
  explicit Rng(uint32_t seed) : state_(hash32(seed + 0x5eed5eedu)) {}
  uint32_t bits() { return state_ = hash_combine(state_, 1); }
  float next() { return to_unit_float(bits()); }
  Vec2f pair() {
    const float x = next();
    return {x, next()};
  }

 private:
  uint32_t state_;
};

// A surface point reached by a path; its normals are on the side that the path came from.
struct SurfacePoint {
  Vec3f position;
  Vec3f geometric_normal, shading_normal;
  float offset = 0.0f;
  float time = 0.0f;
  uint32_t path = 0;
};

LightQuery query_of(const SurfacePoint& place) {
  return {place.position, place.shading_normal, false, place.time};
}

// Moments of the light samples at a surface point: the mean and, for each kind of light, the mean
// square that would result if all samples were of this kind.
struct KindSecondMoments {
  std::array<double, kLightKinds> squares{};
  double mean = 0;
};

class LightSurvey {
 public:
  LightSurvey(const Scene& scene, const Camera& camera, int width, int height,
              const std::stop_token& stop)
      : scene_(scene), camera_(camera), width_(width), height_(height), stop_(stop) {}

  std::vector<SurfacePoint> trace_paths(int bits, int surfaces) const;
  bool is_guide_useful(std::span<const SurfacePoint> places) const;
  std::shared_ptr<const EnvironmentGuide> environment_guide() const;
  KindFactors factors(std::span<const SurfacePoint> places, const LightGuide& guide) const;

 private:
  Ray camera_ray(uint32_t path, int bits, Rng& rng) const;
  enum class HitKind { kMiss, kSurface, kTooManyPanes };
  HitKind next_surface(const Ray& ray, CoverageKey key, SurfacePoint* out) const;
  float transmittance(const SurfacePoint& place, const Vec3f& direction, float distance,
                      Rng& rng) const;
  LightSample light_sample(const SurfacePoint& place, const LightGuide* guide, Rng& rng) const;
  double incident_light(const SurfacePoint& place, const LightSample& s, double density,
                        Rng& rng) const;
  double lamp_light(const SurfacePoint& place, Rng& rng) const;
  double environment_light(const SurfacePoint& place, Rng& rng) const;
  KindSecondMoments kind_squares(const SurfacePoint& place, const LightGuide& guide, Rng rng) const;
  double noise(std::span<const SurfacePoint> places, std::span<const KindSecondMoments> squares,
               const KindFactors& factors) const;
  std::optional<SkyRegions> regions(const EnvironmentGuide& guide) const;
  void measure_visibility(const EnvironmentGuide& guide,
                          std::span<const SurfacePoint* const> places, Rng rng,
                          std::span<float> visibility) const;

  const Scene& scene_;
  const Camera& camera_;
  int width_, height_;
  const std::stop_token& stop_;  // after a stop request the result is not used
};

// For any n, the first n paths are spread evenly over the frame.
Ray LightSurvey::camera_ray(uint32_t path, int bits, Rng& rng) const {
  uint32_t x = 0, y = 0;
  for (int bit = 0; bit < bits; ++bit) {
    uint32_t& axis = bit % 2 == 0 ? x : y;
    axis = axis << 1 | (path >> bit & 1u);
  }
  const float columns = float(1u << (bits + 1) / 2), rows = float(1u << bits / 2);
  const Vec2f in_cell = rng.pair();
  const Vec2f film((float(x) + in_cell.x) / columns * float(width_),
                   (float(y) + in_cell.y) / rows * float(height_));
  const bool moves = scene_.moves() || camera_.moves();
  const float time = moves ? rng.next() : 0.0f;
  return camera_.ray(film, rng.pair(), time);
}

// Follows the ray to the next surface. The ray passes straight through a limited number of smooth
// walls.
LightSurvey::HitKind LightSurvey::next_surface(const Ray& from, CoverageKey key,
                                               SurfacePoint* out) const {
  Ray ray = from;
  for (int walls = 0; walls < kMaxPanes; ++walls) {
    SurfaceHit hit;
    if (!scene_.intersect(ray, key, &hit)) return HitKind::kMiss;
    SurfaceInteraction surface;
    scene_.interaction(hit, ray.time, &surface);
    const bool front = dot(ray.direction, surface.geometric_normal) < 0.0f;
    const float side = front ? 1.0f : -1.0f;
    if (!scene_.material_of(hit.instance).is_smooth_wall()) {
      *out = {surface.position, surface.geometric_normal * side, surface.shading_normal * side,
              surface.offset, ray.time};
      return HitKind::kSurface;
    }
    ray.origin = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                                   ray.direction);
    ray.t_max -= hit.t;
  }
  return HitKind::kTooManyPanes;
}

// Traces paths with diffuse scattering.
std::vector<SurfacePoint> LightSurvey::trace_paths(int bits, int surfaces) const {
  const size_t paths = size_t(1) << bits;
  std::vector<std::vector<SurfacePoint>> found(paths);
  parallel_each(paths, 64, [&](size_t path) {
    if (stop_.stop_requested()) return;
    Rng rng{uint32_t(path)};
    Ray ray = camera_ray(uint32_t(path), bits, rng);
    for (int i = 0; i < surfaces; ++i) {
      SurfacePoint place;
      if (next_surface(ray, {rng.bits(), 0}, &place) != HitKind::kSurface) break;
      place.path = uint32_t(path);
      found[path].push_back(place);
      const ShadingFrame frame = ShadingFrame::from_normal(place.geometric_normal);
      ray.direction = frame.to_world(square_to_cosine_hemisphere(rng.pair()));
      ray.origin =
          offset_ray_origin(place.position, place.geometric_normal, place.offset, ray.direction);
    }
  });
  std::vector<SurfacePoint> places;
  for (const std::vector<SurfacePoint>& path : found) {
    places.insert(places.end(), path.begin(), path.end());
  }
  return places;
}

// Returns the transmittance over `distance` along a direction.
float LightSurvey::transmittance(const SurfacePoint& place, const Vec3f& direction, float distance,
                                 Rng& rng) const {
  const CoverageKey key{rng.bits(), 0};
  const Vec3f origin =
      offset_ray_origin(place.position, place.geometric_normal, place.offset, direction);
  if (distance == kInfinity && !scene_.has_smooth_walls()) {
    return scene_.transmittance_to_infinity(origin, direction, place.time, key);
  }
  SurfacePoint blocker;
  const Ray ray{origin, direction, distance, place.time};
  return next_surface(ray, key, &blocker) == HitKind::kMiss ? 1.0f : 0.0f;
}

LightSample LightSurvey::light_sample(const SurfacePoint& place, const LightGuide* guide,
                                      Rng& rng) const {
  const float u_pick = rng.next();
  const LightRequest request{query_of(place), u_pick, rng.pair()};
  LightSample sample;
  LightSample* const out = &sample;
  scene_.lights().sample({&request, 1}, &out, guide);
  return sample;
}

// Returns the arriving light divided by `density`, which is the pdf of light sampling, or the sum
// of the pdfs of light and BSDF sampling.
double LightSurvey::incident_light(const SurfacePoint& place, const LightSample& s, double density,
                                   Rng& rng) const {
  const float cosine = dot(s.direction, place.geometric_normal);
  if (s.kind == LightKind::kNone || !(s.pdf > 0.0f) || !(cosine > 0.0f)) return 0;
  const Rgb radiance = s.kind == LightKind::kTriangle
                           ? scene_.lights().triangles()[s.index].mean_radiance
                           : s.radiance;
  return double(transmittance(place, s.direction, s.distance * kShadowRayFraction, rng) * cosine) *
         double(luminance(radiance)) / density;
}

// Estimates the light of the lamps, that is, of all lights except the environment, from one light
// sample. Returns 0 if the sample chose the environment.
double LightSurvey::lamp_light(const SurfacePoint& place, Rng& rng) const {
  const LightSample s = light_sample(place, nullptr, rng);
  if (s.kind == LightKind::kEnvironment) return 0;
  return incident_light(place, s, double(s.pdf), rng);
}

// Estimates the environment's light from one light sample and one cosine-distributed sample,
// combined by the balance heuristic.
double LightSurvey::environment_light(const SurfacePoint& place, Rng& rng) const {
  const EnvironmentLight& environment = *scene_.lights().environment();
  const auto light = [&](const Vec3f& direction, const Rgb& radiance, float pdf) {
    const float cosine = dot(direction, place.geometric_normal);
    if (!(cosine > 0.0f)) return 0.0;
    return double(transmittance(place, direction, kInfinity, rng) * cosine) *
           double(luminance(radiance)) / (double(pdf) + double(cosine / kPi));
  };
  const EnvironmentSample s = environment.sample(rng.pair());
  double sum = s.pdf > 0.0f ? light(s.direction, s.radiance, s.pdf) : 0;
  const Vec3f direction = ShadingFrame::from_normal(place.geometric_normal)
                              .to_world(square_to_cosine_hemisphere(rng.pair()));
  float pdf;
  const Rgb radiance = environment.radiance_and_pdf(direction, &pdf);
  sum += light(direction, radiance, pdf);
  return sum;
}

// Returns whether the environment contributes enough of the light, and only a few samples at a
// surface point receive light from it. With a sun, either all samples at a point receive its light
// or none do, so guiding is useless.
bool LightSurvey::is_guide_useful(std::span<const SurfacePoint> places) const {
  std::vector<double> lamps(places.size());
  std::vector<Moments> environment(places.size());
  parallel_each(places.size(), 32, [&](size_t i) {
    Rng rng{~uint32_t(i)};
    lamps[i] = lamp_light(places[i], rng);
    for (int k = 0; k < kPilotSamples; ++k) {
      environment[i].add(environment_light(places[i], rng));
    }
  });
  double lamp_light_sum = 0, environment_light_sum = 0, variance = 0, squares = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    lamp_light_sum += lamps[i];
    environment_light_sum += environment[i].mean();
    variance += environment[i].variance();
    squares += square(environment[i].mean()) - environment[i].variance() / kPilotSamples;
  }
  return environment_light_sum > 0 &&
         environment_light_sum >=
             kMinEnvironmentFraction * (environment_light_sum + lamp_light_sum) &&
         variance >= kMinRelativeVariance * squares;
}

// The light samples are weighted against cosine-distributed BSDF samples by the balance heuristic.
KindSecondMoments LightSurvey::kind_squares(const SurfacePoint& place, const LightGuide& guide,
                                            Rng rng) const {
  KindSecondMoments result;
  const std::array<float, kLightKinds> probabilities =
      scene_.lights().kind_probabilities(query_of(place), &guide);
  for (int i = 0; i < kKindSamples; ++i) {
    const LightSample s = light_sample(place, &guide, rng);
    const float cosine = std::max(0.0f, dot(s.direction, place.geometric_normal));
    const double density = double(s.pdf) + double(s.delta ? 0.0f : cosine / kPi);
    const double light = incident_light(place, s, density, rng);
    const int kind = s.kind == LightKind::kEnvironment    ? kEnvironmentKind
                     : s.delta && s.distance == kInfinity ? kDirectionalKind
                                                          : kFiniteKind;
    result.mean += light / kKindSamples;
    result.squares[size_t(kind)] +=
        square(light) * double(probabilities[size_t(kind)]) / kKindSamples;
  }
  return result;
}

// Returns the sum of the cells' relative standard deviations. They are relative to the cell's light
// plus the frame's mean light, because a cell may be dark.
double LightSurvey::noise(std::span<const SurfacePoint> places,
                          std::span<const KindSecondMoments> squares,
                          const KindFactors& factors) const {
  const LightGuide guide{.factors = factors};
  struct Cell {
    double variance = 0, light = 0;
  };
  std::array<Cell, kCells> cells;
  double mean = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    const std::array<float, kLightKinds> probabilities =
        scene_.lights().kind_probabilities(query_of(places[i]), &guide);
    Cell& cell = cells[places[i].path % kCells];
    for (size_t k = 0; k < kLightKinds; ++k) {
      if (squares[i].squares[k] > 0)
        cell.variance += squares[i].squares[k] / double(probabilities[k]);
    }
    cell.light += squares[i].mean;
    mean += squares[i].mean / kCells;
  }
  double sum = 0;
  for (const Cell& cell : cells) {
    if (cell.variance > 0) sum += std::sqrt(cell.variance) / (cell.light + mean);
  }
  return sum;
}

// Returns the factors with the least noise.
KindFactors LightSurvey::factors(std::span<const SurfacePoint> places,
                                 const LightGuide& guide) const {
  std::vector<KindSecondMoments> squares(places.size());
  parallel_each(places.size(), 32,
                [&](size_t i) { squares[i] = kind_squares(places[i], guide, Rng{~uint32_t(i)}); });
  KindFactors best{.min_share = kMinKindFraction, .min_directional = kMinKindFraction};
  double min_noise = noise(places, squares, best);
  int other_doublings = 0;  // doublings or halvings of the factor that was chosen first
  for (float KindFactors::*const factor : {&KindFactors::environment, &KindFactors::directional}) {
    KindFactors other = best;
    int best_doublings = 0;
    for (int doublings = -kMaxDoublings; doublings <= kMaxDoublings; ++doublings) {
      other.*factor = std::ldexp(1.0f, doublings);
      const double found = noise(places, squares, other) *
                           (1 + kDoublingPenalty * (other_doublings + std::abs(doublings)));
      if (!(found < min_noise)) continue;
      min_noise = found;
      best_doublings = std::abs(doublings);
      best = other;
    }
    other_doublings += best_doublings;
  }
  return min_noise < kMaxNoiseRatio * noise(places, squares, {}) ? best : KindFactors{};
}

// Sets each tile's `visibility` to the root mean square of cosine times transmittance over
// `places`. This is the tile's optimal sampling weight per unit of its light.
void LightSurvey::measure_visibility(const EnvironmentGuide& guide,
                                     std::span<const SurfacePoint* const> places, Rng rng,
                                     std::span<float> visibility) const {
  using sky_tiles::kColumns, sky_tiles::kRows, sky_tiles::kCount;
  struct TileSamples {
    float squares = 0.0f;
    int count = 0;
    float mean() const { return count > 0 ? squares / float(count) : 0.0f; }
  };
  std::array<TileSamples, kCount> tile_samples;
  const auto trace_tile = [&](int tile, int rays) {
    TileSamples& result = tile_samples[size_t(tile)];
    for (int i = 0; i < rays; ++i, ++result.count) {
      const SurfacePoint& place = *places[size_t(rng.next() * float(places.size()))];
      const float u_part = rng.next();
      const Vec3f direction = guide.direction_in(tile, u_part, rng.pair());
      const float cosine = dot(direction, place.geometric_normal);
      if (!(cosine > 0.0f)) continue;
      result.squares += square(cosine * transmittance(place, direction, kInfinity, rng));
    }
  };
  // Tiles with a lot of light get more rays: a sun in the map may be visible from only a small part
  // of the region.
  std::vector<int> lit_tiles;
  for (int tile = 0; tile < kCount; ++tile) {
    const double share = guide.light_fraction(tile);
    if (!(share > 0)) continue;
    lit_tiles.push_back(tile);
    trace_tile(tile, kBaseRays + std::min(kMaxLightRays, int(share * kRaysOfAllLight)));
  }
  const auto neighbour_mean = [&](int tile) {
    const int row = tile / kColumns, column = tile % kColumns;
    const auto mean = [&](int r, int c) {
      return r < 0 || r == kRows
                 ? 0.0f
                 : tile_samples[size_t(r * kColumns + (c + kColumns) % kColumns)].mean();
    };
    return (mean(row - 1, column) + mean(row + 1, column) + mean(row, column - 1) +
            mean(row, column + 1)) /
           4;
  };
  std::vector<int> visible_tiles;
  for (const int tile : lit_tiles) {
    if (tile_samples[size_t(tile)].squares + neighbour_mean(tile) > 0.0f)
      visible_tiles.push_back(tile);
  }
  for (const int tile : visible_tiles) trace_tile(tile, kExtraRays);
  for (const int tile : visible_tiles) {
    const TileSamples& own = tile_samples[size_t(tile)];
    visibility[size_t(tile)] = std::sqrt((own.squares + kNeighbourRays * neighbour_mean(tile)) /
                                         (float(own.count) + kNeighbourRays));
  }
}

std::optional<SkyRegions> LightSurvey::regions(const EnvironmentGuide& guide) const {
  const auto pixels = uint64_t(width_) * uint64_t(height_);
  const int bits = std::clamp(int(std::bit_width(pixels)) - 1, kPilotBits, kSurveyBits);
  const std::vector<SurfacePoint> places = trace_paths(bits, kSurveySurfaces);
  if (places.size() < kMinPlaces) return std::nullopt;
  Vec3f lower, upper;
  std::vector<float> coordinates(places.size());
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(places, coordinates.begin(),
                           [c](const SurfacePoint& place) { return place.position[c]; });
    const auto trim_count = std::ptrdiff_t(double(places.size()) * kTrimFraction);
    std::ranges::nth_element(coordinates, coordinates.begin() + trim_count);
    lower[c] = coordinates[size_t(trim_count)];
    std::ranges::nth_element(coordinates, coordinates.end() - 1 - trim_count);
    upper[c] = *(coordinates.end() - 1 - trim_count);
  }
  const Vec3f size = upper - lower;
  const Vec3f margin(std::max({size.x, size.y, size.z}) / (2.0f * SkyRegions::kCells));
  SkyRegions regions(lower - margin, upper + margin);
  std::vector<std::vector<const SurfacePoint*>> of_region;
  for (const SurfacePoint& place : places) {
    const int region = regions.find_or_add(place.position, place.shading_normal);
    if (region == SkyRegions::kNone) continue;
    if (size_t(region) == of_region.size()) of_region.emplace_back();
    of_region[size_t(region)].push_back(&place);
    regions.places(region)++;
  }
  parallel_each(of_region.size(), 4, [&](size_t i) {
    if (stop_.stop_requested()) return;
    measure_visibility(guide, of_region[i], Rng{uint32_t(i)}, regions.visibility(int(i)));
  });
  return regions;
}

std::shared_ptr<const EnvironmentGuide> LightSurvey::environment_guide() const {
  auto guide = std::make_shared<EnvironmentGuide>(*scene_.lights().environment());
  std::optional<SkyRegions> found = regions(*guide);
  if (!found) return nullptr;
  guide->set_regions(std::move(*found));
  return guide;
}

}  // namespace

std::shared_ptr<const LightGuide> find_light_guide(const Scene& scene, const Camera& camera,
                                                   int width, int height,
                                                   const std::stop_token& stop) {
  const LightSampler& lights = scene.lights();
  if (!lights.environment() && lights.kinds() < 2) return nullptr;
  const LightSurvey survey(scene, camera, width, height, stop);
  const std::vector<SurfacePoint> places = survey.trace_paths(kPilotBits, kPilotSurfaces);
  if (places.size() < kMinPlaces) return nullptr;
  LightGuide guide;
  if (lights.environment() && survey.is_guide_useful(places))
    guide.environment = survey.environment_guide();
  if (lights.kinds() > 1)
    guide.factors = survey.factors(survey.trace_paths(kPilotBits, kKindSurfaces), guide);
  if (stop.stop_requested()) return nullptr;
  if (!guide.environment && guide.factors == KindFactors{}) return nullptr;
  return std::make_shared<LightGuide>(std::move(guide));
}

}  // namespace emberline
