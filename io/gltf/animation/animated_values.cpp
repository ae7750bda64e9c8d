#include "io/gltf/animation/animated_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "io/gltf/document/extensions.h"
#include "io/gltf/geometry/node_objects.h"
#include "renderer/core/constants.h"
#include "renderer/core/errors.h"

namespace emberline {
namespace {

using nlohmann::json;

constexpr std::string_view kMaterials = "/materials/", kCameras = "/cameras/",
                           kLights = "/extensions/KHR_lights_punctual/lights/";
constexpr const char* kFactor = "/emissiveFactor";
constexpr const char* kStrength = "/extensions/KHR_materials_emissive_strength/emissiveStrength";

// Largest error at a tested point of a curve, relative to the largest of the values at this point
// and at the ends of its interval.
constexpr double kTolerance = 1e-3;
// An interval between key frames is divided into at most 2^kMaxHalvings pieces, or into fewer if
// the curve would exceed kMaxPieces in total. Shorter pieces would not be visible.
constexpr int kMaxHalvings = 10;
constexpr size_t kMaxPieces = 65536;

double magnitude(double value) { return std::abs(value); }
double magnitude(float value) { return double(std::abs(value)); }
double magnitude(const Rgb& value) { return double(max_abs_component(value)); }
double magnitude(const Vec2f& v) { return double(std::max(std::abs(v.x), std::abs(v.y))); }

template <class Value>
class CurveBuilder {
 public:
  explicit CurveBuilder(const GltfAnimation& animation) : animation_(animation) {}

  void add(double seconds, const Value& value) {
    auto& [times, values] = curve_;
    const float time = animation_.shutter_fraction(seconds);
    const size_t n = values.size();
    if (n > 0 && times.back() == time && values.back() == value) return;
    if (n > 1 && values[n - 2] == value && values.back() == value) {
      times.back() = time;  // the value is still constant
      return;
    }
    times.push_back(time);
    values.push_back(value);
  }

  // Adds the curve from `from` to `to`. The value at `from` must have been added already.
  template <class At>
  void subdivide(const At& at, double from, const Value& first, double to, const Value& last,
                 int halvings) {
    // Tests two points, since a cubic may cross its chord at one of them.
    for (const double share : {0.25, 0.6}) {
      if (halvings == 0) break;
      const Value found = at(from + (to - from) * share);
      const Value chord = first + (last - first) * float(share);
      const double largest = std::max({magnitude(first), magnitude(last), magnitude(found)});
      if (!(magnitude(found - chord) > kTolerance * largest)) continue;
      const double middle = 0.5 * (from + to);
      const Value between = at(middle);
      subdivide(at, from, first, middle, between, halvings - 1);
      subdivide(at, middle, between, to, last, halvings - 1);
      return;
    }
    add(to, last);
  }

  size_t size() const { return curve_.times.size(); }
  TimeCurve<Value> take() { return std::move(curve_); }

 private:
  const GltfAnimation& animation_;
  TimeCurve<Value> curve_;
};

template <class Value>
bool is_constant(const TimeCurve<Value>& curve) {
  return std::ranges::all_of(curve.values,
                             [&](const Value& value) { return value == curve.values.front(); });
}

// Whether the track's value changes while the shutter is open.
bool changes(const GltfAnimation& animation, const PointerTrack& track) {
  const KeyFrames* const keys[] = {&track.keys};
  const std::vector<double> times = shutter_key_times(animation, keys);
  std::vector<double> first(track.keys.width), now(track.keys.width);
  sample_value(track, times.front(), first);
  return std::ranges::any_of(times, [&](double time) {
    sample_value(track, time, now);
    return now != first;
  });
}

// Caps ranges at a value that acts as infinite. The curve is relative to the largest range, so the
// cap keeps the curve finite.
void apply_range(const TimeCurve<float>& ranges, PunctualLightDescription& light) {
  constexpr float kPracticallyInfinite = 1e18f;
  light.range = *std::ranges::max_element(ranges.values);
  if (is_constant(ranges)) return;
  auto share = std::make_shared<TimeCurve<float>>(ranges);
  light.range = std::min(light.range, kPracticallyInfinite);
  for (float& value : share->values) value = std::min(value, light.range) / light.range;
  light.range_scale = std::move(share);
}

}  // namespace

void GltfAnimatedValues::apply(std::vector<MaterialDescription>& materials) const {
  for (const auto& [index, brightness] : materials_) {
    materials[index].emission = brightness.peak;
    materials[index].emission_scale = brightness.share;
  }
}

void GltfAnimatedValues::apply(size_t light, PunctualLightDescription& description) const {
  if (const auto found = lights_.find(light); found != lights_.end()) {
    description.intensity = found->second.peak;
    description.share = found->second.share;
  }
  if (const auto found = ranges_.find(light); found != ranges_.end()) {
    apply_range(*found->second, description);
  }
  const auto found = cones_.find(light);
  if (found == cones_.end() || description.type != PunctualType::kSpot) return;
  Vec2f widest(0.0f);
  for (const Vec2f& angles : found->second->values) {
    widest = {std::max(widest.x, angles.x), std::max(widest.y, angles.y)};
  }
  description.inner_cone = widest.x;
  description.outer_cone = widest.y;
  if (!is_constant(*found->second)) description.cones = found->second;
}

void GltfAnimatedValues::apply(size_t camera, CameraDescription& description) const {
  const auto found = lenses_.find(camera);
  if (found == lenses_.end() || description.fault) return;
  const TimeCurve<double>& lens = *found->second;
  (description.orthographic ? description.y_mag : description.fov_y) = lens.values.front();
  if (!is_constant(lens)) description.zoom = found->second;
}

uint64_t max_curve_times(const GltfDocument& document) {
  return (uint64_t(1) << 22) + document.total_bytes * 8;
}

GltfAnimatedValues::GltfAnimatedValues(const GltfDocument& document, const GltfAnimation& animation,
                                       CoverageReport& coverage)
    : document_(document), animation_(animation) {
  if (!(animation.open < animation.close)) return;
  for (const PointerTrack& track : animation.pointers) {
    tracks_[track.pointer] = &track;
  }
  const struct {
    std::string_view root;
    void (GltfAnimatedValues::*read)(size_t);
  } kinds[] = {{kMaterials, &GltfAnimatedValues::read_material},
               {kCameras, &GltfAnimatedValues::read_camera},
               {kLights, &GltfAnimatedValues::read_light}};
  for (const auto& [root, read] : kinds) {
    std::string last;
    for (auto track = tracks_.lower_bound(std::string(root));
         track != tracks_.end() && track->first.starts_with(root); ++track) {
      const std::string object = track->first.substr(0, track->first.find('/', root.size()));
      if (object == last) continue;
      last = object;
      document.progress->check();
      if (document.faults->has(object)) continue;
      try {
        (this->*read)(size_t(std::stoul(object.substr(root.size()))));
      } catch (const InputError& error) {
        document.faults->note_broken(object, error);
      }
    }
  }
  report_held_values(coverage);
}

void GltfAnimatedValues::report_held_values(CoverageReport& coverage) const {
  std::map<std::pair<const void*, const void*>, bool> known;  // whether it changes, by key frames
  for (const auto& [pointer, track] : tracks_) {
    const bool is_followed = pointer.starts_with(kLights) || pointer.ends_with(kFactor) ||
                             pointer.ends_with(kStrength) || pointer.ends_with("/yfov") ||
                             pointer.ends_with("mag") || pointer.ends_with("/znear") ||
                             pointer.ends_with("/zfar");
    if (is_followed) continue;
    const auto [entry, is_new] =
        known.try_emplace({track->keys.times.get(), track->keys.values.get()});
    if (is_new) entry->second = changes(animation_, *track);
    if (!entry->second) continue;
    report_approximated(
        document_.file,
        "animated " +
            std::string(pointer.starts_with(kCameras) ? "aspect ratios" : "material values") +
            " (held while the shutter is open)",
        coverage);
  }
}

GltfAnimatedValues::ValueSource GltfAnimatedValues::find(const std::string& pointer,
                                                         std::vector<double> default_value) const {
  const auto track = tracks_.find(pointer);
  if (track != tracks_.end()) return {track->second, std::move(default_value)};
  const json::json_pointer place(pointer);
  if (!document_.json->contains(place)) return {nullptr, std::move(default_value)};
  const json& value = document_.json->at(place);
  if (value.is_number()) return {nullptr, {value.get<double>()}};
  return {nullptr, value.get<std::vector<double>>()};
}

template <class Value, class Make>
GltfAnimatedValues::Curve<Value> GltfAnimatedValues::curve(const std::vector<ValueSource>& sources,
                                                           const Make& make) {
  std::vector<const KeyFrames*> keys;
  for (const ValueSource& source : sources) {
    if (source.track) keys.push_back(&source.track->keys);
  }
  const std::vector<double> times = shutter_key_times(animation_, keys);
  int halvings = kMaxHalvings;
  while (halvings > 0 && times.size() << halvings > kMaxPieces) --halvings;
  CurveBuilder<Value> builder(animation_);
  size_t reserved_count = 0;
  for (size_t i = 0; i + 1 < times.size(); ++i) {
    const double from = times[i], to = times[i + 1], inside = 0.5 * (from + to);
    // Step tracks are sampled in the middle of the interval, so their value is constant up to its
    // end. At a jump, the curve then has two points with the same time.
    const auto at = [&](double seconds) {
      std::array<double, 6> numbers = {};
      size_t n = 0;
      for (const ValueSource& source : sources) {
        const std::span<double> out = std::span(numbers).subspan(n, source.fixed.size());
        std::ranges::copy(source.fixed, out.begin());
        if (source.track) {
          const bool steps = source.track->keys.interpolation == Interpolation::kStep;
          sample_value(*source.track, steps ? inside : seconds, out);
        }
        n += source.fixed.size();
      }
      return make(numbers);
    };
    const Value first = at(from);
    builder.add(from, first);
    builder.subdivide(at, from, first, to, at(to), halvings);
    if (builder.size() - reserved_count < 65536 && i + 2 < times.size()) continue;
    document_.progress->check();
    reserve_times(builder.size() - reserved_count, sizeof(float) + sizeof(Value));
    reserved_count = builder.size();
  }
  return std::make_shared<const TimeCurve<Value>>(builder.take());
}

void GltfAnimatedValues::reserve_times(uint64_t times, size_t bytes) {
  // The factor is 2 because vectors grow by doubling.
  document_.reserve(MemoryPart::kLights, bytes_of(2 * times, bytes));
  times_ += times;
  if (times_ > max_curve_times(document_)) {
    throw LimitError(
        document_.file,
        "while the shutter is open, its animations change lights, lenses and materials "
        "too often for a file of this size");
  }
}

GltfAnimatedValues::EmissionCurve GltfAnimatedValues::brightness(const ValueSource& color,
                                                                 const ValueSource& factor,
                                                                 const std::string& place) {
  const Curve<Rgb> absolute = curve<Rgb>({color, factor}, [](const auto& n) {
    Rgb value;
    for (size_t c = 0; c < 3; ++c) value[int(c)] = float(std::max(n[c], 0.0) * n[3]);
    return value;
  });
  EmissionCurve result;
  for (const Rgb& value : absolute->values) {
    if (!is_finite(value)) throw InputError(place, "its brightness is not finite");
    for (int c = 0; c < 3; ++c) result.peak[c] = std::max(result.peak[c], value[c]);
  }
  if (is_constant(*absolute)) return result;
  auto share = std::make_shared<TimeCurve<Rgb>>(*absolute);
  for (Rgb& value : share->values) {
    for (int c = 0; c < 3; ++c) value[c] = value[c] > 0.0f ? value[c] / result.peak[c] : 0.0f;
  }
  result.share = std::move(share);
  return result;
}

void GltfAnimatedValues::read_material(size_t index) {
  const std::string pointer = std::string(kMaterials) + std::to_string(index);
  if (!is_animated(pointer + kFactor) && !is_animated(pointer + kStrength)) return;
  materials_[index] = brightness(find(pointer + kFactor, {0.0, 0.0, 0.0}),
                                 find(pointer + kStrength, {1.0}), document_.place(pointer));
}

void GltfAnimatedValues::read_light(size_t index) {
  const std::string pointer = std::string(kLights) + std::to_string(index);
  const std::string place = document_.place(pointer);
  if (is_animated(pointer + "/color") || is_animated(pointer + "/intensity")) {
    lights_[index] = brightness(find(pointer + "/color", {1.0, 1.0, 1.0}),
                                find(pointer + "/intensity", {1.0}), place);
  }
  if (const std::string range = pointer + "/range"; is_animated(range)) {
    ranges_[index] = curve<float>(
        {find(range, {0.0})}, [&](const auto& n) { return light_range(n[0], document_, pointer); });
  }
  const std::string inner = pointer + "/spot/innerConeAngle";
  const std::string outer = pointer + "/spot/outerConeAngle";
  if (!is_animated(inner) && !is_animated(outer)) return;
  cones_[index] = curve<Vec2f>({find(inner, {0.0}), find(outer, {kPiD / 4})}, [&](const auto& n) {
    return cone_angles(n[0], n[1], document_, pointer);
  });
}

void GltfAnimatedValues::read_camera(size_t index) {
  const std::string pointer = std::string(kCameras) + std::to_string(index);
  const std::string yfov = pointer + "/perspective/yfov", ymag = pointer + "/orthographic/ymag";
  const bool is_angle = is_animated(yfov);
  if (!is_angle && !is_animated(ymag)) return;
  const std::string& lens = is_angle ? yfov : ymag;
  lenses_[index] = curve<double>({find(lens, {0.0})}, [&](const auto& n) {
    return is_angle ? field_of_view(n[0], document_.place(lens))
                    : magnification(n[0], document_.place(lens));
  });
}

}  // namespace emberline
