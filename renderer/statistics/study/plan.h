// Turns the options of a study into methods and budgets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/statistics/study/options.h"
#include "renderer/statistics/study_results.h"

namespace emberline {

struct PlannedMethod {
  StudyMethod method;
  std::string id;         // used in file names: "adaptive-two-stream-display-sobol"
  RenderOptions options;  // frame_options() sets the number of samples and the seed
  // Whether a separate frame is rendered for every budget. True with --separate, with denoising,
  // for drivers that show nothing before they finish, and for samplers that must know the number of
  // samples in advance.
  bool separate = false;
  // Whether a budget in seconds is the `time-budget` of the frame. True for separate frames, unless
  // a plan or the sampler needs the number of samples in advance.
  bool has_time_budget = false;
  std::string unsupported_reason;  // why the method cannot be rendered; empty if it can
};

struct StudyPlan {
  std::vector<PlannedMethod> methods;
  bool by_time = false;
  std::vector<double> budgets;  // samples per pixel or seconds, ascending
  std::string baseline;         // name of a method
  std::string reference_sampler;
};

// Throws UsageError for an empty list, unknown or repeated names, budgets that are not ascending,
// or an unknown baseline. A method that cannot be rendered at every budget gets an
// `unsupported_reason`. If all methods have such a reason, throws UsageError.
StudyPlan plan_study(const StudyOptions& options);

// Returns the names in a list of samplers. Throws what plan_study() throws.
std::vector<std::string> parse_samplers(const std::string& list);

// Returns the methods 0 .. methods - 1 in a random order that depends on the seed. The order varies
// so that no method always follows the same one, or always runs when the machine is warm.
std::vector<size_t> study_order(size_t methods, uint32_t seed);

// Returns the options of one frame of a method. `samples` is the number of samples per pixel (the
// average, with adaptive sampling); it is rounded down to a number that the sampler supports.
RenderOptions frame_options(const PlannedMethod& method, uint32_t samples, uint32_t seed);

// Returns the options of one frame of a method that plans its samples for the given time.
RenderOptions deadline_options(const PlannedMethod& method, double seconds, uint32_t seed);

}  // namespace emberline
