// From each edit to the first picture of it on the screen: what an artist feels of a renderer's
// speed.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/session/shown_picture.h"

namespace emberline {

// Times are seconds on one clock.
struct MeasuredEdit {
  uint64_t number = 0;                         // RenderSession::edit()
  std::string what;                            // "orbit", "roughness"
  double asked_s = 0.0;                        // when the hand moved
  std::optional<double> filled_s, complete_s;  // ShownPicture's two notions, when it was on screen
};

class EditLatency {
 public:
  static constexpr size_t kMostKept = 100000;

  void asked(uint64_t number, std::string what, double time_s);
  // After the buffers were swapped. A picture of a later edit shows the earlier ones too.
  void shown(const ShownPicture& picture, double time_s);

  std::span<const MeasuredEdit> edits() const { return edits_; }
  // The latency of the newest edit that has been shown completely.
  std::optional<double> newest_s() const { return newest_s_; }

 private:
  std::vector<MeasuredEdit> edits_;
  size_t first_unfilled_ = 0, first_incomplete_ = 0;
  std::optional<double> newest_s_;
};

// The value below which a share `q` in [0, 1] of the values lie, linear between neighbours
// (Hyndman & Fan 1996, definition 7); NaN without values.
double quantile(std::vector<double> values, double q);

}  // namespace emberline
