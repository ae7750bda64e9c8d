// Follows values that KHR_animation_pointer changes while the shutter is open: emission of lights
// and materials, spot cones, ranges of lights, and lenses. All other values are held constant,
// except node properties, which shutter.h and visibility.h follow.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "io/gltf/animation/animation.h"
#include "io/gltf/document/document.h"
#include "renderer/core/time_curve.h"
#include "renderer/description/scene_description.h"

namespace emberline {

// Upper limit on the total number of points of all curves, and also on the total number of
// visibility changes. Without it, a small file could ask for any number, since key frames can be
// shared. The value is our choice.
uint64_t max_curve_times(const GltfDocument& document);

// Step interpolation gives curves with jumps. Other curves with up to a thousand key frames are
// within 0.1 % of the exact value. With many more key frames, straight lines connect the key
// frames.
class GltfAnimatedValues {
 public:
  // Both arguments must outlive this object. Values that are not animated come from the JSON.
  // Lights, lenses and emission that are invalid at some time are noted as broken. Values that are
  // held constant are added to `coverage`. Throws InputError for more key frames than memory or the
  // file's size allows.
  GltfAnimatedValues(const GltfDocument& document, const GltfAnimation& animation,
                     CoverageReport& coverage);

  // These functions add the animated curves to an object that was read from the file.
  void apply(std::vector<MaterialDescription>& materials) const;
  void apply(size_t light, PunctualLightDescription& description) const;
  void apply(size_t camera, CameraDescription& description) const;

 private:
  // The brightest emission, and the curve relative to this peak, as in scene_description.h.
  struct EmissionCurve {
    Rgb peak = Rgb(0.0f);
    std::shared_ptr<const TimeCurve<Rgb>> share;
  };
  // One or more numbers of the document, animated or constant.
  struct ValueSource {
    const PointerTrack* track = nullptr;
    std::vector<double> fixed;
  };
  template <class Value>
  using Curve = std::shared_ptr<const TimeCurve<Value>>;

  void read_material(size_t index);
  void read_light(size_t index);
  void read_camera(size_t index);
  bool is_animated(const std::string& pointer) const { return tracks_.contains(pointer); }
  ValueSource find(const std::string& pointer, std::vector<double> default_value) const;
  EmissionCurve brightness(const ValueSource& color, const ValueSource& factor,
                           const std::string& place);
  template <class Value, class Make>
  Curve<Value> curve(const std::vector<ValueSource>& sources, const Make& make);
  void reserve_times(uint64_t times, size_t bytes);
  void report_held_values(CoverageReport& coverage) const;

  const GltfDocument& document_;
  const GltfAnimation& animation_;
  std::map<std::string, const PointerTrack*> tracks_;  // by pointer; the last track is used
  std::map<size_t, EmissionCurve> materials_, lights_;
  std::map<size_t, Curve<Vec2f>> cones_;
  std::map<size_t, Curve<float>> ranges_;
  std::map<size_t, Curve<double>> lenses_;
  uint64_t times_ = 0;  // total number of points of all curves
};

}  // namespace emberline
