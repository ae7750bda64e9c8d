// Memory, processor time and age of this process, and what its job of Slurm allots it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace emberline {

// Peak resident memory and CPU time of this process so far, and the seconds since it was started
// (to the kernel's 10 ms; absent if /proc does not say).
uint64_t peak_rss_bytes();
double process_cpu_seconds();
std::optional<double> process_age_seconds();

std::string host_name();

// The allocation of the Slurm job that this process runs in, from its environment variables
// (sbatch(1), "OUTPUT ENVIRONMENT VARIABLES"). Absent outside of a job. Impossible values are
// ignored.
std::optional<uint64_t> slurm_memory_bytes();  // SLURM_MEM_PER_NODE
std::optional<int> slurm_cpus();               // SLURM_CPUS_PER_TASK

// From now until a minute before SLURM_JOB_END_TIME, 0 at least: the minute is for the checkpoint.
// If this machine's clock is outside the job's time, SLURM_JOB_START_TIME and the age of this
// process are used instead, with a warning.
std::optional<double> slurm_seconds_left();

}  // namespace emberline
