// The threads of a command.
#pragma once

#include <tbb/global_control.h>

#include <exception>
#include <string>

namespace emberline {

// Limits TBB to a number of threads during its lifetime. TBB starts threads on demand and ends the
// process if the system refuses one, so starting them is tested first.
class WorkerThreads {
 public:
  // 0: one thread per usable processor, limited by the Slurm job and, with a warning, by what the
  // system lets start. Throws RenderError if a requested number cannot be started.
  explicit WorkerThreads(int requested);

  int count() const { return count_; }

 private:
  int count_;
  tbb::global_control limit_;
};

// Number of processors in the calling thread's affinity mask, which taskset, containers and batch
// systems set.
int usable_processors();

// Handles threads that the system refuses later, after other processes started theirs. If TBB
// throws on one of its own threads, the process ends: with one line and without unfinished files.
void install_refused_thread_handler();

// A message about refused threads for such an error; otherwise `error`'s own.
std::string message_of(const std::exception& error);

}  // namespace emberline
