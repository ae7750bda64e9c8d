// A non-default text for every setting, for tests of tables of settings.
#pragma once

#include <map>
#include <string>

#include "renderer/scene/embree_isa.h"

namespace emberline::test {

inline const std::map<std::string, std::string>& non_default_values() {
  static const std::map<std::string, std::string> values = {
      {"edits", "/look/edits.json"},
      {"variant", "2"},
      {"aov", "albedo,Z"},
      {"part", "3/16"},
      {"plan", "/look/frame.plan"},
      {"sample-range", "7-16777216"},
      {"turntable", "-3/100"},
      {"turntable-center", "look-at"},
      {"cryptomatte", "asset,object"},
      {"cryptomatte-levels", "64"},
      {"half", "N,RGBA"},
      {"exr-compression", "dwab"},
      {"exr-parts", "layers"},
      {"light-groups", "yes"},
      {"denoise", "yes"},
      {"driver", "adaptive"},
      {"sampler", "stratified"},
      {"streams", "2"},
      {"spp", "16777216"},
      {"noise-threshold", "0.012345679"},
      {"min-spp", "3"},
      {"max-spp", "1000"},
      {"estimator", "two-stream"},
      {"allocation", "mse"},
      {"judge", "RGB,A"},
      {"unbiased", "yes"},
      {"time-limit", "0.1"},
      {"time-budget", "0.1"},
      {"integrator", "direct"},
      {"max-depth", "0"},
      {"light-samples", "2"},
      {"clamp-indirect", "0.1"},
      {"filter", "box"},
      {"filter-radius", "1.1"},
      {"seed", "4294967295"},
      {"static-noise", "yes"},
      {"bucket-size", "4096"},
      {"bucket-order", "spiral"},
      {"bisection-axis", "rows"},
      {"reconstruction", "linear"},
      {"size", "65536x1"},
      {"crop", "-2147483648,0,2147483647,7"},
      {"camera", "1"},
      {"look-from", "-0.1,1000000000000000,3.0000000000000004"},
      {"look-at", "0,-0,1e-300"},
      {"fov-y", "0.05"},
      {"f-stop", "2.8"},
      {"focus-distance", "1e-15"},
      {"panorama", "yes"},
      {"env", "/skies/sky.hdr"},
      {"sun", "-6.5,360"},
      {"env-strength", "1000000000"},
      {"env-rotation", "-36000"},
      {"env-sampling", "light"},
      {"guiding", "on"},
      {"transparent", "yes"},
      {"working-space", "acescg"},
      {"backfaces", "show"},
      {"animation", "Survey"},
      {"time", "-0.1"},
      {"frame", "12.5"},
      {"shutter", "-0.25,0.25"},
      {"fps", "23.976"},
      {"lenient", "yes"},
      {"isa", std::string(embree_isa_table().front().name)},
      {"resource-root", "/models"},
      {"catcher", "floor,wall"},
      {"catcher-plane", "-0.25"},
      {"holdout", "chair"},
  };
  return values;
}

}  // namespace emberline::test
