#include "renderer/output/checkpoint_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "io/files/fingerprint.h"
#include "io/files/input_file.h"
#include "io/json/edits_file.h"
#include "io/json/input.h"
#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/core/shortened.h"
#include "renderer/core/version.h"
#include "renderer/engine/process_usage.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/report.h"
#include "renderer/scene/embree_isa.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

// Settings that do not affect the bits of a finished frame.
constexpr std::array<std::string_view, 6> kIgnoredSettings = {
    "time-limit", "bucket-order", "denoise", "half", "exr-compression", "exr-parts"};

// Compares the members of the object `part` in both heads. Calls `found` for each member whose
// value differs or that only one head has.
void compare(
    const Json& now, const Json& then, const char* part,
    const std::function<void(const std::string& name, const Json* now, const Json* then)>& found) {
  const auto part_of = [&](const Json& head) {
    const auto at = head.is_object() ? head.find(part) : head.end();
    return at != head.end() && at->is_object() ? *at : Json::object();
  };
  const Json a = part_of(now), b = part_of(then);
  for (const auto& [name, value] : a.items()) {
    const auto other = b.find(name);
    if (other == b.end()) {
      found(name, &value, nullptr);
    } else if (*other != value) {
      found(name, &value, &*other);
    }
  }
  for (const auto& [name, value] : b.items()) {
    if (!a.contains(name)) found(name, nullptr, &value);
  }
}

// Shortens the list, because a file that Emberline did not write may have thousands of differences.
void truncate_list(std::vector<std::string>& list) {
  constexpr size_t kMaxListed = 16;
  if (list.size() <= kMaxListed) return;
  list.resize(kMaxListed);
  list.push_back("and more");
}

std::string text_of(const Json* value) {
  if (!value) return "not given";
  if (value->is_string()) return shortened(value->get_ref<const std::string&>());
  return shortened(value->dump(-1, ' ', false, Json::error_handler_t::replace));
}

// Returns the names and paths of all input files except those of the scene itself. Checkpoints
// store these names, so every client must use the same names.
std::vector<std::pair<std::string, std::string>> named_inputs(const FrameSettings& settings,
                                                              const LoadProgress& progress) {
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&](std::string what, const std::string& path) {
    if (!path.empty()) files.emplace_back(std::move(what), path);
  };
  add(fmt::format("the file of --{}", "env"), settings.environment);
  add(plan_input_name(), settings.plan);
  add(fmt::format("the file of --{}", "edits"), settings.edits);
  if (settings.edits.empty()) return files;
  const SceneEdits edits = edits_from_json(read_json(settings.edits, progress), settings.edits);
  add(fmt::format("the environment of --{}", "edits"), edits.environment.file);
  return files;
}

}  // namespace

std::string plan_input_name() { return fmt::format("the file of --{}", "plan"); }

Json input_fingerprints(const FrameSettings& settings, LoadProgress& progress) {
  Json inputs = Json::object();
  inputs["the scene's files"] =
      hexadecimal(scene_fingerprint(settings.scene, settings.resource_root, progress));
  for (const auto& [what, path] : named_inputs(settings, progress)) {
    inputs[what] = hexadecimal(file_fingerprint(path, progress));
  }
  return inputs;
}

LoadedFiles::LoadedFiles(const FrameSettings& settings, const LoadProgress& progress) {
  for (const auto& [what, path] : named_inputs(settings, progress)) {
    const bool edits = path != settings.environment && path != settings.plan;
    std::vector<NamedFile>& list = edits ? edit_files_ : files_;
    if (auto file = stat_file(path)) list.push_back(*std::move(file));
  }
}

void LoadedFiles::add(const std::vector<NamedFile>& files) {
  files_.insert(files_.end(), files.begin(), files.end());
}

Json LoadedFiles::fingerprints(const FrameSettings& settings, LoadProgress& progress) const {
  check(settings);
  Json inputs = input_fingerprints(settings, progress);
  check(settings);
  return inputs;
}

void LoadedFiles::check(const FrameSettings& settings) const {
  const auto is_unchanged = [](const NamedFile& file) {
    const std::optional<NamedFile> now = stat_file(file.path);
    return now && now->identity == file.identity && now->state == file.state;
  };
  if (!std::ranges::all_of(files_, is_unchanged) ||
      (!settings.edits.empty() && !std::ranges::all_of(edit_files_, is_unchanged))) {
    throw InputError(settings.scene, "its files have changed since they were read; start again");
  }
}

Json checkpoint_head(const RenderOptions& options, const RenderPlan& plan,
                     const SceneLayers& layers, const Json& inputs) {
  Json head = {{"emberline", kEmberlineVersion}, {"bits", kBitsVersion}};
  Json& settings = head["settings"] = Json::object();
  Json& schedule = head["schedule"] = Json::object();
  for (const auto& [name, text] : setting_texts(with_recorded_defaults(options), {}, false)) {
    // The bucket order decides which buckets belong to a part, so it affects the part's bits.
    const bool affects_bits = std::ranges::find(kIgnoredSettings, name) == kIgnoredSettings.end() ||
                              (options.part && name == "bucket-order");
    if (name != "aov") (affects_bits ? settings : schedule)[name] = text;
  }
  put_scene_layers(layers, head);
  std::string channels;
  for (const NamedValue<Aov>& aov : aov_table()) {
    if (plan.aovs.contains(aov.value))
      channels += (channels.empty() ? "" : ",") + std::string(aov.name);
  }
  if (!channels.empty()) settings["aov"] = channels;
  // These options add data to the state of the adaptive driver.
  if (!options.trees.empty()) settings["tree"] = "yes";
  if (options.explained) {
    settings["explain"] = fmt::format("{},{}", options.explained->x, options.explained->y);
  }
  head["inputs"] = inputs;
  Json& files = head["files"] = Json::object();
  const auto name_file = [&](const char* setting, const std::string& path) {
    if (!path.empty()) files[setting] = std::filesystem::absolute(path).lexically_normal().string();
  };
  name_file("scene", options.scene);
  name_file("resource-root", options.resource_root);
  name_file("env", options.environment);
  name_file("edits", options.edits);
  name_file("plan", options.plan);
  head["machine"] = {{"host", host_name()},
                     {"instruction sets", instruction_sets()},
                     {"processor", processor_maker()},
                     {"embree", embree_version()}};
  return head;
}

FrameSettings settings_of(const Json& head, const std::string& place) {
  FrameSettings settings;
  for (const char* part : {"settings", "schedule"}) {
    const Json texts = head.is_object() ? head.value(part, Json::object()) : Json::object();
    if (!texts.is_object()) throw InputError(place, "its {} is not an object", part);
    for (const auto& [name, value] : texts.items()) {
      if (name == "tree" || name == "explain") continue;
      try {
        const Setting& setting = find_named(setting_table(), "checkpoint", "setting", name);
        if (!setting.file && value.is_string()) {
          setting.read(settings, value.get_ref<const std::string&>());
        }
      } catch (const UsageError& error) {
        throw InputError(place, error.what());
      }
    }
  }
  settings.plan = find_text(head, "files", "plan");  // the plan decides which driver is used
  return settings;
}

std::string find_text(const Json& head, const char* part, const char* name) {
  const auto object = head.is_object() ? head.find(part) : head.end();
  if (object == head.end() || !object->is_object()) return "";
  const auto text = object->find(name);
  return text != object->end() && text->is_string() ? text->get<std::string>() : "";
}

std::vector<std::string> differences(const Json& now, const Json& then,
                                     std::initializer_list<std::string_view> ignored) {
  std::vector<std::string> list;
  const Json bits = then.is_object() ? then.value("bits", Json()) : Json();
  if (bits != Json(kBitsVersion)) {
    const Json version = then.is_object() ? then.value("emberline", Json()) : Json();
    list.push_back(fmt::format("it was made by version {}, whose samples differ from those of {}",
                               text_of(&version), kEmberlineVersion));
  }
  compare(
      now, then, "settings", [&](const std::string& name, const Json* current, const Json* stored) {
        if (std::ranges::find(ignored, name) != ignored.end()) return;
        list.push_back(
            fmt::format("`{}`: {} (now {})", shortened(name), text_of(stored), text_of(current)));
      });
  compare(now, then, "inputs", [&](const std::string& name, const Json*, const Json*) {
    list.push_back(shortened(name) + " changed");
  });
  truncate_list(list);
  return list;
}

std::vector<std::string> machine_differences(const Json& now, const Json& then) {
  std::vector<std::string> list;
  compare(now, then, "machine",
          [&](const std::string& name, const Json* current, const Json* stored) {
            // The instruction set that Embree uses is a setting, so differences() compares it.
            // Emberline's own code computes the same bits with every instruction set.
            if (name == "host" || name == "instruction sets") return;
            list.push_back(
                fmt::format("{}: {} (now {})", shortened(name), text_of(stored), text_of(current)));
          });
  truncate_list(list);
  return list;
}

}  // namespace emberline
