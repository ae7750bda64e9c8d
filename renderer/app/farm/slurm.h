// Slurm's commands: what is asked of them, and what they answer.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace emberline {

// The resources that each job requests; absent: what the partition gives.
struct SlurmRequest {
  std::string partition;
  std::optional<int> cpus;  // absent: a whole node
  std::optional<uint64_t> memory_bytes;
  std::optional<int> minutes;
};

// A list of letters, digits, "_", "-", "." and ","; or nothing.
bool is_partition(const std::string& text);

// Throws RenderError where this machine has no Slurm.
void require_slurm();

// Submits `script`, which runs in `folder`, as a job with these further words, and returns its
// number. Throws RenderError with what sbatch says.
uint64_t submit_job(const SlurmRequest& request, const std::string& folder,
                    const std::string& script, const std::vector<std::string>& words);

// A job, or a task of an array, that waits or runs.
struct SlurmTask {
  uint64_t job = 0;
  std::optional<uint32_t> task;
  bool running = false;
  std::string state, node, reason;

  std::string id() const;  // "JOB_TASK" or "JOB"
};
// The tasks of these jobs; nothing without Slurm or if its controller does not answer.
std::optional<std::vector<SlurmTask>> queued_tasks(std::span<const uint64_t> jobs);

// How those ended that are over, by "JOB" or "JOB_TASK": "FAILED", "NODE_FAIL". Empty without
// accounting.
std::map<std::string, std::string> ended_tasks(std::span<const uint64_t> jobs);

// Throws RenderError. Jobs that are over are none of its business.
void cancel_jobs(std::span<const uint64_t> jobs);

}  // namespace emberline
