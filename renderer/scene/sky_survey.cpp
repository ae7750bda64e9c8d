#include "renderer/scene/sky_survey.h"

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
#include "renderer/scene/camera.h"
#include "renderer/scene/scene.h"

namespace emberline {
namespace {

// All constants are ours; tests/bench/RESULTS.md has what others gave.

// Camera paths, a power of two of them, and how many of their surfaces are looked from: to find out
// whether a guide pays, and to make one, with at most as many paths as the frame has pixels.
constexpr int kPilotBits = 9, kPilotSurfaces = 2;
constexpr int kSurveyBits = 14, kSurveySurfaces = 4;
// A guide pays where the samples of one place vary by so much, over the square of their mean, and
// where at least so much of the light is the environment's.
constexpr double kLeastVariance = 3, kLeastShare = 0.3;
constexpr int kPilotSamples = 8;
// Of the way to a lamp: its own surface is not in the way.
constexpr float kNearlyThere = 0.999f;
constexpr size_t kLeastPlaces = 64;
// Of the places along each axis; those beyond, out of a window perhaps, are in no region.
constexpr double kTrimmed = 0.01;
// Rays from a region into each tile; as many more, up to a limit, for all of the light; more where
// a tile or a neighbour was seen; and as how many of its own the neighbours' count.
constexpr int kLooks = 2, kLooksOfLight = 256, kMostOfLight = 32, kMoreLooks = 8;
constexpr float kLooksAround = 4;
// Smooth walls, one behind the other, that are looked through: as many as windows have.
constexpr int kWallsLookedThrough = 8;

// One after the other, from a seed.
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

// A point of a surface that a path came to, on the side that it came from.
struct Place {
  Vec3f position;
  Vec3f geometric_normal, shading_normal;
  float offset = 0.0f;
  float time = 0.0f;
};

LightQuery query_of(const Place& place) {
  return {place.position, place.shading_normal, false, place.time};
}

class SkySurvey {
 public:
  SkySurvey(const Scene& scene, const Camera& camera, int width, int height)
      : scene_(scene), camera_(camera), width_(width), height_(height) {}

  bool pays() const;
  std::optional<SkyRegions> regions(const EnvironmentGuide& guide) const;

 private:
  std::vector<Place> walk(int bits, int surfaces) const;
  Ray camera_ray(uint32_t path, int bits, Numbers& numbers) const;
  enum class Met { kNothing, kPlace, kWalls };
  Met next_place(const Ray& ray, CoverageKey key, Place* out) const;
  float openness(const Place& place, const Vec3f& direction, float distance,
                 Numbers& numbers) const;
  double lamp_light(const Place& place, Numbers& numbers) const;
  double environment_light(const Place& place, Numbers& numbers) const;
  void look(const EnvironmentGuide& guide, std::span<const Place* const> places, Numbers numbers,
            std::span<float> seen) const;

  const Scene& scene_;
  const Camera& camera_;
  int width_, height_;
};

// Paths are spread over the frame whatever number of the first ones is taken.
Ray SkySurvey::camera_ray(uint32_t path, int bits, Numbers& numbers) const {
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

// Where the ray comes to, straight through smooth walls, if they are not too many.
SkySurvey::Met SkySurvey::next_place(const Ray& from, CoverageKey key, Place* out) const {
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

// Of paths that are scattered as by chalk.
std::vector<Place> SkySurvey::walk(int bits, int surfaces) const {
  const size_t paths = size_t(1) << bits;
  std::vector<std::vector<Place>> found(paths);
  parallel_ranges(paths, 64, [&](size_t begin, size_t end) {
    for (size_t path = begin; path < end; ++path) {
      Numbers numbers{uint32_t(path)};
      Ray ray = camera_ray(uint32_t(path), bits, numbers);
      for (int i = 0; i < surfaces; ++i) {
        Place place;
        if (next_place(ray, {numbers.bits(), 0}, &place) != Met::kPlace) break;
        found[path].push_back(place);
        const ShadingFrame frame = ShadingFrame::from_normal(place.geometric_normal);
        ray.direction = frame.to_world(square_to_cosine_hemisphere(numbers.pair()));
        ray.origin =
            offset_ray_origin(place.position, place.geometric_normal, place.offset, ray.direction);
      }
    }
  });
  std::vector<Place> places;
  for (const std::vector<Place>& path : found) {
    places.insert(places.end(), path.begin(), path.end());
  }
  return places;
}

// What arrives from so far in a direction.
float SkySurvey::openness(const Place& place, const Vec3f& direction, float distance,
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

// Of the lamps; what one sample brings, or nothing if it chose the environment.
double SkySurvey::lamp_light(const Place& place, Numbers& numbers) const {
  const LightSampler& lights = scene_.lights();
  const float u_pick = numbers.next();
  const LightSample s = lights.sample(query_of(place), u_pick, numbers.pair());
  const float cosine = dot(s.direction, place.geometric_normal);
  if (s.kind == LightKind::kNone || s.kind == LightKind::kEnvironment || !(s.pdf > 0.0f) ||
      !(cosine > 0.0f)) {
    return 0;
  }
  const Rgb radiance =
      s.kind == LightKind::kTriangle ? lights.triangles()[s.index].mean_radiance : s.radiance;
  return double(openness(place, s.direction, s.distance * kNearlyThere, numbers) * cosine / s.pdf) *
         double(luminance(radiance));
}

// Of the environment, by one sample of it and one of a chalk's, weighed by the balance heuristic.
double SkySurvey::environment_light(const Place& place, Numbers& numbers) const {
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

// Whether the environment's light arrives by few samples of each place, and enough of all light is
// its. Where every sample of some places arrives, and none of others, as with a sun, there is
// nothing to guide.
bool SkySurvey::pays() const {
  const std::vector<Place> places = walk(kPilotBits, kPilotSurfaces);
  if (places.size() < kLeastPlaces) return false;
  std::vector<double> lamps(places.size());
  std::vector<Moments> environment(places.size());
  parallel_ranges(places.size(), 32, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Numbers numbers{~uint32_t(i)};
      lamps[i] = lamp_light(places[i], numbers);
      for (int k = 0; k < kPilotSamples; ++k) {
        environment[i].add(environment_light(places[i], numbers));
      }
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

// Root mean squares: of what a tile brings if its samples are to have the least variance.
void SkySurvey::look(const EnvironmentGuide& guide, std::span<const Place* const> places,
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
  // More where much of the light is: the sun may be seen from a small part of the region.
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

std::optional<SkyRegions> SkySurvey::regions(const EnvironmentGuide& guide) const {
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
  parallel_ranges(of_region.size(), 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      look(guide, of_region[i], Numbers{uint32_t(i)}, regions.seen(int(i)));
    }
  });
  return regions;
}

}  // namespace

std::shared_ptr<const EnvironmentGuide> find_environment_guide(const Scene& scene,
                                                               const Camera& camera, int width,
                                                               int height) {
  const EnvironmentLight* const light = scene.lights().environment();
  if (!light) return nullptr;
  const SkySurvey survey(scene, camera, width, height);
  if (!survey.pays()) return nullptr;
  auto guide = std::make_shared<EnvironmentGuide>(*light);
  std::optional<SkyRegions> regions = survey.regions(*guide);
  if (!regions) return nullptr;
  guide->set_regions(std::move(*regions));
  return guide;
}

}  // namespace emberline
