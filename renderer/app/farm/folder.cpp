#include "renderer/app/farm/folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/output/render_options.h"

namespace emberline {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".farm";
constexpr uint64_t kVersion = 1, kMaxParts = 65536, kMaxJob = UINT32_MAX;

template <typename T>
nlohmann::ordered_json value_or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

template <typename T>
std::optional<T> read_optional_integer(const JsonReader& json, uint64_t maximum) {
  return json.is_null() ? std::nullopt : std::optional(T(json.whole_number(1, maximum)));
}

}  // namespace

std::string expand_frame_zero(std::string name) {
  for (size_t begin = name.find("####"); begin != std::string::npos;
       begin = name.find("####", begin)) {
    for (; begin < name.size() && name[begin] == '#'; ++begin) name[begin] = '0';
  }
  return name;
}

FarmFolder::FarmFolder(const std::string& name) {
  std::string absolute_path = fs::absolute(name).string();
  while (absolute_path.size() > 1 && absolute_path.ends_with('/')) absolute_path.pop_back();
  const bool is_farm_folder = absolute_path.ends_with(kSuffix) && fs::is_directory(absolute_path);
  if (is_farm_folder) absolute_path.resize(absolute_path.size() - kSuffix.size());
  path = absolute_path + std::string(kSuffix);
  output = expand_frame_zero(absolute_path);
}

std::string FarmFolder::progress(uint32_t part) const {
  return file(fmt::format("progress/part-{}.json", part));
}

std::string FarmFolder::checkpoint(uint32_t part, uint32_t parts) const {
  RenderOptions options;
  options.outputs = {output};
  options.part = FramePart{part, parts};
  return checkpoint_path(options);
}

std::vector<uint64_t> FarmRecord::jobs() const {
  std::vector<uint64_t> jobs = arrays;
  if (plan) jobs.push_back(*plan);
  if (merge) jobs.push_back(*merge);
  return jobs;
}

std::string record_json(const FarmRecord& record) {
  nlohmann::ordered_json json = {{"emberline_farm", kVersion},
                                 {"scene", record.scene},
                                 {"parts", record.parts},
                                 {"partition", record.request.partition},
                                 {"cpus", value_or_null(record.request.cpus)},
                                 {"memory_bytes", value_or_null(record.request.memory_bytes)},
                                 {"minutes", value_or_null(record.request.minutes)},
                                 {"planned", record.makes_plan},
                                 {"plan", value_or_null(record.plan)},
                                 {"arrays", record.arrays},
                                 {"merge", value_or_null(record.merge)}};
  return json.dump(2) + "\n";
}

FarmRecord read_record(const FarmFolder& folder) {
  const std::string file = folder.file("job.json");
  const nlohmann::json document = read_json(file);
  const JsonReader json(document, file);
  json["emberline_farm"].whole_number(kVersion, kVersion);
  FarmRecord record;
  record.scene = json["scene"].text();
  record.parts = uint32_t(json["parts"].whole_number(1, kMaxParts));
  record.request.partition = json["partition"].text();
  if (!is_partition(record.request.partition))
    json["partition"].throw_expected("names of partitions");
  record.request.cpus = read_optional_integer<int>(json["cpus"], 4096);
  record.request.memory_bytes =
      read_optional_integer<uint64_t>(json["memory_bytes"], uint64_t(1) << 63);
  record.request.minutes = read_optional_integer<int>(json["minutes"], 10000000);
  // Records of version 1.0 lack these members.
  if (json.has("planned")) {
    record.makes_plan = json["planned"].boolean();
    record.plan = read_optional_integer<uint64_t>(json["plan"], kMaxJob);
  }
  const JsonReader arrays = json["arrays"];
  if (arrays.size() > 10000) arrays.throw_expected("at most 10000 jobs");
  for (size_t i = 0; i < arrays.size(); ++i)
    record.arrays.push_back(arrays[i].whole_number(1, kMaxJob));
  record.merge = read_optional_integer<uint64_t>(json["merge"], kMaxJob);
  return record;
}

}  // namespace emberline
