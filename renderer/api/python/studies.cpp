// Studies of speed against error.
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

// A list, or a text with commas; None is the default.
std::string list_of(const py::object& value, const std::string& name) {
  return value.is_none() ? "" : setting_text(name, value);
}

std::optional<uint32_t> count_of(const py::object& value, const std::string& name) {
  const std::optional<int64_t> count = whole_number(value, name);
  if (!count) return std::nullopt;
  if (!std::in_range<uint32_t>(*count)) {
    throw api::UsageError(name + ": " + std::to_string(*count) + " is out of range");
  }
  return uint32_t(*count);
}

py::dict as_dict(const api::StudyRow& row) {
  py::dict all;
  all["method"] = text(row.method);
  all["driver"] = text(row.driver);
  all["sampler"] = text(row.sampler);
  all["estimator"] = text(row.estimator);
  all["allocation"] = text(row.allocation);
  all["unbiased"] = row.unbiased;
  all["denoised"] = row.denoised;
  all["seed"] = row.seed;
  all["failure"] = text(row.failure);
  all["budget"] = row.budget;
  all["samples"] = row.samples;
  all["mean_samples"] = row.mean_samples;
  all["wall_s"] = row.wall_s;
  all["cpu_s"] = row.cpu_s;
  all["estimate"] = row.estimate;
  for (const auto& [name, value] : row.errors) all[text(name)] = value;
  return all;
}

py::list study_rows(const api::StudyTable& table) {
  py::list rows;
  for (const api::StudyRow& row : table.rows) rows.append(as_dict(row));
  return rows;
}

api::StudyTable study(const py::object& scene, const py::object& folder,
                      const api::Settings* settings, const py::object& drivers,
                      const py::object& estimators, const py::object& samplers,
                      const py::object& budgets, const py::object& seconds, const py::object& seeds,
                      const std::string& baseline, bool denoised, bool separate,
                      const py::object& reference, const py::object& reference_spp,
                      const py::object& cache, bool restart, const py::object& threads,
                      const py::kwargs& options) {
  api::Settings all = settings ? *settings : api::Settings();
  apply(options, all);
  const std::string file = path_of(scene);
  const api::StudyRequest request{.folder = path_of(folder),
                                  .drivers = list_of(drivers, "drivers"),
                                  .estimators = list_of(estimators, "estimators"),
                                  .samplers = list_of(samplers, "samplers"),
                                  .spp = list_of(budgets, "budgets"),
                                  .seconds = list_of(seconds, "seconds"),
                                  .seeds = count_of(seeds, "seeds"),
                                  .baseline = baseline,
                                  .denoise = denoised,
                                  .separate = separate,
                                  .reference = reference.is_none() ? "" : path_of(reference),
                                  .reference_spp = count_of(reference_spp, "reference_spp"),
                                  .cache = cache.is_none() ? "" : path_of(cache),
                                  .restart = restart};
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  return result_of(
      [&](Call& call) { return api::study(file, all, request, resources, call.given_up()); });
}

}  // namespace

void add_studies(py::module_& module) {
  py::class_<api::StudyTable>(module, "StudyTable", "What study() found.")
      .def_property_readonly(
          "rows", &study_rows,
          "A dict for each method, seed and budget, with the names of study.csv: "
          "method, seed, budget, mean_samples, wall_s, cpu_s, mse, relmse ... "
          "Of a run that failed the one that says why in \"failure\".")
      .def_readonly("complete", &api::StudyTable::complete,
                    "False: it was stopped; the same call goes on.")
      .def_property_readonly(
          "text", [](const api::StudyTable& table) { return text(table.text); },
          "For people: each method's error, slope and speedup.");
  module.def(
      "study", &study, "scene"_a, "folder"_a, "settings"_a = nullptr, py::kw_only(),
      "drivers"_a = py::none(), "estimators"_a = py::none(), "samplers"_a = py::none(),
      "budgets"_a = py::none(), "seconds"_a = py::none(), "seeds"_a = py::none(), "baseline"_a = "",
      "denoised"_a = false, "separate"_a = false, "reference"_a = py::none(),
      "reference_spp"_a = py::none(), "cache"_a = py::none(), "restart"_a = false, "threads"_a = 0,
      "Speed against error: renders a scene's file by every method, seed and budget, and measures "
      "the pictures. drivers, estimators and samplers are lists; budgets are samples per pixel, or "
      "else seconds. Writes study.csv, study.json and study.html into the folder, in which a study "
      "that was stopped goes on. Settings and options are those of all frames.");
}

}  // namespace emberline::python
