#include "renderer/app/farm/slurm.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "io/files/descriptor.h"
#include "renderer/core/errors.h"
#include "renderer/core/option_values.h"
#include "renderer/core/shortened.h"

namespace emberline {
namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends;
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw RenderError("pipe: {}", std::strerror(errno));
    read = Descriptor(ends[0]);
    write = Descriptor(ends[1]);
  }

  Descriptor read, write;
};

struct ToolResult {
  int exit_code = 0;  // 128 and more: ended by a signal
  std::string out, err;
};

// Reads both pipes at once, because a program that fills one pipe blocks until it is read.
void read_both(Pipe& out, Pipe& err, ToolResult& result) {
  std::array<pollfd, 2> ends = {pollfd{out.read, POLLIN, 0}, pollfd{err.read, POLLIN, 0}};
  while (ends[0].fd >= 0 || ends[1].fd >= 0) {
    if (::poll(ends.data(), ends.size(), -1) < 0 && errno != EINTR) return;
    for (size_t i = 0; i < ends.size(); ++i) {
      if (ends[i].fd < 0 || ends[i].revents == 0) continue;
      char block[4096];
      const ssize_t count = ::read(ends[i].fd, block, sizeof block);
      if (count > 0) (i == 0 ? result.out : result.err).append(block, size_t(count));
      if (count == 0 || (count < 0 && errno != EINTR)) ends[i].fd = -1;
    }
  }
}

// Finds the program words[0] in PATH and runs it without a shell, with the other words as
// arguments. Returns nothing if there is no such program. Throws RenderError if the program cannot
// be started.
std::optional<ToolResult> run_tool(const std::vector<std::string>& words) {
  Pipe out, err;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, out.write, STDOUT_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, err.write, STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int error =
      ::posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error == ENOENT || error == EACCES) return std::nullopt;
  if (error != 0) throw RenderError("cannot start {}: {}", words[0], std::strerror(error));
  out.write = Descriptor();
  err.write = Descriptor();
  ToolResult result;
  read_both(out, err, result);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

RenderError missing_slurm_error(const std::string& program) {
  return RenderError(
      "cannot find {}: this machine has no Slurm; run the command where jobs are submitted, or use "
      "farm --print for another queue",
      program);
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

ToolResult run_slurm(const std::vector<std::string>& words) {
  const std::optional<ToolResult> result = run_tool(words);
  if (!result) throw missing_slurm_error(words[0]);
  if (result->exit_code != 0) {
    throw RenderError("{}: {}", words[0],
                      result->err.empty() ? fmt::format("exit code {}", result->exit_code)
                                          : first_line(result->err));
  }
  return *result;
}

bool is_name_character(char c) {
  const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  return letter || c == '.' || c == '-' || c == '_';
}

// Replaces all characters except letters, digits, '.', '-' and '_' with '_', so that the text can
// be a job name in Slurm.
std::string sanitize_name(std::string text) {
  std::ranges::replace_if(
      text, [](char c) { return !is_name_character(c); }, '_');
  return text;
}

template <size_t kCount>
std::array<std::string, kCount> split_fields(const std::string& line) {
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
  return std::ranges::all_of(text, [](char c) { return is_name_character(c) || c == ','; });
}

void require_slurm() {
  if (!run_tool({"sbatch", "--version"})) throw missing_slurm_error("sbatch");
}

uint64_t submit_job(const SlurmRequest& request, const std::string& folder,
                    const std::string& script, const std::vector<std::string>& words) {
  const std::filesystem::path name = std::filesystem::path(folder).stem();
  std::vector<std::string> command = {"sbatch",
                                      "--parsable",
                                      "--job-name=" + sanitize_name(name.string()),
                                      "--chdir=" + folder,
                                      "--open-mode=append",
                                      "--requeue"};
  if (!request.partition.empty()) command.push_back("--partition=" + request.partition);
  command.push_back(request.cpus ? fmt::format("--cpus-per-task={}", *request.cpus)
                                 : "--exclusive");
  if (request.memory_bytes) {
    command.push_back(fmt::format("--mem={}M", (*request.memory_bytes + 0xFFFFF) >> 20));
  }
  if (request.minutes) command.push_back(fmt::format("--time={}", *request.minutes));
  command.insert(command.end(), words.begin(), words.end());
  command.push_back(folder + "/" + script);
  const std::string answer = first_line(run_slurm(command).out);  // "12", or "12;cluster"
  const auto job = parse_number<uint64_t>(answer.substr(0, answer.find(';')));
  if (!job || *job == 0)
    throw RenderError("sbatch answers '{}', which is not a job number", shortened(answer));
  return *job;
}

std::optional<std::vector<SlurmTask>> queued_tasks(std::span<const uint64_t> jobs) {
  std::vector<SlurmTask> tasks;
  if (jobs.empty()) return tasks;
  // Calls squeue once for each job. If squeue is asked about several jobs, it omits the jobs that
  // it has forgotten.
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
      const auto [number, task, state, node, reason] = split_fields<5>(line);
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
    const auto [job, state] = split_fields<2>(line);
    states[job] = state.substr(0, state.find(' '));  // may be "CANCELLED by 1000"
  }
  return states;
}

void cancel_jobs(std::span<const uint64_t> jobs) {
  if (jobs.empty()) return;
  std::vector<std::string> words = {"scancel"};
  for (const uint64_t job : jobs) words.push_back(std::to_string(job));
  const std::optional<ToolResult> result = run_tool(words);
  if (!result) throw missing_slurm_error("scancel");
  if (result->exit_code != 0 && result->err.find("Invalid job id") == std::string::npos) {
    throw RenderError("scancel: {}", first_line(result->err));
  }
}

}  // namespace emberline
