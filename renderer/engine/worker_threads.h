// The threads a command works with.
#pragma once

#include <tbb/global_control.h>

#include <exception>
#include <string>

namespace emberline {

// Limits TBB's loops to a number of threads while it lives. TBB starts threads when work comes, and
// ends the process if the system refuses one; so starting them is tried beforehand.
class WorkerThreads {
 public:
  // 0: one for each processor that this process may use, no more than its job of Slurm has, or as
  // many of those as the system lets start, with a warning. Throws RenderError when more are asked
  // for than that.
  explicit WorkerThreads(int wanted);

  int count() const { return count_; }

 private:
  int count_;
  tbb::global_control limit_;
};

// Processors that the calling thread may run on: its affinity mask, which taskset, containers and
// batch systems set.
int usable_processors();

// The system may refuse a thread all the same, when others have started theirs meanwhile. TBB then
// throws, in the thread that works or in one of its own, where it ends the process: with one line,
// after this call, and without unfinished files.
void install_refused_thread_handler();

// The message for an error that is about a refused thread; `error`'s own for any other.
std::string message_of(const std::exception& error);

}  // namespace emberline
