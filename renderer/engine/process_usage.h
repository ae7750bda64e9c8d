// Measures memory, CPU time and age of this process, and reads the limits of its Slurm job.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace emberline {

// Return the peak resident memory and the CPU time so far, and the seconds since the process
// started. The seconds have a resolution of 10 ms, and are absent without /proc.
uint64_t peak_rss_bytes();
double process_cpu_seconds();
std::optional<double> process_age_seconds();

std::string host_name();

// Return what Slurm has allocated to this job, from the environment variables (sbatch(1), "OUTPUT
// ENVIRONMENT VARIABLES"). The value is absent outside a job, or if the variable has an impossible
// value.
std::optional<uint64_t> slurm_memory_bytes();  // SLURM_MEM_PER_NODE
std::optional<int> slurm_cpus();               // SLURM_CPUS_PER_TASK

// Returns the seconds until one minute before SLURM_JOB_END_TIME, at least 0. The minute is
// reserved for the checkpoint. If this machine's clock is not between the job's start and end,
// warns and uses SLURM_JOB_START_TIME and the process age instead. The value is absent outside a
// job.
std::optional<double> slurm_seconds_left();

}  // namespace emberline
