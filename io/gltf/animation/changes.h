// What KHR_animation_pointer changes while the shutter is open, besides nodes: what lights and
// materials send out, spots' cones, and lenses. Other values are held.
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

// Times that curves and visibility may have together: sharing key frames, a small file could ask
// for any number. Chosen by us.
uint64_t most_times(const GltfDocument& document);

// Curves jump where key frames are steps, and are within a thousandth of what other key frames come
// to, if there are up to a thousand of them; of more each counts, and straight lines between them.
class GltfChanges {
 public:
  // Both outlive it; values that are not animated are taken from the JSON. What is no light, lens
  // or emission at some time is noted as broken, what is held is added to the report. Throws
  // InputError for more key frames than memory or the file's size allows.
  GltfChanges(const GltfDocument& document, const GltfAnimation& animation,
              CoverageReport& coverage);

  // What has been read, so that it changes as the file says.
  void apply(std::vector<MaterialDescription>& materials) const;
  void apply(size_t light, PunctualLightDescription& description) const;
  void apply(size_t camera, CameraDescription& description) const;

 private:
  // As scene_description.h has it of what shines.
  struct Brightness {
    Rgb brightest = Rgb(0.0f);
    std::shared_ptr<const TimeCurve<Rgb>> share;
  };
  // Numbers of the document, animated or as they are.
  struct Source {
    const PointerTrack* track = nullptr;
    std::vector<double> fixed;
  };
  template <class Value>
  using Curve = std::shared_ptr<const TimeCurve<Value>>;

  void read_material(size_t index);
  void read_light(size_t index);
  void read_camera(size_t index);
  bool animated(const std::string& pointer) const { return tracks_.contains(pointer); }
  Source find(const std::string& pointer, std::vector<double> otherwise) const;
  Brightness brightness(const Source& color, const Source& factor, const std::string& place);
  template <class Value, class Make>
  Curve<Value> curve(const std::vector<Source>& sources, const Make& make);
  void keep(uint64_t times, size_t bytes);
  void report_held(CoverageReport& coverage) const;

  const GltfDocument& document_;
  const GltfAnimation& animation_;
  std::map<std::string, const PointerTrack*> tracks_;  // by pointer; of two the later counts
  std::map<size_t, Brightness> materials_, lights_;
  std::map<size_t, Curve<Vec2f>> cones_;
  std::map<size_t, Curve<float>> ranges_;
  std::map<size_t, Curve<double>> lenses_;
  uint64_t times_ = 0;  // of all curves
};

}  // namespace emberline
