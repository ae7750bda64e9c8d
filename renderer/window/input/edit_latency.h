// Measures the latency that an artist experiences: from each edit to its first picture on the
// screen.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/session/session_picture.h"

namespace emberline {

// All times are in seconds on the same clock.
struct MeasuredEdit {
  uint64_t number = 0;               // RenderSession::edit()
  std::string what;                  // such as "orbit" or "roughness"
  double input_s = 0.0;              // time of the input
  std::optional<double> filled_s;    // when a filled SessionPicture first showed the edit
  std::optional<double> complete_s;  // when a complete SessionPicture first showed it
};

class EditLatency {
 public:
  static constexpr size_t kMaxEdits = 100000;

  void add_edit(uint64_t number, std::string what, double time_s);
  // Call after swapping buffers. A picture that shows an edit also shows all earlier edits.
  void displayed(const SessionPicture& picture, double time_s);

  std::span<const MeasuredEdit> edits() const { return edits_; }
  // Returns the latency of the newest edit that a filled picture on the screen shows. In a filled
  // picture, every pixel has a value.
  std::optional<double> newest_s() const { return newest_s_; }

 private:
  std::vector<MeasuredEdit> edits_;
  size_t first_unfilled_ = 0, first_incomplete_ = 0;
  std::optional<double> newest_s_;
};

// Returns the quantile for `q` in [0, 1], interpolated linearly (Hyndman & Fan 1996, definition 7).
// Returns NaN if there are no values.
double quantile(std::vector<double> values, double q);

}  // namespace emberline
