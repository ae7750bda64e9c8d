// What a job of Slurm has given this process, from the environment that Slurm sets (sbatch(1),
// "OUTPUT ENVIRONMENT VARIABLES"). Outside of a job: nothing. Values that cannot be are ignored.
#pragma once

#include <cstdint>
#include <optional>

namespace emberline {

std::optional<uint64_t> slurm_memory_bytes();  // SLURM_MEM_PER_NODE
std::optional<int> slurm_cpus();               // SLURM_CPUS_PER_TASK

// From now until a minute before SLURM_JOB_END_TIME, 0 at least: the minute is for the checkpoint.
// Where this machine's clock is not within the job's time, SLURM_JOB_START_TIME and the age of this
// process tell, with a warning.
std::optional<double> slurm_seconds_left();

}  // namespace emberline
