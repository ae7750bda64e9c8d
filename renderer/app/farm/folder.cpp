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
constexpr uint64_t kVersion = 1, kMostParts = 65536, kMostJob = UINT32_MAX;

template <typename T>
nlohmann::ordered_json value_or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

template <typename T>
std::optional<T> optional_whole(const JsonReader& json, uint64_t most) {
  return json.null() ? std::nullopt : std::optional(T(json.whole(1, most)));
}

}  // namespace

std::string frame_file(std::string name) {
  for (size_t begin = name.find("####"); begin != std::string::npos;
       begin = name.find("####", begin)) {
    for (; begin < name.size() && name[begin] == '#'; ++begin) name[begin] = '0';
  }
  return name;
}

FarmFolder::FarmFolder(const std::string& name) {
  std::string given = fs::absolute(name).string();
  while (given.size() > 1 && given.ends_with('/')) given.pop_back();
  const bool itself = given.ends_with(kSuffix) && fs::is_directory(given);
  if (itself) given.resize(given.size() - kSuffix.size());
  path = given + std::string(kSuffix);
  output = frame_file(given);
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
                                 {"arrays", record.arrays},
                                 {"merge", value_or_null(record.merge)}};
  return json.dump(2) + "\n";
}

FarmRecord read_record(const FarmFolder& folder) {
  const std::string file = folder.file("job.json");
  const nlohmann::json document = read_json(file);
  const JsonReader json(document, file);
  json["emberline_farm"].whole(kVersion, kVersion);
  FarmRecord record;
  record.scene = json["scene"].text();
  record.parts = uint32_t(json["parts"].whole(1, kMostParts));
  record.request.partition = json["partition"].text();
  if (!is_partition(record.request.partition)) json["partition"].expected("names of partitions");
  record.request.cpus = optional_whole<int>(json["cpus"], 4096);
  record.request.memory_bytes = optional_whole<uint64_t>(json["memory_bytes"], uint64_t(1) << 63);
  record.request.minutes = optional_whole<int>(json["minutes"], 10000000);
  const JsonReader arrays = json["arrays"];
  if (arrays.size() > 10000) arrays.expected("at most 10000 jobs");
  for (size_t i = 0; i < arrays.size(); ++i) record.arrays.push_back(arrays[i].whole(1, kMostJob));
  record.merge = optional_whole<uint64_t>(json["merge"], kMostJob);
  return record;
}

}  // namespace emberline
