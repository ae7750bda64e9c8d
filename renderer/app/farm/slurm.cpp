#include "renderer/app/farm/slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <sstream>

#include "renderer/app/farm/run_tool.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

RenderError no_slurm(const std::string& program) {
  return RenderError(
      "{} is not there: this machine has no Slurm; farm --print shows what to give to another "
      "queue",
      program);
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

ToolResult run_slurm(const std::vector<std::string>& words) {
  const std::optional<ToolResult> result = run_tool(words);
  if (!result) throw no_slurm(words[0]);
  if (result->exit_code != 0) {
    throw RenderError("{}: {}", words[0],
                      result->err.empty() ? fmt::format("exit code {}", result->exit_code)
                                          : first_line(result->err));
  }
  return *result;
}

bool is_plain(char c) {
  const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  return letter || c == '.' || c == '-' || c == '_';
}

// In names that Slurm shows.
std::string plain(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return !is_plain(c); }, '_');
  return text;
}

template <size_t kCount>
std::array<std::string, kCount> fields_of(const std::string& line) {
  std::array<std::string, kCount> fields;
  std::istringstream stream(line);
  for (std::string& field : fields) std::getline(stream, field, '|');
  return fields;
}

}  // namespace

std::string SlurmTask::id() const {
  return task ? fmt::format("{}_{}", job, *task) : std::to_string(job);
}

bool is_partition(const std::string& text) {
  return std::ranges::all_of(text, [](char c) { return is_plain(c) || c == ','; });
}

void require_slurm() {
  if (!run_tool({"sbatch", "--version"})) throw no_slurm("sbatch");
}

uint64_t submit_job(const SlurmRequest& request, const std::string& folder,
                    const std::string& script, const std::vector<std::string>& words) {
  const std::filesystem::path name = std::filesystem::path(folder).stem();
  std::vector<std::string> all = {"sbatch",
                                  "--parsable",
                                  "--job-name=" + plain(name.string()),
                                  "--chdir=" + folder,
                                  "--open-mode=append",
                                  "--requeue"};
  if (!request.partition.empty()) all.push_back("--partition=" + request.partition);
  all.push_back(request.cpus ? fmt::format("--cpus-per-task={}", *request.cpus) : "--exclusive");
  if (request.memory_bytes) {
    all.push_back(fmt::format("--mem={}M", (*request.memory_bytes + 0xFFFFF) >> 20));
  }
  if (request.minutes) all.push_back(fmt::format("--time={}", *request.minutes));
  all.insert(all.end(), words.begin(), words.end());
  all.push_back(folder + "/" + script);
  const std::string answer = first_line(run_slurm(all).out);  // "12", or "12;cluster"
  const auto job = parse_number<uint64_t>(answer.substr(0, answer.find(';')));
  if (!job || *job == 0)
    throw RenderError("sbatch answers '{}', which is no number of a job", shortened(answer));
  return *job;
}

std::optional<std::vector<SlurmTask>> queued_tasks(std::span<const uint64_t> jobs) {
  std::vector<SlurmTask> tasks;
  if (jobs.empty()) return tasks;
  // One call for each job: asked about several, squeue omits the jobs that it has forgotten.
  for (const uint64_t job : jobs) {
    const auto result = run_tool({"squeue", "--noheader", "--array", "--format=%F|%K|%T|%N|%r",
                                  fmt::format("--jobs={}", job)});
    if (!result) return std::nullopt;
    if (result->exit_code != 0) {
      if (result->err.find("Invalid job id") != std::string::npos) continue;
      return std::nullopt;
    }
    std::istringstream lines(result->out);
    for (std::string line; std::getline(lines, line);) {
      const auto [number, task, state, node, reason] = fields_of<5>(line);
      if (parse_number<uint64_t>(number) != job) continue;
      const bool running = state == "RUNNING" || state == "COMPLETING";
      tasks.push_back({job, parse_number<uint32_t>(task), running, state, node, reason});
    }
  }
  return tasks;
}

std::map<std::string, std::string> ended_tasks(std::span<const uint64_t> jobs) {
  std::map<std::string, std::string> states;
  if (jobs.empty()) return states;
  const auto result =
      run_tool({"sacct", "--noheader", "--parsable2", "--allocations", "--format=JobID,State",
                fmt::format("--jobs={}", fmt::join(jobs, ","))});
  if (!result || result->exit_code != 0) return states;
  std::istringstream lines(result->out);
  for (std::string line; std::getline(lines, line);) {
    const auto [job, state] = fields_of<2>(line);
    states[job] = state.substr(0, state.find(' '));  // "CANCELLED by 1000"
  }
  return states;
}

void cancel_jobs(std::span<const uint64_t> jobs) {
  if (jobs.empty()) return;
  std::vector<std::string> words = {"scancel"};
  for (const uint64_t job : jobs) words.push_back(std::to_string(job));
  const std::optional<ToolResult> result = run_tool(words);
  if (!result) throw no_slurm("scancel");
  if (result->exit_code != 0 && result->err.find("Invalid job id") == std::string::npos) {
    throw RenderError("scancel: {}", first_line(result->err));
  }
}

}  // namespace emberline
