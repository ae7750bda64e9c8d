#include "renderer/output/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "io/files/input_file.h"
#include "io/image/versions.h"
#include "renderer/core/log.h"
#include "renderer/core/setting_names.h"
#include "renderer/core/version.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/render_plan.h"
#include "renderer/engine/setting_table.h"
#include "renderer/scene/embree_isa.h"

namespace emberline {

using OrderedJson = nlohmann::ordered_json;

std::vector<std::pair<std::string, std::string>> library_versions() {
  std::vector<std::pair<std::string, std::string>> versions = {{"emberline", kEmberlineVersion},
                                                               {"embree", embree_version()}};
  for (auto& entry : io_library_versions()) versions.push_back(std::move(entry));
  return versions;
}

std::string instruction_sets() {
#if defined(__AVX512F__) && defined(__AVX512BW__) && defined(__AVX512CD__) && \
    defined(__AVX512DQ__) && defined(__AVX512VL__)
  const char* build_isa = "x86-64-v4";
#elif defined(__AVX2__) && defined(__FMA__) && defined(__BMI2__)
  const char* build_isa = "x86-64-v3";
#elif defined(__SSE4_2__)
  const char* build_isa = "x86-64-v2";
#elif defined(__x86_64__)
  const char* build_isa = "x86-64";
#elif defined(__aarch64__)
  const char* build_isa = "aarch64";
#else
  const char* build_isa = "unknown";
#endif
  return fmt::format("{}, Embree {}", build_isa, name_of(embree_isa_table(), widest_isa()));
}

std::string processor_maker() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  return __builtin_cpu_is("intel") ? "Intel" : __builtin_cpu_is("amd") ? "AMD" : "other";
#elif defined(__aarch64__)
  return "ARM";
#else
  return "other";
#endif
}

FrameSettings with_recorded_defaults(FrameSettings settings) {
  if (!settings.isa) settings.isa = widest_isa();
  if (samples_uniformly(settings)) return settings;
  if (settings.estimator.empty()) settings.estimator = kDefaultEstimator;
  if (!settings.allocation) settings.allocation = kDefaultAllocation;
  return settings;
}

std::vector<std::pair<std::string, std::string>> settings_attributes(const RenderOptions& o) {
  std::vector<std::pair<std::string, std::string>> list = {{"emberline:command", o.command_line},
                                                           {"emberline:scene", o.scene}};
  for (auto& [name, text] : setting_texts(with_recorded_defaults(o))) {
    std::ranges::replace(name, '-', '_');
    list.emplace_back("emberline:" + name, text);
  }
  list.emplace_back("emberline:instruction_sets", instruction_sets());
  for (const auto& [name, version] : library_versions()) {
    list.emplace_back("emberline:version:" + name, version);
  }
  return list;
}

std::string replay_arguments(const NonFiniteSample& sample, const FrameSettings& settings) {
  const std::string arguments = fmt::format("{},{},{}", sample.x, sample.y, sample.sample);
  if (sample.seed == sampling_seed(settings)) return arguments;
  // The sample's seed already includes the frame number. `static-noise` prevents the replay from
  // adding the number again.
  const std::string_view frame = sampling_seed(settings) == settings.seed ? "" : " `static-noise`";
  return arguments + spell_setting_names(fmt::format(" `seed` {}{}", sample.seed, frame));
}

void warn_about_non_finite(const RenderCounters& counters, const FrameSettings& settings,
                           const std::string& how) {
  if (counters.non_finite_samples == 0) return;
  log_warning(fmt::format(
      "{} samples were NaN or infinite and count as black; replay the first {} `replay` {}",
      counters.non_finite_samples, how, replay_arguments(counters.located.front(), settings)));
}

namespace {

OrderedJson number_or_null(const std::optional<double>& x) {
  return x ? OrderedJson(*x) : OrderedJson();
}

OrderedJson time_json(const RenderTimes& t) {
  return {{"start_s", number_or_null(t.start_s)},
          {"setup_s", t.setup_s},
          {"load_s", t.load_s},
          {"build_s", t.build_s},
          {"render_s", t.render_s},
          {"write_s", t.write_s},
          {"snapshots_s", t.snapshots_s},
          {"wall_s", t.wall_s},
          {"cpu_s", t.cpu_s},
          {"render_cpu_s", t.render_cpu_s},
          {"first_sample_s", number_or_null(t.first_sample_s)},
          {"first_sample_cpu_s", number_or_null(t.first_sample_cpu_s)}};
}

OrderedJson memory_json(const RenderReport& r) {
  return {{"peak_rss_bytes", peak_rss_bytes()},
          {"geometry_bytes", r.memory.geometry_bytes},
          {"bvh_bytes", r.memory.bvh_bytes},
          {"texture_bytes", r.memory.texture_bytes},
          {"texture_file_bytes", r.memory.texture_file_bytes},
          {"film_bytes", r.film_bytes},
          {"limit_bytes", r.budget->limit()},
          {"most_reserved_bytes", r.budget->peak()}};
}

OrderedJson numerics_json(const RenderReport& r, const FrameSettings& settings) {
  OrderedJson located = OrderedJson::array();
  for (const NonFiniteSample& s : r.counters.located) {
    located.push_back(
        {{"x", s.x},
         {"y", s.y},
         {"sample", s.sample},
         {"replay", spell_setting_names("`replay` ") + replay_arguments(s, settings)}});
  }
  return {{"non_finite_samples", r.counters.non_finite_samples},
          {"located", located},
          {"degenerate_triangles", r.repairs.degenerate_triangles},
          {"non_finite_triangles", r.repairs.non_finite_triangles},
          {"non_finite_attributes", r.repairs.non_finite_attributes},
          {"non_finite_texels", r.repairs.non_finite_texels},
          {"singular_instances", r.repairs.singular_instances},
          {"replaced_images", r.repairs.replaced_images}};
}

OrderedJson optics_json(const OpticsCounters& optics) {
  return {
      {"rays_ended_at_panes", optics.rays_ended_at_panes},
      {"solids_forgotten", optics.dropped_solids},
      {"light_samples_blocked_by_glass",
       optics.point_light_samples > 0 ? OrderedJson(optics.blocked_fraction()) : OrderedJson()}};
}

// Returns null if clamping was off.
OrderedJson clamped_json(const RenderReport& r) {
  const ClampedLight& clamped = r.counters.clamped;
  if (!clamped.clamps()) return OrderedJson();
  const auto mean = [](const Rgb& removed) { return OrderedJson{removed.x, removed.y, removed.z}; };
  const uint64_t samples = r.counters.samples;
  OrderedJson groups = OrderedJson::object();
  for (size_t i = 0; i < std::min(clamped.groups(), r.light_layers.size()); ++i) {
    groups[r.light_layers[i]] = mean(clamped.removed_of_group(i, samples));
  }
  return {{"limit", clamped.limit()},
          {"share", clamped.fraction()},
          {"mean", mean(clamped.removed(samples))},
          {"groups", groups}};
}

// Returns null if no mattes were requested.
OrderedJson cryptomattes_json(const RenderReport& r) {
  OrderedJson kinds;
  for (const CryptomatteReport& kind : r.cryptomattes) {
    kinds[std::string(name_of(cryptomatte_table(), kind.kind))] = {
        {"names", kind.names},
        {"dropped_pixels", kind.dropped_pixels},
        {"most_dropped", kind.max_dropped}};
  }
  return kinds;
}

// Returns null if the frame was not denoised.
OrderedJson denoise_json(const std::optional<DenoiseReport>& denoise) {
  if (!denoise) return OrderedJson();
  return {{"error_before", denoise->error_before},
          {"error_after", denoise->error_after},
          {"kept_share", denoise->unchanged_fraction},
          {"seconds", denoise->seconds}};
}

OrderedJson passes_json(const std::vector<PassReport>& passes) {
  OrderedJson list = OrderedJson::array();
  for (const PassReport& pass : passes) {
    list.push_back({{"elapsed_s", pass.elapsed_s},
                    {"samples", pass.samples},
                    {"error_estimate", number_or_null(pass.error_estimate)}});
  }
  return list;
}

OrderedJson forecast_json(const std::optional<ForecastReport>& forecast) {
  if (!forecast) return OrderedJson();
  return {{"after_s", forecast->after_s},
          {"render_s", forecast->seconds},
          {"render_s_least", forecast->least_s},
          {"render_s_most", forecast->most_s},
          {"samples_per_pixel", forecast->samples_per_pixel}};
}

OrderedJson snapshots_json(const std::vector<SnapshotReport>& snapshots) {
  OrderedJson list = OrderedJson::array();
  for (const SnapshotReport& s : snapshots) {
    list.push_back({{"completion", s.completion},
                    {"samples", s.samples},
                    {"elapsed_s", s.elapsed_s},
                    {"file", s.file.empty() ? OrderedJson() : OrderedJson(s.file)},
                    {"rmse", number_or_null(s.rmse)},
                    {"mse", number_or_null(s.mse)},
                    {"relmse", number_or_null(s.rel_mse)}});
  }
  return list;
}

OrderedJson settings_report(const RenderOptions& options, const RenderReport& r) {
  OrderedJson settings;
  for (const auto& [key, value] : settings_attributes(options)) {
    if (key.starts_with("emberline:version:")) continue;
    settings[key.substr(std::string("emberline:").size())] = value;
  }
  settings["size"] = {options.width, options.height};
  settings["window"] = {r.crop.x0, r.crop.y0, r.crop.x1, r.crop.y1};
  settings["camera"] = r.camera;
  settings["threads"] = r.threads;
  settings["bucket_size"] = options.bucket_size;
  settings["display"] = r.display;
  if (!options.snapshots.empty()) settings["snapshots"] = options.snapshots;
  if (!options.reference.empty()) settings["reference"] = options.reference;
  settings["time_limit_s"] = number_or_null(options.time_limit_s);
  settings["time_budget_s"] = number_or_null(options.time_budget_s);
  return settings;
}

OrderedJson checkpoint_json(const RenderReport& r) {
  const CheckpointReport& checkpoint = r.checkpoint;
  if (checkpoint.file.empty()) return OrderedJson();
  return {{"file", checkpoint.file},
          {"kept", checkpoint.kept},
          {"written", checkpoint.written},
          {"bytes", checkpoint.bytes},
          {"paused_s", checkpoint.paused_s},
          {"longest_pause_s", checkpoint.longest_pause_s},
          {"earlier_samples", r.resumed_samples}};
}

OrderedJson stop_cause_json(const RenderReport& r) {
  if (!r.counters.stopped) return OrderedJson();
  return r.stop_cause == PixelStop::kTimeLimit ? "time limit" : "user";
}

}  // namespace

std::string report_json(const RenderOptions& options, const RenderReport& r) {
  const RenderCounters& c = r.counters;
  const double pixels = double(r.crop.area());
  OrderedJson json;
  json["time"] = time_json(r.times);
  json["samples"] = {{"total", c.samples},
                     {"min", c.min_samples},
                     {"mean", pixels > 0 ? double(c.samples) / pixels : 0.0},
                     {"max", c.max_samples},
                     {"pixels_without", r.unsampled_pixels}};
  json["rays"] = {{"camera", c.rays.camera},
                  {"scatter", c.rays.scatter},
                  {"shadow", c.rays.shadow},
                  {"total", c.rays.total()}};
  json["memory"] = memory_json(r);
  json["numerics"] = numerics_json(r, options);
  json["optics"] = optics_json(c.optics);
  json["clamped"] = clamped_json(r);
  json["cryptomattes"] = cryptomattes_json(r);
  // Uniform sampling has no error estimate.
  json["error"] = {
      {"estimator", r.estimator}, {"of", "raw"}, {"estimate", number_or_null(r.error_estimate)}};
  json["forecast"] = forecast_json(r.forecast);
  json["denoise"] = denoise_json(r.denoise);
  json["warnings"] = r.warnings;
  json["features"] = r.features;
  json["gltf"] = {{"used", r.coverage.used},
                  {"approximated", r.coverage.approximated},
                  {"ignored", r.coverage.ignored}};
  json["passes"] = passes_json(r.passes);
  json["snapshots"] = snapshots_json(r.snapshots);
  json["checkpoint"] = checkpoint_json(r);
  for (const PartReport& part : r.parts) {
    json["parts"].push_back(
        {{"file", part.file}, {"host", part.host}, {"instruction_sets", part.instruction_sets}});
  }
  json["settings"] = settings_report(options, r);
  json["machine"] = {{"host", host_name()}, {"instruction_sets", instruction_sets()}};
  for (const auto& [name, version] : library_versions()) json["versions"][name] = version;
  json["output"] = options.outputs;
  json["heatmaps"] = options.heatmaps;
  json["failed_outputs"] = r.failed_outputs;
  json["stopped"] = c.stopped;
  json["complete"] = r.complete;
  json["stop_cause"] = stop_cause_json(r);
  json["exit_code"] = r.exit_code;
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace emberline
