#include "renderer/app/farm/status.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "io/files/input_file.h"
#include "io/json/input.h"
#include "io/json/reader.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/core/utf8.h"
#include "renderer/output/frame_merge.h"

namespace emberline {
namespace {

using Json = nlohmann::ordered_json;
using enum PartState;

constexpr std::string_view kStates[] = {"waiting", "running", "done",
                                        "stopped", "failed",  "unknown"};

std::string_view state_name(PartState state) { return kStates[size_t(state)]; }

// Returns the last line of the file that is not empty, from its last 4 KiB.
std::string last_line(const std::string& path) {
  try {
    const auto file = InputFile::try_open(path);
    if (!file) return "";
    const uint64_t count = std::min<uint64_t>(4096, file->size());
    std::string text(count, '\0');
    file->read(file->size() - count, count, text.data());
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return printable(text.substr(text.rfind('\n') + 1));
  } catch (const InputError&) {
    return "";
  }
}

// Reads a progress file into `status`. Returns false if the file is missing or invalid.
bool read_progress(const std::string& path, PartStatus& status) {
  constexpr double kMaxSeconds = 1e12;
  try {
    if (!InputFile::try_open(path)) return false;
    const nlohmann::json document = read_json(path);
    const JsonReader json(document, path);
    PartStatus read = status;
    const std::string state = json["state"].text();
    const auto* const named = std::ranges::find(kStates, state);
    if (named == std::end(kStates))
      json["state"].throw_expected("running, done, stopped or failed");
    read.state = PartState(named - kStates);
    read.done = json["done"].number(0, 1);
    read.samples = json["samples"].whole_number(0, UINT64_MAX);
    read.elapsed_s = json["elapsed_s"].number(0, kMaxSeconds);
    if (!json["left_s"].is_null()) read.left_s = json["left_s"].number(0, kMaxSeconds);
    read.node = printable(json["host"].text());
    status = read;
    return true;
  } catch (const InputError& error) {
    log_warning(error.what());
    return false;
  }
}

// Returns the finished fraction of a part without a progress file.
double checkpoint_fraction(const std::string& path) {
  try {
    return InputFile::try_open(path) ? StoredFrame(path).completed_fraction() : 0.0;
  } catch (const InputError&) {
    return 0.0;
  }
}

// Slurm's tasks, keyed by "JOB_TASK" or "JOB".
struct Queue {
  bool known = false;
  std::map<std::string, SlurmTask> tasks;
  std::map<std::string, std::string> ended;

  explicit Queue(const FarmRecord& record) {
    const std::vector<uint64_t> jobs = record.jobs();
    if (jobs.empty()) return;
    const auto queued = queued_tasks(jobs);
    known = queued.has_value();
    if (!queued) return;
    for (const SlurmTask& task : *queued) tasks[task.id()] = task;
    ended = ended_tasks(jobs);
  }
};

// Updates the status with Slurm's answer. The part's progress file says how much is done, but Slurm
// knows whether the part is running.
void apply_queue_state(const Queue& queue, const std::string& id, PartStatus& status) {
  if (!queue.known || status.state == kDone) return;
  if (const auto task = queue.tasks.find(id); task != queue.tasks.end()) {
    status.state = task->second.running ? kRunning : kWaiting;
    if (!task->second.node.empty()) status.node = printable(task->second.node);
    if (!task->second.running) {
      status.left_s.reset();
      status.message = printable(task->second.reason);
    }
    return;
  }
  const auto ended = queue.ended.find(id);
  if (ended != queue.ended.end()) status.message = printable(ended->second);
  if (status.message == "COMPLETED") {  // the part's own progress file may arrive late
    status.state = kDone;
    status.done = 1;
    status.message.clear();
  } else if (status.state != kStopped) {
    status.state = kFailed;  // killed, or never started
  }
}

void set_message(const std::string& log, PartStatus& status) {
  if (status.state == kRunning) return;
  status.left_s.reset();
  if (status.state == kStopped)
    status.message = "the work is saved; emberline farm retry continues it";
  if (status.state != kFailed) return;
  const std::string line = last_line(log);
  if (line.empty()) return;
  status.message = status.message.empty() ? line : status.message + ": " + line;
}

// Called only without Slurm. Changes a running part's state to kUnknown if the part has not written
// its progress file for a minute.
void mark_if_silent(const std::string& progress, PartStatus& status) {
  using namespace std::chrono;
  std::error_code error;
  const auto written = std::filesystem::last_write_time(progress, error);
  const auto silent = std::filesystem::file_time_type::clock::now() - written;
  if (error || silent < minutes(1)) return;
  status.state = kUnknown;
  status.left_s.reset();
  status.message =
      fmt::format("no progress for {}", readable_seconds(duration<double>(silent).count()));
}

PartStatus part_status(const FarmFolder& folder, const FarmRecord& record, const Queue& queue,
                       uint32_t part) {
  PartStatus status;
  status.part = part;
  const bool has_progress = read_progress(folder.progress(part), status);
  if (!has_progress) status.done = checkpoint_fraction(folder.checkpoint(part, record.parts));
  if (!has_progress && !queue.known) status.state = record.arrays.empty() ? kWaiting : kUnknown;
  if (!has_progress && status.done == 1) status.state = kDone;
  // A part may have been submitted several times. The last job array that contains it counts.
  std::string id;
  for (const uint64_t array : record.arrays) {
    const std::string task = fmt::format("{}_{}", array, part);
    if (id.empty() || queue.tasks.contains(task) || queue.ended.contains(task)) id = task;
  }
  apply_queue_state(queue, id, status);
  if (status.state == kRunning && !queue.known) mark_if_silent(folder.progress(part), status);
  set_message(folder.file(fmt::format("logs/part-{}.log", part)), status);
  return status;
}

PartStatus plan_status(const FarmFolder& folder, const FarmRecord& record, const Queue& queue) {
  PartStatus status;
  bool has_progress = read_progress(folder.plan_progress(), status);
  const bool has_plan = std::filesystem::exists(folder.plan());
  if (has_progress && status.state == kDone && !has_plan) {  // the file of an earlier plan
    status = {};
    has_progress = false;
  }
  if (has_plan) {
    status.state = kDone;
    status.done = 1;
  } else if (!has_progress && !queue.known && record.plan) {
    status.state = kUnknown;
  }
  if (record.plan) apply_queue_state(queue, std::to_string(*record.plan), status);
  if (status.state == kRunning && !queue.known) mark_if_silent(folder.plan_progress(), status);
  set_message(folder.file("logs/plan.log"), status);
  return status;
}

PartStatus merge_status(const FarmFolder& folder, const FarmRecord& record, const Queue& queue) {
  PartStatus status;
  if (std::filesystem::exists(folder.file("merge.json"))) {
    status.state = kDone;
    status.done = 1;
  } else if (!queue.known && record.merge) {
    status.state = kUnknown;
  }
  if (record.merge) apply_queue_state(queue, std::to_string(*record.merge), status);
  if (status.state == kFailed && (status.message.empty() || status.message == "CANCELLED")) {
    status.message = "cancelled because a part failed; use farm retry";
  }
  set_message(folder.file("logs/merge.log"), status);
  return status;
}

// Estimates the time left for all parts. Assumes that waiting parts take as long as the other
// parts, and that the number of running parts stays the same.
std::optional<double> time_left(const std::vector<PartStatus>& parts) {
  double sum = 0, longest = 0, total_s = 0, waiting = 0, timed_parts = 0, running = 0;
  for (const PartStatus& part : parts) {
    if (part.state == kFailed || part.state == kStopped || part.state == kUnknown)
      return std::nullopt;
    if (part.state == kWaiting) waiting += 1 - part.done;
    if (part.state == kRunning && !part.left_s) return std::nullopt;
    if (part.state == kRunning) {
      ++running;
      sum += *part.left_s;
      longest = std::max(longest, *part.left_s);
    }
    if (part.state == kWaiting || !part.elapsed_s) continue;
    total_s += *part.elapsed_s + part.left_s.value_or(0);
    ++timed_parts;
  }
  if (waiting == 0) return longest;
  if (timed_parts == 0 || running == 0) return std::nullopt;
  return std::max(longest, (sum + waiting * total_s / timed_parts) / running);
}

Json json_of(const PartStatus& part) {
  Json json = {{"state", state_name(part.state)}, {"done", part.done}, {"samples", part.samples}};
  json["elapsed_s"] = part.elapsed_s ? Json(*part.elapsed_s) : Json();
  json["left_s"] = part.left_s ? Json(*part.left_s) : Json();
  json["node"] = part.node;
  json["message"] = part.message;
  return json;
}

std::string format_row(const std::string& what, const PartStatus& part) {
  std::string text =
      fmt::format("{:<10} {:<8} {:>7}", what, state_name(part.state), readable_percent(part.done));
  if (!part.node.empty()) text += "  " + part.node;
  if (part.left_s) text += "  " + readable_seconds(*part.left_s) + " left";
  if (!part.message.empty()) text += "  " + part.message;
  return text + "\n";
}

}  // namespace

FarmStatus farm_status(const FarmFolder& folder) {
  const FarmRecord record = read_record(folder);
  const Queue queue(record);
  FarmStatus status;
  status.output = folder.output;
  for (uint32_t part = 1; part <= record.parts; ++part) {
    status.parts.push_back(part_status(folder, record, queue, part));
    status.done += status.parts.back().done / record.parts;
  }
  if (record.makes_plan) status.plan = plan_status(folder, record, queue);
  status.merge = merge_status(folder, record, queue);
  status.left_s = time_left(status.parts);
  return status;
}

std::string status_json(const FarmStatus& status) {
  Json json = {{"output", status.output}, {"done", status.done}};
  json["left_s"] = status.left_s ? Json(*status.left_s) : Json();
  for (const PartStatus& part : status.parts) {
    Json entry = {{"part", part.part}};
    entry.update(json_of(part));
    json["parts"].push_back(entry);
  }
  if (status.plan) json["plan"] = json_of(*status.plan);
  json["merge"] = json_of(status.merge);
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Lists every part except waiting and finished ones, which are only counted.
std::string status_text(const FarmStatus& status) {
  std::string text = printable(status.output) + fmt::format(": {} parts", status.parts.size());
  for (size_t i = 0; i < std::size(kStates); ++i) {
    const auto count = std::ranges::count(status.parts, PartState(i), &PartStatus::state);
    if (count > 0) text += fmt::format(", {} {}", count, kStates[i]);
  }
  text += "; " + readable_percent(status.done);
  if (status.left_s && *status.left_s > 0)
    text += ", " + readable_seconds(*status.left_s) + " left";
  text += "\n";
  if (status.plan) text += format_row("plan", *status.plan);
  for (const PartStatus& part : status.parts) {
    if (part.state == kWaiting || part.state == kDone) continue;
    text += format_row(fmt::format("part {}", part.part), part);
  }
  return text + format_row("merge", status.merge);
}

}  // namespace emberline
