// From the options of a study to its methods and budgets.
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
  std::string id;         // names its files: "adaptive-two-stream-display-sobol"
  RenderOptions options;  // but for the number of samples and the seed
  // Every budget is a frame of its own: drivers that show nothing before their end, samplers that
  // have to know the number of samples, --separate.
  bool separate = false;
  std::string impossible;  // why it cannot be, if it cannot
};

struct StudyPlan {
  std::vector<PlannedMethod> methods;
  bool by_time = false;
  std::vector<double> budgets;  // samples per pixel or seconds, ascending
  std::string baseline;         // a method's name
  std::string reference_sampler;
};

// Throws UsageError: an empty list or one with an unknown name or the same one twice, budgets that
// are not ascending, an unknown baseline. Combinations that make no sense are methods that are
// impossible; if all are, that is an error as well.
StudyPlan plan_study(const StudyOptions& options);

// The names of a list of samplers; throws as plan_study() does.
std::vector<std::string> parse_samplers(const std::string& list);

// 0 .. methods - 1 in the order in which a seed renders them: one of its own for each seed, so that
// no method always comes after the same other one, or when the machine has grown warm.
std::vector<size_t> study_order(size_t methods, uint32_t seed);

// The options of one frame of a method. `samples` is what a pixel gets, on average with adaptive
// sampling; rounded down to what the sampler can take.
RenderOptions frame_options(const PlannedMethod& method, uint32_t samples, uint32_t seed);

}  // namespace emberline
