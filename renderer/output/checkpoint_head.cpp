#include "renderer/output/checkpoint_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <nlohmann/json.hpp>

#include "io/fingerprint.h"
#include "renderer/core/version.h"
#include "renderer/drivers/setting_table.h"
#include "renderer/output/report.h"
#include "renderer/process/process_usage.h"
#include "renderer/scene/embree_version.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;

// Settings that decide no bits of a frame that is finished.
constexpr std::array<std::string_view, 3> kFree = {"time-limit", "bucket-order", "aov"};

// Members of one object that the other has not, or has otherwise.
void compare(const Json& now, const Json& then, const char* part,
             const std::function<void(const std::string& name, const Json* now, const Json* then)>&
                 found) {
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

std::string text_of(const Json* value) {
  if (!value) return "not given";
  if (value->is_string()) return value->get<std::string>();
  return value->dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Json checkpoint_head(const RenderOptions& options, const FramePlan& plan, LoadProgress& progress) {
  Json head = {{"emberline", kEmberlineVersion}, {"bits", kBitsVersion}};
  Json& settings = head["settings"] = Json::object();
  FrameSettings used = options;
  if (!plan.even) {
    used.estimator = plan.driver_settings.adaptive.estimator;
    if (!used.allocation) used.allocation = kDefaultAllocation;
  }
  for (const auto& [name, text] : setting_texts(used, {}, false)) {
    if (std::ranges::find(kFree, name) == kFree.end()) settings[name] = text;
  }
  std::string channels;
  for (const NamedValue<Aov>& aov : aov_table()) {
    if (plan.aovs.contains(aov.value)) channels += (channels.empty() ? "" : ",") + std::string(aov.name);
  }
  if (!channels.empty()) settings["aov"] = channels;
  // The state of the adaptive driver holds more with these.
  if (!options.trees.empty()) settings["tree"] = "yes";
  if (options.explained) {
    settings["explain"] = fmt::format("{},{}", options.explained->x, options.explained->y);
  }
  Json& inputs = head["inputs"] = Json::object();
  inputs["the scene's files"] =
      hexadecimal(scene_fingerprint(options.scene, options.resource_root, progress));
  if (!options.environment.empty()) {
    inputs["the file of --env"] = hexadecimal(file_fingerprint(options.environment, progress));
  }
  if (!options.edits.empty()) {
    inputs["the file of --edits"] = hexadecimal(file_fingerprint(options.edits, progress));
  }
  head["machine"] = {{"host", host_name()},
                     {"instruction sets", instruction_sets()},
                     {"embree", embree_version()}};
  return head;
}

std::vector<std::string> differences(const Json& now, const Json& then) {
  std::vector<std::string> list;
  const Json bits = then.is_object() ? then.value("bits", Json()) : Json();
  if (bits != Json(kBitsVersion)) {
    const Json version = then.is_object() ? then.value("emberline", Json()) : Json();
    list.push_back(fmt::format("it was made by version {}, whose samples are other bits than those "
                               "of {}",
                               text_of(&version), kEmberlineVersion));
  }
  compare(now, then, "settings", [&](const std::string& name, const Json* here, const Json* there) {
    list.push_back(fmt::format("--{}: {} (now {})", name, text_of(there), text_of(here)));
  });
  compare(now, then, "inputs", [&](const std::string& name, const Json*, const Json*) {
    list.push_back(name + " have changed");
  });
  return list;
}

std::vector<std::string> machine_differences(const Json& now, const Json& then) {
  std::vector<std::string> list;
  compare(now, then, "machine", [&](const std::string& name, const Json* here, const Json* there) {
    if (name != "host") list.push_back(fmt::format("{}: {} (now {})", name, text_of(there), text_of(here)));
  });
  return list;
}

}  // namespace emberline
