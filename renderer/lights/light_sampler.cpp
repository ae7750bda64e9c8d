#include "renderer/lights/light_sampler.h"

#include <Imath/ImathBox.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

#include "renderer/core/constants.h"
#include "renderer/core/hash.h"
#include "renderer/core/ray.h"
#include "renderer/lights/environment_guide.h"
#include "renderer/lights/environment_light.h"
#include "renderer/lights/light_bvh.h"
#include "renderer/lights/light_guide.h"
#include "renderer/lights/triangle_sampling.h"

namespace emberline {
namespace {

// Maximum weight of an infinite light, so that the sum of all weights does not overflow float.
constexpr float kMaxWeight = 1e30f;
// KHR_lights_punctual: "lightAngleScale = 1.0f / max(0.001f, cos(innerConeAngle) - cos(outer...))".
constexpr float kMinConeDifference = 0.001f;

bool emits(const Rgb& value) { return is_finite(value) && luminance(value) > 0.0f; }

// Extends u_pick beyond the 24 bits of a float. Otherwise, with thousands of lights, the interval
// of some light could lie between two floats, so that this light would never be picked. The
// additional bits are a hash of the sample's own numbers, so the function stays pure and the
// numbers stay stratified.
double refine(float u_pick, const Vec2f& u) {
  uint32_t h = hash_combine(hash32(std::bit_cast<uint32_t>(u.x)), std::bit_cast<uint32_t>(u.y));
  h = hash_combine(h, std::bit_cast<uint32_t>(u_pick));
  return std::min(double(u_pick) + double(h) * 0x1p-56, 1.0 - 0x1p-53);
}

// Uses double, since a squared range may overflow float.
bool in_range(const PointLightState& light, const Vec3d& to_light) {
  return !(dot(to_light, to_light) > square(double(light.range)));
}

float spot_attenuation(const PointLightState& light, const Vec3f& to_light) {
  const float scale = 1.0f / std::max(kMinConeDifference, light.cos_inner - light.cos_outer);
  const float cosine = -dot(light.direction, to_light);
  return square(std::clamp((cosine - light.cos_outer) * scale, 0.0f, 1.0f));
}

// Returns the luminance of the flux, for picking without a BVH.
double point_power(const PointLight& light, double intensity) {
  if (light.type == PointLightType::kPoint) return 4 * kPiD * intensity;
  return 2 * kPiD * intensity * (1.0 - 0.5 * (double(light.cos_inner) + double(light.cos_outer)));
}

}  // namespace

PointLightPlace PointLight::place_at(float time) const {
  if (motion.empty()) return *this;
  const float scaled = time * float(motion.size());
  const size_t next = std::min(size_t(scaled), motion.size() - 1);
  const PointLightPlace& a = next == 0 ? *this : motion[next - 1];
  const PointLightPlace& b = motion[next];
  const float part = scaled - float(next);
  return {lerp(a.position, b.position, part),
          normalize_or(lerp(a.direction, b.direction, part), a.direction)};
}

// The slow path of at(), for lights that change over time.
[[gnu::noinline, gnu::cold]] PointLightState PointLight::animated_at(float time) const {
  PointLightState state = *this;
  static_cast<PointLightPlace&>(state) = place_at(time);
  if (share) state.intensity *= share->at(time);
  if (visibility && !visibility->at(time)) state.intensity = Rgb(0.0f);
  if (cones) {
    const Vec2f angles = cones->at(time);
    state.cos_inner = std::cos(angles.x);
    state.cos_outer = std::cos(angles.y);
  }
  if (range_scale) state.range *= range_scale->at(time);
  return state;
}

LightSampler::LightSampler(std::vector<EmissiveTriangle> triangles, std::vector<PointLight> points,
                           std::shared_ptr<const EnvironmentLight> environment,
                           const EmitterMotion* motion, uint32_t bvh_threshold)
    : triangles_(std::move(triangles)),
      points_(std::move(points)),
      environment_(environment && !environment->black() ? std::move(environment) : nullptr),
      motion_(motion) {
  assert(triangles_.size() < kPointEmitter && points_.size() < kPointEmitter);
  std::vector<EmitterBounds> bounds;
  std::vector<double> powers;
  triangle_emitter_.assign(triangles_.size(), kNoEmitter);
  for (size_t i = 0; i < triangles_.size(); ++i) {
    const EmissiveTriangle& t = triangles_[i];
    if (!emits(t.mean_radiance)) continue;
    const EmitterBounds b = bounds_of(t, motion_);
    if (!(b.intensity > 0)) continue;
    triangle_emitter_[i] = uint32_t(emitters_.size());
    emitters_.push_back(uint32_t(i));
    bounds.push_back(b);
    powers.push_back(kPiD * bounds.back().intensity * (t.two_sided ? 2 : 1));
  }
  for (size_t i = 0; i < points_.size(); ++i) {
    const PointLight& light = points_[i];
    if (!emits(light.intensity)) continue;
    bool finite = is_finite(light.position);
    for (const PointLightPlace& place : light.motion) finite = finite && is_finite(place.position);
    if (light.type == PointLightType::kDirectional) {
      directional_.push_back(uint32_t(i));
      continue;
    }
    const EmitterBounds b = bounds_of(light);
    const double power = point_power(light, b.intensity);
    // A spot whose cone is empty has no power.
    if (!finite || !(power > 0) || !(light.range > 0.0f)) continue;
    ranged_ = ranged_ || light.range < kInfinity;
    emitters_.push_back(uint32_t(i) | kPointEmitter);
    bounds.push_back(b);
    powers.push_back(power);
  }
  if (!emitters_.empty()) measure_finite_lights(bounds);
  if (!emitters_.empty() && emitters_.size() >= bvh_threshold) {
    bvh_ = std::make_unique<const LightBvh>(bounds);
  } else {
    sum_powers(powers);
  }
}

// Computes the bounds and the total intensity of the finite lights.
void LightSampler::measure_finite_lights(std::span<const EmitterBounds> bounds) {
  Imath::Box3f box;
  double intensity = 0;
  float reach = 0.0f;
  for (const EmitterBounds& b : bounds) {
    box.extendBy({b.lower, b.upper});
    intensity += b.intensity;
    reach = std::max(reach, b.reach);
  }
  finite_centre_ = box.min * 0.5f + box.max * 0.5f;
  finite_radius2_ = (box.max * 0.5f - box.min * 0.5f).length2();
  finite_intensity_ = float(std::min(intensity, double(std::numeric_limits<float>::max())));
  finite_reach2_ = square((reach + std::sqrt(finite_radius2_)) * 1.00001f);
}

void LightSampler::sum_powers(std::span<const double> powers) {
  double total = 0;
  for (double power : powers) total += power;
  double sum = 0;
  for (double power : powers) {
    power_sums_.push_back(sum / total);
    sum += power;
  }
  power_sums_.push_back(1.0);
}

LightSampler::~LightSampler() = default;
LightSampler::LightSampler(LightSampler&&) noexcept = default;
LightSampler& LightSampler::operator=(LightSampler&&) noexcept = default;

bool LightSampler::empty() const {
  return emitters_.empty() && directional_.empty() && !environment_;
}

std::array<Vec3f, 3> LightSampler::corners(const EmissiveTriangle& t, float time) const {
  if (t.moves) [[unlikely]]
    return motion_->corners(t, time);
  return {t.p0, t.p1, t.p2};
}

float LightSampler::directional_weight(const LightQuery& query, const PointLight& light,
                                       float factor) const {
  const PointLightState state = light.at(query.time);
  float cosine = -dot(query.normal, state.direction);
  if (query.both_sides) cosine = std::abs(cosine);
  if (!(cosine > 0.0f)) return 0.0f;
  const float weight = luminance(state.intensity) * std::max(cosine, kMinReceiverCosine) * factor;
  return std::min(weight, kMaxWeight);
}

LightSampler::InfiniteChoice LightSampler::weigh_infinite(const LightQuery& query,
                                                          const LightGuide* guide) const {
  constexpr KindFactors kDefaultFactors;
  const KindFactors& factors = guide ? guide->factors : kDefaultFactors;
  InfiniteChoice choice;
  choice.directional_factor = factors.directional;
  int count = 0;
  for (uint32_t index : directional_) {
    const float weight = directional_weight(query, points_[index], choice.directional_factor);
    choice.total += weight;
    count += weight > 0.0f ? 1 : 0;
  }
  if (environment_) {
    // The irradiance that the environment would cause if it were uniform.
    const float irradiance = kPi * environment_->mean_luminance() * factors.environment;
    choice.environment = std::min(irradiance, kMaxWeight);
    // Directional lights keep a minimum weight: the survey may have missed a sun, which only light
    // sampling can find.
    const float minimum = choice.environment * factors.min_directional;
    if (choice.total > 0.0f && choice.total < minimum) [[unlikely]] {
      choice.directional_factor *= minimum / choice.total;
      choice.total = minimum;
    }
    choice.total += choice.environment;
    ++count;
  }
  if (count == 0) return choice;
  if (emitters_.empty()) {
    choice.probability = 1.0f;
    return choice;
  }
  const Vec3f to_finite = finite_centre_ - query.point;
  const float d2 = dot(to_finite, to_finite);
  float finite = finite_intensity_ / std::max(d2, finite_radius2_);
  if (ranged_) [[unlikely]] {
    const double in_reach = d2 > finite_reach2_ ? 0.0 : bvh_ ? 1.0 : share_in_reach(query);
    if (in_reach == 0.0) {
      choice.probability = 1.0f;
      return choice;
    }
    finite *= float(in_reach);
  }
  const float share = choice.total / (choice.total + finite);
  const float minimum = factors.min_share;
  choice.probability = share > minimum ? std::min(share, 1.0f - minimum) : minimum;
  return choice;
}

LightSample LightSampler::sample_directional(const LightQuery& query, const InfiniteChoice& choice,
                                             double u_weight) const {
  LightSample result;
  double rest = u_weight;
  uint32_t picked = kNoEmitter;
  float picked_weight = 0.0f;
  for (uint32_t index : directional_) {
    const float weight = directional_weight(query, points_[index], choice.directional_factor);
    if (weight <= 0.0f) continue;
    picked = index;  // stays the last light if rounding leaves a remainder
    picked_weight = weight;
    if (rest < double(weight)) break;
    rest -= double(weight);
  }
  if (picked == kNoEmitter) return {};
  const PointLightState light = points_[picked].at(query.time);
  result.kind = LightKind::kPoint;
  result.index = picked;
  result.direction = -light.direction;
  result.distance = kInfinity;
  result.radiance = light.intensity;
  result.pdf = choice.probability * (picked_weight / choice.total);
  result.delta = true;
  return result;
}

LightSampler::FinitePick LightSampler::pick_finite(const LightQuery& query, double u) const {
  if (bvh_) {
    const LightBvh::Pick pick = bvh_->pick(query, u);
    return {pick.emitter, pick.probability};
  }
  if (ranged_) [[unlikely]]
    return pick_in_reach(query, u);
  const auto above = std::upper_bound(power_sums_.begin(), power_sums_.end() - 1, u);
  const uint32_t emitter = uint32_t(above - power_sums_.begin()) - 1;
  return {emitter, finite_probability(query, emitter)};
}

float LightSampler::finite_probability(const LightQuery& query, uint32_t emitter) const {
  if (bvh_) return bvh_->probability(query, emitter);
  const double share = power_sums_[emitter + 1] - power_sums_[emitter];
  if (!ranged_) return float(share);
  return reaches(query, emitter) ? float(share / share_in_reach(query)) : 0.0f;
}

bool LightSampler::reaches(const LightQuery& query, uint32_t emitter) const {
  if (!(emitters_[emitter] & kPointEmitter)) return true;
  const PointLightState light = points_[emitters_[emitter] & ~kPointEmitter].at(query.time);
  return in_range(light, Vec3d(light.position) - Vec3d(query.point));
}

double LightSampler::share_in_reach(const LightQuery& query) const {
  double share = 0.0;
  for (uint32_t i = 0; i < emitters_.size(); ++i) {
    if (reaches(query, i)) share += power_sums_[i + 1] - power_sums_[i];
  }
  return share;
}

LightSampler::FinitePick LightSampler::pick_in_reach(const LightQuery& query, double u) const {
  const double total = share_in_reach(query);
  double rest = u * total;
  FinitePick pick;
  for (uint32_t i = 0; i < emitters_.size(); ++i) {
    if (!reaches(query, i)) continue;
    const double share = power_sums_[i + 1] - power_sums_[i];
    pick = {i, float(share / total)};  // stays the last light if rounding leaves a remainder
    if (rest < share) break;
    rest -= share;
  }
  return pick;
}

LightSample LightSampler::sample_point(const LightQuery& query, uint32_t index,
                                       float probability) const {
  LightSample result;
  const PointLightState light = points_[index].at(query.time);
  const Vec3d to_light = Vec3d(light.position) - Vec3d(query.point);
  const double d2 = dot(to_light, to_light);
  if (!(d2 > 0) || !in_range(light, to_light)) return {};
  const double distance = std::sqrt(d2);
  result.direction = Vec3f(to_light / distance);
  const bool is_spot = points_[index].type == PointLightType::kSpot;
  const float attenuation = is_spot ? spot_attenuation(light, result.direction) : 1.0f;
  result.radiance = light.intensity * float(double(attenuation) / d2);
  // The light is black, does not shine here, or is so close that the radiance overflows float.
  if (is_black(result.radiance) || !is_finite(result.radiance)) return {};
  result.kind = LightKind::kPoint;
  result.index = index;
  result.distance = float(distance);
  result.position = light.position;
  result.pdf = probability;
  result.delta = true;
  return result;
}

void LightSampler::sample_triangles(TriangleBatch& batch, LightSample* const* out) const {
  batch.sample();
  for (int i = 0; i < batch.size(); ++i) {
    LightSample& result = *out[i];
    const TriangleSample s = batch[i];
    const uint32_t index = result.index;
    const float probability = result.pdf;
    result = LightSample{};
    if (!(s.pdf > 0.0f) || !(triangles_[index].two_sided || batch.in_front(i))) continue;
    result.kind = LightKind::kTriangle;
    result.index = index;
    result.direction = s.direction;
    result.distance = s.distance;
    result.position = s.position;
    result.emitter_normal = batch.normal(i);
    result.barycentric = s.barycentric;
    result.pdf = probability * s.pdf;
  }
}

void LightSampler::sample_environment(std::span<const GuidedRequest> requests,
                                      const EnvironmentGuide* guide,
                                      LightSample* const* out) const {
  EnvironmentSample samples[kRayBatch];
  if (guide) {
    guide->sample(requests, samples);
  } else {
    Vec2f u[kRayBatch];
    for (size_t i = 0; i < requests.size(); ++i) u[i] = requests[i].u;
    environment_->sample({u, requests.size()}, samples);
  }
  for (size_t i = 0; i < requests.size(); ++i) {
    const EnvironmentSample& s = samples[i];
    LightSample& result = *out[i];
    const float probability = result.pdf;
    result = LightSample{};
    if (!(s.pdf > 0.0f)) continue;
    result.kind = LightKind::kEnvironment;
    result.direction = s.direction;
    result.distance = kInfinity;
    result.radiance = s.radiance;
    result.pdf = probability * s.pdf;
  }
}

namespace {

// The requests of a batch that pick the environment, with their outputs.
struct EnvironmentBatch {
  GuidedRequest requests[kRayBatch];
  LightSample* out[kRayBatch];
  size_t count = 0;

  // `pick`, in [0, weight), is the random number that picked the environment.
  void add(const LightRequest& request, double pick, float weight, const EnvironmentGuide* guide,
           LightSample* result) {
    GuidedRequest& guided = requests[count];
    guided.u = request.u;
    if (guide && !request.query.both_sides) [[unlikely]] {
      guided.region = guide->region_of(request.query.point, request.query.normal);
      guided.u_part = std::min(float(pick / double(weight)), kOneMinusEpsilon);
    }
    out[count++] = result;
  }
};

}  // namespace

void LightSampler::sample(std::span<const LightRequest> requests, LightSample* const* out,
                          const LightGuide* guide) const {
  assert(requests.size() <= size_t(kRayBatch));
  const EnvironmentGuide* const environment_guide = guide ? guide->environment.get() : nullptr;
  // Requests for the environment and for triangles are processed in separate batches.
  EnvironmentBatch environment;
  TriangleBatch triangles;
  LightSample* triangle_out[kRayBatch];
  for (size_t i = 0; i < requests.size(); ++i) {
    const LightQuery& query = requests[i].query;
    double pick = refine(requests[i].u_pick, requests[i].u);
    float finite_share = 1.0f;
    if (has_infinite()) {
      const InfiniteChoice infinite = weigh_infinite(query, guide);
      const double split = double(infinite.probability);
      if (pick < split) {
        const double weight = pick / split * double(infinite.total);
        if (environment_ && weight < double(infinite.environment)) {
          environment.add(requests[i], weight, infinite.environment, environment_guide, out[i]);
          out[i]->pdf = infinite.probability * (infinite.environment / infinite.total);
        } else {
          *out[i] = sample_directional(query, infinite, weight - double(infinite.environment));
        }
        continue;
      }
      pick = std::min((pick - split) / (1.0 - split), 1.0 - 0x1p-53);
      finite_share = 1.0f - infinite.probability;
    }
    *out[i] = LightSample{};
    if (emitters_.empty()) continue;
    const FinitePick finite = pick_finite(query, pick);
    const float probability = finite_share * finite.probability;
    if (!(probability > 0.0f)) continue;
    const uint32_t index = emitters_[finite.emitter] & ~kPointEmitter;
    if (emitters_[finite.emitter] & kPointEmitter) {
      *out[i] = sample_point(query, index, probability);
      continue;
    }
    const EmissiveTriangle& t = triangles_[index];
    if (t.has_visibility_times && !motion_->visibility(t, query.time)) [[unlikely]]
      continue;
    out[i]->index = index;
    out[i]->pdf = probability;
    triangle_out[triangles.size()] = out[i];
    triangles.add(corners(t, query.time), query.point, requests[i].u);
  }
  if (triangles.size() > 0) sample_triangles(triangles, triangle_out);
  if (environment.count > 0) {
    sample_environment({environment.requests, environment.count}, environment_guide,
                       environment.out);
  }
}

float LightSampler::pdf_triangle(const LightQuery& query, uint32_t index, float distance,
                                 const LightGuide* guide) const {
  const uint32_t emitter = triangle_emitter_[index];
  if (emitter == kNoEmitter) return 0.0f;
  const EmissiveTriangle& t = triangles_[index];
  const auto [p0, p1, p2] = corners(t, query.time);
  const ProjectedTriangle projected = project_triangle(p0, p1, p2, query.point);
  if (!t.two_sided && !(projected.height > 0)) return 0.0f;
  const float finite_share =
      has_infinite() ? 1.0f - weigh_infinite(query, guide).probability : 1.0f;
  const float probability = finite_share * finite_probability(query, emitter);
  return probability * triangle_pdf(projected, distance);
}

float LightSampler::environment_probability(const LightQuery& query,
                                            const LightGuide* guide) const {
  if (!environment_) return 0.0f;
  const InfiniteChoice choice = weigh_infinite(query, guide);
  // The total is 0 if the luminance of the environment underflows float; the environment is then
  // never picked.
  return choice.total > 0.0f ? choice.probability * (choice.environment / choice.total) : 0.0f;
}

std::array<float, kLightKinds> LightSampler::kind_probabilities(const LightQuery& query,
                                                                const LightGuide* guide) const {
  std::array<float, kLightKinds> result{};
  const InfiniteChoice choice = weigh_infinite(query, guide);
  if (choice.total > 0.0f) {
    result[kEnvironmentKind] = choice.probability * (choice.environment / choice.total);
    result[kDirectionalKind] = choice.probability - result[kEnvironmentKind];
  }
  if (!emitters_.empty()) result[kFiniteKind] = 1.0f - choice.probability;
  return result;
}

std::string LightSampler::describe() const {
  std::string text;
  const auto add = [&text](const std::string& part) { text += text.empty() ? part : ", " + part; };
  if (!emitters_.empty())
    add(std::string(bvh_ ? "light BVH (" : "power (") + std::to_string(emitters_.size()) +
        (emitters_.size() == 1 ? " emitter)" : " emitters)"));
  if (!directional_.empty()) add(std::to_string(directional_.size()) + " directional");
  if (environment_) add("environment");
  return text.empty() ? "none" : text;
}

uint64_t LightSampler::bytes() const {
  return triangles_.size() * sizeof(EmissiveTriangle) + points_.size() * sizeof(PointLight) +
         (triangle_emitter_.size() + emitters_.size() + directional_.size()) * sizeof(uint32_t) +
         power_sums_.size() * sizeof(double) + (bvh_ ? bvh_->bytes() : 0);
}

}  // namespace emberline
