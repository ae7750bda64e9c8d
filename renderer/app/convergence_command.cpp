#include "renderer/app/commands.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "io/files/atomic_file.h"
#include "renderer/app/standard_output.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/statistics/convergence.h"
#include "renderer/statistics/study/folder.h"
#include "renderer/statistics/study/plan.h"

namespace emberline {
namespace {

// With this number of pixels, the convergence order is measured to within 0.1, as in the samplers'
// tests.
constexpr uint32_t kDefaultPixels = 2000;

constexpr const char* kCsv = "convergence.csv";
constexpr const char* kJson = "convergence.json";

using Curves = std::vector<ConvergenceCurve>;

std::string table(const Curves& curves) {
  std::string text =
      fmt::format("{:<14}{:<20}{:>8}{:>10}", "sampler", "integrand", "order", "expected");
  const auto out = std::back_inserter(text);
  const std::vector<uint32_t>& counts = curves.front().counts;
  const size_t column_indices[] = {0, counts.size() / 2, counts.size() - 1};
  for (const size_t n : column_indices) {
    fmt::format_to(out, "{:>14}", fmt::format("at N = {}", counts[n]));
  }
  text += "\n";
  for (const ConvergenceCurve& curve : curves) {
    fmt::format_to(out, "{:<14}{:<20}{:>8.2f}{:>10}", curve.sampler, curve.integrand, curve.order,
                   curve.expected ? fmt::format("{:.2f}", *curve.expected) : "-");
    for (const size_t n : column_indices) fmt::format_to(out, "{:>14.3e}", curve.variance[n]);
    text += "\n";
  }
  return text;
}

std::string csv(const Curves& curves) {
  std::string text = "sampler,integrand,samples,variance,order,expected_order\n";
  for (const ConvergenceCurve& c : curves) {
    for (size_t n = 0; n < c.counts.size(); ++n) {
      fmt::format_to(std::back_inserter(text), "{},\"{}\",{},{},{},{}\n", c.sampler, c.integrand,
                     c.counts[n], c.variance[n], c.order,
                     c.expected ? fmt::format("{}", *c.expected) : "");
    }
  }
  return text;
}

std::string json(const Curves& curves, uint32_t pixels, uint32_t seed) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const ConvergenceCurve& c : curves) {
    list.push_back({{"sampler", c.sampler},
                    {"integrand", c.integrand},
                    {"samples", c.counts},
                    {"variance", c.variance},
                    {"order", c.order},
                    {"expected_order", nullptr}});
    if (c.expected) list.back()["expected_order"] = *c.expected;
  }
  return nlohmann::ordered_json{{"pixels", pixels}, {"seed", seed}, {"curves", list}}.dump(1) +
         "\n";
}

}  // namespace

int run_convergence(const StudyOptions& options) {
  std::vector<std::string> samplers;
  if (options.samplers) {
    samplers = parse_samplers(*options.samplers);
  } else {
    for (const SamplerEntry& entry : sampler_table()) samplers.emplace_back(entry.name);
  }
  std::optional<OwnedFolder> folder;
  if (!options.folder.empty()) {
    folder.emplace(options.folder, study_folder_kind());
    folder->claim(std::vector<std::string>{kCsv, kJson});
  }
  const uint32_t pixels = options.seeds.value_or(kDefaultPixels), seed = options.frame.seed;
  Curves curves;
  for (const std::string& sampler : samplers) {
    log_info("measuring " + sampler);
    for (ConvergenceCurve& curve : convergence_curves(sampler, pixels, seed)) {
      curves.push_back(std::move(curve));
    }
  }
  if (folder) {
    write_file_atomically(folder->path(kCsv), csv(curves));
    write_file_atomically(folder->path(kJson), json(curves, pixels, seed));
  }
  print_result("variance of the mean of N samples, proportional to N^-order\n\n" + table(curves));
  return kExitDone;
}

}  // namespace emberline
