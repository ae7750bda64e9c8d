// Implements `--measure F`: replays edits in the real window, and measures the latency of each
// edit, how long the window was busy, and the render speed after the last edit.
//
// A script is a JSON list of steps. Each step has a time, in seconds after the first complete
// picture, and one edit:
//
//   [{"at_s": 0.5, "edit": {"orbit": [40, 0]}},                 mouse pixels
//    {"at_s": 0.7, "edit": {"light": 0, "intensity": 2}},       index in the list of lights
//    {"at_s": 0.9, "edit": {"material": 3, "roughness": 0.4}},
//    {"at_s": 1.1, "edit": {"environment_rotation": 30}},       degrees
//    {"at_s": 1.3, "edit": {"exposure": 0.5}}]
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/json/value.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {

class Measurement {
 public:
  // Throws InputError for an unusable script.
  Measurement(const ViewOptions& options, Workbench& bench);

  // Makes the edits that are due. Call whenever the window wakes up.
  void step(double now_s);
  double next_s() const;  // time of the next step
  // Records how long the window was busy between waking up and sleeping.
  void record_busy(double seconds);
  bool finished() const { return finished_; }
  // Throws RenderError.
  void write() const;

 private:
  struct Step {
    double at_s = 0.0;
    JsonValue edit;
  };
  struct Mark {
    double time_s = 0.0;
    uint64_t samples = 0, rays = 0;
  };

  std::vector<Step> built_in_script() const;
  void apply_edit(const nlohmann::json& edit);
  Mark mark(double now_s) const;

  std::string file_, scene_;
  Workbench& bench_;
  std::vector<Step> steps_;
  bool scripted_ = false;
  size_t next_step_ = 0, first_edit_ = 0;
  double first_picture_s_ = -1.0, last_edit_s_ = 0.0, now_s_ = 0.0;
  std::optional<Mark> idle_begin_, idle_end_;
  std::vector<double> busy_s_;
  bool finished_ = false;
};

}  // namespace emberline
