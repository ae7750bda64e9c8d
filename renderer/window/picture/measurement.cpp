#include "renderer/window/picture/measurement.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/window/panels/edit_entries.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

// For the built-in script: the number of edits of each kind, and the time between edits, as if an
// artist looked at each result.
constexpr int kEditsOfEachKind = 25;
constexpr double kEditInterval_s = 0.25;
constexpr double kWarmUp_s = 1.0;
// After the last edit, its picture gets kSettling_s to settle. Then the render speed is measured
// for kIdle_s, or longer if no picture arrives in that time, but at most for kMaxIdle_s.
constexpr double kSettling_s = 2.0, kIdle_s = 6.0, kMaxIdle_s = 60.0;
// A script may last a day at most.
constexpr double kMaxScript_s = 86400.0;

Json milliseconds(std::vector<double> seconds) {
  const auto ms = [&](double q) { return 1e3 * quantile(seconds, q); };
  if (seconds.empty()) return nullptr;
  return {{"count", seconds.size()}, {"median", ms(0.5)}, {"p95", ms(0.95)}, {"most", ms(1.0)}};
}

struct Latencies {
  std::vector<double> filled, complete;
  size_t undisplayed = 0;

  void add(const MeasuredEdit& edit) {
    if (edit.filled_s) filled.push_back(*edit.filled_s - edit.input_s);
    if (edit.complete_s) complete.push_back(*edit.complete_s - edit.input_s);
    undisplayed += !edit.filled_s;
  }
  Json summary() const {
    return {{"first_picture_ms", milliseconds(filled)},
            {"every_pixel_ms", milliseconds(complete)},
            {"never_shown", undisplayed}};
  }
};

// Returns the kind of edit by which latencies are grouped: "light" for "light 0 2".
std::string kind_of(const std::string& what) {
  if (what == "camera") return "orbit";
  return what.substr(0, what.find(' '));
}

}  // namespace

Measurement::Measurement(const ViewOptions& options, Workbench& bench)
    : file_(options.measure), scene_(options.render.scene), bench_(bench) {
  if (options.measure_script.empty()) return;
  scripted_ = true;
  const Json json = read_json(options.measure_script);
  const JsonReader script(json, options.measure_script);
  for (size_t i = 0; i < script.size(); ++i) {
    const JsonReader step = script[i].object({"at_s", "edit"});
    step["edit"].members();  // checks that the edit is an object; its members are checked when it
                             // is due
    steps_.push_back({step["at_s"].number(0.0, kMaxScript_s), JsonValue(json[i]["edit"])});
  }
  std::ranges::stable_sort(steps_, {}, &Step::at_s);
}

std::vector<Measurement::Step> Measurement::built_in_script() const {
  const SceneDescription& outline = bench_.session.scene()->outline;
  const auto lights = int(list_lights(outline, bench_.session.edits()).size());
  std::vector<Step> steps;
  double at = kWarmUp_s;
  const auto add = [&](Json edit) {
    steps.push_back({at, JsonValue(std::move(edit))});
    at += kEditInterval_s;
  };
  for (int i = 0; i < kEditsOfEachKind; ++i) {
    const double wave = double(i % 5) / 4.0;
    add({{"orbit", {i % 2 ? -30.0 : 34.0, 6.0 * (wave - 0.5)}}});
    if (lights > 0) add({{"light", i % lights}, {"intensity", 0.5 + wave + 0.01 * i}});
    if (!outline.materials.empty()) {
      add({{"material", i % int(outline.materials.size())}, {"roughness", 0.1 + 0.03 * i}});
    }
    if (outline.environment) add({{"environment_rotation", 7.0 * i + 1.0}});
  }
  return steps;
}

void Measurement::apply_edit(const Json& edit) {
  const auto number = [&](const char* name) { return edit.at(name).get<double>(); };
  const SceneDescription& outline = bench_.session.scene()->outline;
  const SceneEdits& edits = bench_.session.edits();
  if (edit.contains("orbit")) {
    const Json& delta = edit["orbit"];
    return bench_.navigator.drag(Drag::kOrbit,
                                 Vec2f(delta.at(0).get<float>(), delta.at(1).get<float>()));
  }
  if (edit.contains("exposure")) {
    ViewSettings settings = bench_.session.settings();
    settings.display.exposure = float(number("exposure"));
    return bench_.settings.change(settings);
  }
  if (edit.contains("environment_rotation")) {
    SceneEdits rotated = edits;
    rotated.environment.rotation_degrees = float(number("environment_rotation"));
    return bench_.edits.change(rotated, "environment rotation");
  }
  if (edit.contains("light")) {
    const std::vector<ListedLight> lights = list_lights(outline, edits);
    const ListedLight& light = lights.at(edit["light"].get<size_t>());
    LightEdit entry = light_edit(edits, outline, light.kind, light.index);
    entry.intensity = float(number("intensity"));
    return bench_.edits.change(entry, "light");
  }
  if (edit.contains("material")) {
    MaterialEdit entry = material_edit(edits, outline, edit["material"].get<int>());
    if (edit.contains("roughness")) entry.roughness = float(number("roughness"));
    if (edit.contains("metallic")) entry.metallic = float(number("metallic"));
    return bench_.edits.change(entry, "material");
  }
  throw InputError(
      "edit",
      "expected orbit, exposure, environment_rotation, light or material, not " + edit.dump());
}

Measurement::Mark Measurement::mark(double now_s) const {
  const SessionPicture& picture = *bench_.picture();
  return {now_s, picture.samples, picture.rays};
}

void Measurement::step(double now_s) {
  now_s_ = now_s;
  if (bench_.load_status().state == LoadStatus::State::kFailed) finished_ = true;
  if (!bench_.session.scene() || !bench_.picture() || finished_) return;
  if (first_picture_s_ < 0.0) {
    if (!bench_.picture()->complete) return;
    first_picture_s_ = last_edit_s_ = now_s;
    busy_s_.clear();
    first_edit_ = bench_.latency.edits().size();
    if (!scripted_) steps_ = built_in_script();
  }
  while (next_step_ < steps_.size() && now_s >= first_picture_s_ + steps_[next_step_].at_s) {
    const size_t number = next_step_++;
    last_edit_s_ = now_s;
    try {
      apply_edit(*steps_[number].edit);
    } catch (const std::exception& error) {
      bench_.messages.error("script, step " + std::to_string(number) + ": " + error.what());
    }
  }
  if (next_step_ < steps_.size() || now_s < last_edit_s_ + kSettling_s) return;
  if (!idle_begin_) idle_begin_ = mark(now_s);
  // Without another picture the measured speed would be 0.
  const bool has_new_picture = bench_.picture()->samples > idle_begin_->samples;
  const double end_s = idle_begin_->time_s + (has_new_picture ? kIdle_s : kMaxIdle_s);
  if (now_s < end_s && !bench_.picture()->finished) return;
  idle_end_ = mark(now_s);
  finished_ = true;
}

double Measurement::next_s() const {
  if (first_picture_s_ < 0.0) return now_s_ + 0.01;
  if (next_step_ < steps_.size()) return first_picture_s_ + steps_[next_step_].at_s;
  if (!idle_begin_) return last_edit_s_ + kSettling_s;
  const double end_s = idle_begin_->time_s + kIdle_s;
  return end_s > now_s_ ? end_s : now_s_ + 0.1;
}

void Measurement::record_busy(double seconds) { busy_s_.push_back(seconds); }

void Measurement::write() const {
  Latencies all;
  std::map<std::string, Latencies> by_kind;
  Json edits = Json::array();
  for (const MeasuredEdit& edit : bench_.latency.edits().subspan(first_edit_)) {
    all.add(edit);
    by_kind[kind_of(edit.what)].add(edit);
    const auto ms = [&](const std::optional<double>& time) {
      return time ? Json(1e3 * (*time - edit.input_s)) : Json();
    };
    edits.push_back({{"what", edit.what},
                     {"at_s", edit.input_s - first_picture_s_},
                     {"first_picture_ms", ms(edit.filled_s)},
                     {"every_pixel_ms", ms(edit.complete_s)}});
  }
  Json kinds = Json::object();
  for (const auto& [kind, latencies] : by_kind) kinds[kind] = latencies.summary();
  Json idle;
  if (idle_begin_ && idle_end_ && idle_end_->time_s > idle_begin_->time_s) {
    const double seconds = idle_end_->time_s - idle_begin_->time_s;
    idle = {{"seconds", seconds},
            {"samples_per_s", double(idle_end_->samples - idle_begin_->samples) / seconds},
            {"rays_per_s", double(idle_end_->rays - idle_begin_->rays) / seconds}};
  }
  const RenderOptions& options = bench_.session.settings().render;
  const Json report = {{"scene", scene_},
                       {"driver", options.driver},
                       {"size", {options.width, options.height}},
                       {"complete", first_picture_s_ >= 0.0 && next_step_ == steps_.size()},
                       {"first_picture_s", first_picture_s_},
                       {"edits_ms", all.summary()},
                       {"by_kind", kinds},
                       {"window_busy_ms", milliseconds(busy_s_)},
                       {"idle", idle},
                       {"edits", edits}};
  bench_.files.check_output("`measure`", file_);
  write_file_atomically(file_, report.dump(2) + "\n");
}

}  // namespace emberline
