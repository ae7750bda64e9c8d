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

// Constants chosen by us; tests/bench/results has results for other values.
// Camera paths (a power of two) and surfaces used per path, to decide whether a guide pays and to
// build one. The guide uses at most as many paths as the frame has pixels.
constexpr int kPilotBits = 9, kPilotSurfaces = 2;
constexpr int kSurveyBits = 14, kSurveySurfaces = 4;
// A guide pays if the relative variance of samples at one place is at least kLeastVariance, and the
// environment contributes at least kLeastShare of the light.
constexpr double kLeastVariance = 3, kLeastShare = 0.3;
constexpr int kPilotSamples = 8;
// Kinds of light: factors of up to 2^kMostDoublings are tried with kKindSamples light samples per
// place. They use more surfaces per path, because a sunlit patch may light a room that does not see
// the sun. A factor must reduce the noise by kReluctance per doubling; all are rejected unless they
// reduce it to kKindGain in total.
constexpr int kKindSurfaces = 4, kKindSamples = 16, kMostDoublings = 8;
// Number of cells of the frame over which samples are pooled. A path's low bits give its cell.
constexpr uint32_t kCells = 32;
constexpr float kLeastKindShare = 0.05f;
constexpr double kReluctance = 0.01, kKindGain = 0.95;
// Shadow rays stop at this fraction of the distance, so that they do not hit the lamp itself.
constexpr float kNearlyThere = 0.999f;
constexpr size_t kLeastPlaces = 64;
// Fraction of places trimmed at each end of each axis; outliers get no region.
constexpr double kTrimmed = 0.01;
// Rays from a region into each tile: a base, up to kMostOfLight more by the tile's share of the
// light, and kMoreLooks more if the tile or a neighbour was seen. The neighbours' mean counts as
// kLooksAround rays.
constexpr int kLooks = 2, kLooksOfLight = 256, kMostOfLight = 32, kMoreLooks = 8;
constexpr float kLooksAround = 4;
// Maximum number of smooth thin walls, such as window panes, that a ray passes through.
constexpr int kWallsLookedThrough = 8;

// A sequence of random numbers from a seed.
class Numbers {
 public:
  explicit Numbers(uint32_t seed) : state_(hash32(seed + 0x5eed5eedu)) {}
  uint32_t bits() { return state_ = hash_combine(state_, 1); }
  float next() { return to_unit_float(bits()); }
  Vec2f pair() {
    const float x = next();
    return {x, next()};
  }

 private:
  uint32_t state_;
};

// A surface point reached by a path, on the side it came from.
struct Place {
  Vec3f position;
  Vec3f geometric_normal, shading_normal;
  float offset = 0.0f;
  float time = 0.0f;
  uint32_t path = 0;
};

LightQuery query_of(const Place& place) {
  return {place.position, place.shading_normal, false, place.time};
}

// Light samples of a place: per kind of light, the mean square if all samples were of this kind.
struct KindSquares {
  std::array<double, kLightKinds> squares{};
  double mean = 0;
};

class LightSurvey {
 public:
  LightSurvey(const Scene& scene, const Camera& camera, int width, int height,
              const std::stop_token& stop)
      : scene_(scene), camera_(camera), width_(width), height_(height), stop_(stop) {}

  std::vector<Place> walk(int bits, int surfaces) const;
  bool guiding_pays(std::span<const Place> places) const;
  std::shared_ptr<const EnvironmentGuide> environment_guide() const;
  KindFactors factors(std::span<const Place> places, const LightGuide& guide) const;

 private:
  Ray camera_ray(uint32_t path, int bits, Numbers& numbers) const;
  enum class Met { kNothing, kPlace, kWalls };
  Met next_place(const Ray& ray, CoverageKey key, Place* out) const;
  float openness(const Place& place, const Vec3f& direction, float distance,
                 Numbers& numbers) const;
  LightSample light_sample(const Place& place, const LightGuide* guide, Numbers& numbers) const;
  double arriving(const Place& place, const LightSample& s, double density, Numbers& numbers) const;
  double lamp_light(const Place& place, Numbers& numbers) const;
  double environment_light(const Place& place, Numbers& numbers) const;
  KindSquares kind_squares(const Place& place, const LightGuide& guide, Numbers numbers) const;
  double noise(std::span<const Place> places, std::span<const KindSquares> squares,
               const KindFactors& factors) const;
  std::optional<SkyRegions> regions(const EnvironmentGuide& guide) const;
  void look(const EnvironmentGuide& guide, std::span<const Place* const> places, Numbers numbers,
            std::span<float> seen) const;

  const Scene& scene_;
  const Camera& camera_;
  int width_, height_;
  const std::stop_token& stop_;  // after a stop request the result is not used
};

// Any number of first paths is spread evenly over the frame.
Ray LightSurvey::camera_ray(uint32_t path, int bits, Numbers& numbers) const {
  uint32_t x = 0, y = 0;
  for (int bit = 0; bit < bits; ++bit) {
    uint32_t& axis = bit % 2 == 0 ? x : y;
    axis = axis << 1 | (path >> bit & 1u);
  }
  const float columns = float(1u << (bits + 1) / 2), rows = float(1u << bits / 2);
  const Vec2f in_cell = numbers.pair();
  const Vec2f film((float(x) + in_cell.x) / columns * float(width_),
                   (float(y) + in_cell.y) / rows * float(height_));
  const bool moves = scene_.moves() || camera_.moves();
  const float time = moves ? numbers.next() : 0.0f;
  return camera_.ray(film, numbers.pair(), time);
}

// Follows the ray to the next surface, straight through a limited number of smooth walls.
LightSurvey::Met LightSurvey::next_place(const Ray& from, CoverageKey key, Place* out) const {
  Ray ray = from;
  for (int walls = 0; walls < kWallsLookedThrough; ++walls) {
    SurfaceHit hit;
    if (!scene_.intersect(ray, key, &hit)) return Met::kNothing;
    SurfaceInteraction surface;
    scene_.interaction(hit, ray.time, &surface);
    const bool front = dot(ray.direction, surface.geometric_normal) < 0.0f;
    const float side = front ? 1.0f : -1.0f;
    if (!scene_.material_of(hit.instance).is_smooth_wall()) {
      *out = {surface.position, surface.geometric_normal * side, surface.shading_normal * side,
              surface.offset, ray.time};
      return Met::kPlace;
    }
    ray.origin = offset_ray_origin(surface.position, surface.geometric_normal, surface.offset,
                                   ray.direction);
    ray.t_max -= hit.t;
  }
  return Met::kWalls;
}

// Traces paths with diffuse scattering.
std::vector<Place> LightSurvey::walk(int bits, int surfaces) const {
  const size_t paths = size_t(1) << bits;
  std::vector<std::vector<Place>> found(paths);
  parallel_each(paths, 64, [&](size_t path) {
    if (stop_.stop_requested()) return;
    Numbers numbers{uint32_t(path)};
    Ray ray = camera_ray(uint32_t(path), bits, numbers);
    for (int i = 0; i < surfaces; ++i) {
      Place place;
      if (next_place(ray, {numbers.bits(), 0}, &place) != Met::kPlace) break;
      place.path = uint32_t(path);
      found[path].push_back(place);
      const ShadingFrame frame = ShadingFrame::from_normal(place.geometric_normal);
      ray.direction = frame.to_world(square_to_cosine_hemisphere(numbers.pair()));
      ray.origin =
          offset_ray_origin(place.position, place.geometric_normal, place.offset, ray.direction);
    }
  });
  std::vector<Place> places;
  for (const std::vector<Place>& path : found) {
    places.insert(places.end(), path.begin(), path.end());
  }
  return places;
}

// Transmittance over the distance along a direction.
float LightSurvey::openness(const Place& place, const Vec3f& direction, float distance,
                            Numbers& numbers) const {
  const CoverageKey key{numbers.bits(), 0};
  const Vec3f origin =
      offset_ray_origin(place.position, place.geometric_normal, place.offset, direction);
  if (distance == kInfinity && !scene_.has_smooth_walls()) {
    return scene_.transmittance_to_infinity(origin, direction, place.time, key);
  }
  Place met;
  const Ray ray{origin, direction, distance, place.time};
  return next_place(ray, key, &met) == Met::kNothing ? 1.0f : 0.0f;
}

LightSample LightSurvey::light_sample(const Place& place, const LightGuide* guide,
                                      Numbers& numbers) const {
  const float u_pick = numbers.next();
  const LightRequest request{query_of(place), u_pick, numbers.pair()};
  LightSample sample;
  LightSample* const out = &sample;
  scene_.lights().sample({&request, 1}, &out, guide);
  return sample;
}

// Arriving light divided by `density`, the pdf of the light sample or of all techniques together.
double LightSurvey::arriving(const Place& place, const LightSample& s, double density,
                             Numbers& numbers) const {
  const float cosine = dot(s.direction, place.geometric_normal);
  if (s.kind == LightKind::kNone || !(s.pdf > 0.0f) || !(cosine > 0.0f)) return 0;
  const Rgb radiance = s.kind == LightKind::kTriangle
                           ? scene_.lights().triangles()[s.index].mean_radiance
                           : s.radiance;
  return double(openness(place, s.direction, s.distance * kNearlyThere, numbers) * cosine) *
         double(luminance(radiance)) / density;
}

// One-sample estimate of the lamps' light; 0 if the sample chose the environment.
double LightSurvey::lamp_light(const Place& place, Numbers& numbers) const {
  const LightSample s = light_sample(place, nullptr, numbers);
  if (s.kind == LightKind::kEnvironment) return 0;
  return arriving(place, s, double(s.pdf), numbers);
}

// The environment's light from one light and one cosine sample, by the balance heuristic.
double LightSurvey::environment_light(const Place& place, Numbers& numbers) const {
  const EnvironmentLight& environment = *scene_.lights().environment();
  const auto light = [&](const Vec3f& direction, const Rgb& radiance, float pdf) {
    const float cosine = dot(direction, place.geometric_normal);
    if (!(cosine > 0.0f)) return 0.0;
    return double(openness(place, direction, kInfinity, numbers) * cosine) *
           double(luminance(radiance)) / (double(pdf) + double(cosine / kPi));
  };
  const EnvironmentSample s = environment.sample(numbers.pair());
  double sum = s.pdf > 0.0f ? light(s.direction, s.radiance, s.pdf) : 0;
  const Vec3f direction = ShadingFrame::from_normal(place.geometric_normal)
                              .to_world(square_to_cosine_hemisphere(numbers.pair()));
  float pdf;
  const Rgb radiance = environment.radiance_and_pdf(direction, &pdf);
  sum += light(direction, radiance, pdf);
  return sum;
}

// Whether only few samples of a place receive light from the environment, and it contributes enough
// of the light. With a sun, all samples of a place arrive or none do, so guiding is useless.
bool LightSurvey::guiding_pays(std::span<const Place> places) const {
  std::vector<double> lamps(places.size());
  std::vector<Moments> environment(places.size());
  parallel_each(places.size(), 32, [&](size_t i) {
    Numbers numbers{~uint32_t(i)};
    lamps[i] = lamp_light(places[i], numbers);
    for (int k = 0; k < kPilotSamples; ++k) {
      environment[i].add(environment_light(places[i], numbers));
    }
  });
  double of_lamps = 0, of_environment = 0, variance = 0, squares = 0;
  for (size_t i = 0; i < places.size(); ++i) {
    of_lamps += lamps[i];
    of_environment += environment[i].mean();
    variance += environment[i].variance();
    squares += square(environment[i].mean()) - environment[i].variance() / kPilotSamples;
  }
  return of_environment > 0 && of_environment >= kLeastShare * (of_environment + of_lamps) &&
         variance >= kLeastVariance * squares;
}

// Weighted against cosine-distributed BSDF samples by the balance heuristic.
KindSquares LightSurvey::kind_squares(const Place& place, const LightGuide& guide,
                                      Numbers numbers) const {
  KindSquares result;
  const std::array<float, kLightKinds> probabilities =
      scene_.lights().kind_probabilities(query_of(place), &guide);
  for (int i = 0; i < kKindSamples; ++i) {
    const LightSample s = light_sample(place, &guide, numbers);
    const float cosine = std::max(0.0f, dot(s.direction, place.geometric_normal));
    const double density = double(s.pdf) + double(s.delta ? 0.0f : cosine / kPi);
    const double light = arriving(place, s, density, numbers);
    const int kind = s.kind == LightKind::kEnvironment    ? kEnvironmentKind
                     : s.delta && s.distance == kInfinity ? kDirectionalKind
                                                          : kFiniteKind;
    result.mean += light / kKindSamples;
    result.squares[size_t(kind)] +=
        square(light) * double(probabilities[size_t(kind)]) / kKindSamples;
  }
  return result;
}

// Sum of the cells' relative deviations; the frame's mean light is added for dark cells.
double LightSurvey::noise(std::span<const Place> places, std::span<const KindSquares> squares,
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

// The factors with the least noise.
KindFactors LightSurvey::factors(std::span<const Place> places, const LightGuide& guide) const {
  std::vector<KindSquares> squares(places.size());
  parallel_each(places.size(), 32, [&](size_t i) {
    squares[i] = kind_squares(places[i], guide, Numbers{~uint32_t(i)});
  });
  KindFactors best{.least_share = kLeastKindShare, .least_directional = kLeastKindShare};
  double least = noise(places, squares, best);
  int far = 0;  // doublings of the other factor
  for (float KindFactors::*const factor : {&KindFactors::environment, &KindFactors::directional}) {
    KindFactors other = best;
    int taken = 0;
    for (int doublings = -kMostDoublings; doublings <= kMostDoublings; ++doublings) {
      other.*factor = std::ldexp(1.0f, doublings);
      const double found =
          noise(places, squares, other) * (1 + kReluctance * (far + std::abs(doublings)));
      if (!(found < least)) continue;
      least = found;
      taken = std::abs(doublings);
      best = other;
    }
    far += taken;
  }
  return least < kKindGain * noise(places, squares, {}) ? best : KindFactors{};
}

// Root mean squares, since these are the optimal sampling weights of the tiles.
void LightSurvey::look(const EnvironmentGuide& guide, std::span<const Place* const> places,
                       Numbers numbers, std::span<float> seen) const {
  using sky_tiles::kColumns, sky_tiles::kRows, sky_tiles::kCount;
  struct Looks {
    float squares = 0.0f;
    int count = 0;
    float mean() const { return count > 0 ? squares / float(count) : 0.0f; }
  };
  std::array<Looks, kCount> looks;
  const auto look_into = [&](int tile, int rays) {
    Looks& result = looks[size_t(tile)];
    for (int i = 0; i < rays; ++i, ++result.count) {
      const Place& place = *places[size_t(numbers.next() * float(places.size()))];
      const float u_part = numbers.next();
      const Vec3f direction = guide.direction_in(tile, u_part, numbers.pair());
      const float cosine = dot(direction, place.geometric_normal);
      if (!(cosine > 0.0f)) continue;
      result.squares += square(cosine * openness(place, direction, kInfinity, numbers));
    }
  };
  // Tiles with much light get more rays: the sun may be visible from a small part of the region.
  std::vector<int> lit;
  for (int tile = 0; tile < kCount; ++tile) {
    const double share = guide.light_share(tile);
    if (!(share > 0)) continue;
    lit.push_back(tile);
    look_into(tile, kLooks + std::min(kMostOfLight, int(share * kLooksOfLight)));
  }
  const auto around = [&](int tile) {
    const int row = tile / kColumns, column = tile % kColumns;
    const auto mean = [&](int r, int c) {
      return r < 0 || r == kRows ? 0.0f
                                 : looks[size_t(r * kColumns + (c + kColumns) % kColumns)].mean();
    };
    return (mean(row - 1, column) + mean(row + 1, column) + mean(row, column - 1) +
            mean(row, column + 1)) /
           4;
  };
  std::vector<int> open;
  for (const int tile : lit) {
    if (looks[size_t(tile)].squares + around(tile) > 0.0f) open.push_back(tile);
  }
  for (const int tile : open) look_into(tile, kMoreLooks);
  for (const int tile : open) {
    const Looks& own = looks[size_t(tile)];
    seen[size_t(tile)] =
        std::sqrt((own.squares + kLooksAround * around(tile)) / (float(own.count) + kLooksAround));
  }
}

std::optional<SkyRegions> LightSurvey::regions(const EnvironmentGuide& guide) const {
  const auto pixels = uint64_t(width_) * uint64_t(height_);
  const int bits = std::clamp(int(std::bit_width(pixels)) - 1, kPilotBits, kSurveyBits);
  const std::vector<Place> places = walk(bits, kSurveySurfaces);
  if (places.size() < kLeastPlaces) return std::nullopt;
  Vec3f lower, upper;
  std::vector<float> coordinates(places.size());
  for (int c = 0; c < 3; ++c) {
    std::ranges::transform(places, coordinates.begin(),
                           [c](const Place& place) { return place.position[c]; });
    const auto trimmed = std::ptrdiff_t(double(places.size()) * kTrimmed);
    std::ranges::nth_element(coordinates, coordinates.begin() + trimmed);
    lower[c] = coordinates[size_t(trimmed)];
    std::ranges::nth_element(coordinates, coordinates.end() - 1 - trimmed);
    upper[c] = *(coordinates.end() - 1 - trimmed);
  }
  const Vec3f size = upper - lower;
  const Vec3f margin(std::max({size.x, size.y, size.z}) / (2.0f * SkyRegions::kCells));
  SkyRegions regions(lower - margin, upper + margin);
  std::vector<std::vector<const Place*>> of_region;
  for (const Place& place : places) {
    const int region = regions.find_or_add(place.position, place.shading_normal);
    if (region == SkyRegions::kNone) continue;
    if (size_t(region) == of_region.size()) of_region.emplace_back();
    of_region[size_t(region)].push_back(&place);
    regions.places(region)++;
  }
  parallel_each(of_region.size(), 4, [&](size_t i) {
    if (stop_.stop_requested()) return;
    look(guide, of_region[i], Numbers{uint32_t(i)}, regions.seen(int(i)));
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
  const std::vector<Place> places = survey.walk(kPilotBits, kPilotSurfaces);
  if (places.size() < kLeastPlaces) return nullptr;
  LightGuide guide;
  if (lights.environment() && survey.guiding_pays(places))
    guide.environment = survey.environment_guide();
  if (lights.kinds() > 1)
    guide.factors = survey.factors(survey.walk(kPilotBits, kKindSurfaces), guide);
  if (stop.stop_requested()) return nullptr;
  if (!guide.environment && guide.factors == KindFactors{}) return nullptr;
  return std::make_shared<LightGuide>(std::move(guide));
}

}  // namespace emberline
