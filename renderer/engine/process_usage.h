// Memory, CPU time and age of this process, and the limits of its Slurm job.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace emberline {

// Peak resident memory and CPU time so far, and seconds since process start (10 ms resolution;
// nullopt without /proc).
uint64_t peak_rss_bytes();
double process_cpu_seconds();
std::optional<double> process_age_seconds();

std::string host_name();

// The allocation of the surrounding Slurm job, from its environment variables (sbatch(1), "OUTPUT
// ENVIRONMENT VARIABLES"). Absent outside a job; impossible values are ignored.
std::optional<uint64_t> slurm_memory_bytes();  // SLURM_MEM_PER_NODE
std::optional<int> slurm_cpus();               // SLURM_CPUS_PER_TASK

// Seconds until one minute before SLURM_JOB_END_TIME, at least 0; the minute is reserved for the
// checkpoint. If this machine's clock is outside the job's time, uses SLURM_JOB_START_TIME and the
// process age instead, with a warning.
std::optional<double> slurm_seconds_left();

}  // namespace emberline
