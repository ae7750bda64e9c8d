// Calls Slurm's commands and parses their answers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace emberline {

// The resources that each job requests. If a value is absent, the partition's default applies.
struct SlurmRequest {
  std::string partition;
  std::optional<int> cpus;  // absent: a whole node
  std::optional<uint64_t> memory_bytes;
  std::optional<int> minutes;
};

// Whether `text` is empty or consists of letters, digits, "_", "-", "." and ",".
bool is_partition(const std::string& text);

// Throws RenderError if this machine has no Slurm.
void require_slurm();

// Submits `script` as a job that runs in `folder`, and returns the job's number. `words` are
// further arguments for sbatch. Throws RenderError with the message of sbatch.
uint64_t submit_job(const SlurmRequest& request, const std::string& folder,
                    const std::string& script, const std::vector<std::string>& words);

// A job, or a task of an array, that is queued or running.
struct SlurmTask {
  uint64_t job = 0;
  std::optional<uint32_t> task;
  bool running = false;
  std::string state, node, reason;

  std::string id() const;  // "JOB_TASK" or "JOB"
};
// Returns the unfinished tasks of these jobs. Returns nothing if there is no Slurm or its
// controller does not answer.
std::optional<std::vector<SlurmTask>> queued_tasks(std::span<const uint64_t> jobs);

// Returns the final states of finished jobs and tasks ("FAILED", "NODE_FAIL"), keyed by "JOB" or
// "JOB_TASK"; an empty map if Slurm has no accounting.
std::map<std::string, std::string> ended_tasks(std::span<const uint64_t> jobs);

// Ignores finished jobs. Throws RenderError.
void cancel_jobs(std::span<const uint64_t> jobs);

}  // namespace emberline
