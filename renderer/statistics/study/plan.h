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
  std::string id;         // part of its file names: "adaptive-two-stream-display-sobol"
  RenderOptions options;  // without the number of samples and the seed
  // Whether every budget is a separate frame: with drivers that show nothing before they finish,
  // samplers that must know the number of samples, and --separate.
  bool separate = false;
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
// or an unknown baseline. An invalid combination becomes a method with an `unsupported_reason`;
// plan_study() throws if all methods have one.
StudyPlan plan_study(const StudyOptions& options);

// Returns the names in a list of samplers; throws like plan_study().
std::vector<std::string> parse_samplers(const std::string& list);

// Shuffles the methods 0 .. methods - 1 by seed, so that no method always follows the same other
// one or always runs when the machine is warm.
std::vector<size_t> study_order(size_t methods, uint32_t seed);

// The options of one frame of a method. `samples` is the number of samples per pixel (with adaptive
// sampling, the average), which is rounded down to a number that the sampler supports.
RenderOptions frame_options(const PlannedMethod& method, uint32_t samples, uint32_t seed);

}  // namespace emberline
