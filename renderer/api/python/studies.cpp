// Studies of speed against error.
#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "renderer/api/python/module.h"

namespace emberline::python {
namespace {

// The options of a study. All other arguments are frame settings.
constexpr std::string_view kOptions[] = {
    "drivers", "estimators", "samplers",  "spp",           "seconds", "seeds",  "baseline",
    "denoise", "separate",   "reference", "reference-spp", "cache",   "restart"};

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
                      const api::Settings* settings, const py::object& threads,
                      const py::kwargs& options) {
  const std::string file = path_of(scene);
  api::StudyRequest request(path_of(folder));
  api::Settings all = settings ? *settings : api::Settings();
  for (const auto& [key, value] : options) {
    const std::string name = setting_name(py::cast<std::string>(key));
    const bool is_study_option = std::ranges::find(kOptions, name) != std::end(kOptions);
    if (is_study_option && value.is_none()) continue;  // keep the default
    const std::string text = setting_text(name, value);
    is_study_option ? void(request.set(name, text)) : void(all.set(name, text));
  }
  const api::Resources resources = resources_of(threads, py::none(), py::none());
  return run_call_for_result(
      [&](Call& call) { return api::study(file, all, request, resources, call.cancellation()); });
}

}  // namespace

void add_studies(py::module_& module) {
  py::class_<api::StudyTable>(module, "StudyTable", "The result of study().")
      .def_property_readonly(
          "rows", &study_rows,
          "A dict for each method, seed and budget, with the columns of study.csv as keys: method, "
          "seed, budget, mean_samples, wall_s, cpu_s, mse, relmse ... A failed run has one dict "
          "with the reason in \"failure\".")
      .def_readonly("complete", &api::StudyTable::complete,
                    "False if the study was stopped; the same call continues it.")
      .def_property_readonly(
          "text", [](const api::StudyTable& table) { return text(table.text); },
          "A readable table of each method's error, slope and speedup.");
  module.def(
      "study", &study, "scene"_a, "folder"_a, "settings"_a = nullptr, py::kw_only(),
      "threads"_a = 0,
      "Measures speed against error: renders a scene's file with every method, seed and budget, "
      "and compares the pictures with a reference. drivers, estimators and samplers are lists; "
      "budgets are spp (samples per pixel) or seconds; seeds is the number of runs; denoise=True "
      "also measures each method with denoising; reference is the file of a picture; without it, "
      "study() renders a reference with reference_spp samples per pixel and keeps it in `cache`. "
      "Writes study.csv, study.json and study.html into the folder. The same call continues a "
      "stopped study; restart=True starts over. Settings and other options apply to all frames.");
}

}  // namespace emberline::python
