// Limits and tests the number of threads of a command.
#pragma once

#include <tbb/global_control.h>

#include <exception>
#include <string>

namespace emberline {

// Limits TBB to a number of threads while this object exists. TBB starts threads on demand and ends
// the process if a thread cannot be started. So the constructor first tests whether all threads can
// be started.
class WorkerThreads {
 public:
  // 0 requests one thread per usable processor, or fewer if the Slurm job has fewer processors. If
  // the system cannot start that many, there are fewer threads, with a warning. Throws RenderError
  // if a number above 0 is requested and cannot be started.
  explicit WorkerThreads(int requested);

  int count() const { return count_; }

 private:
  int count_;
  tbb::global_control limit_;
};

// Returns the number of processors in the calling thread's affinity mask, which taskset, containers
// and batch systems set.
int usable_processors();

// Handles threads that the system refuses later, for example because other processes have started
// threads. If TBB then throws on one of its own threads, the process must end. Before it ends, the
// handler logs one line and removes unfinished files.
void install_refused_thread_handler();

// Returns a message about refused threads if they caused `error`; otherwise returns error.what().
std::string message_of(const std::exception& error);

}  // namespace emberline
