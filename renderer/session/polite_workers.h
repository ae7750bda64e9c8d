// Render threads that let others go first: a window's thread, and those that draw for it where
// OpenGL is software, then have the processor as soon as they want it.
#pragma once

#include <tbb/task_arena.h>
#include <tbb/task_scheduler_observer.h>

namespace emberline {

// While it lives, threads that begin to work in the arena lower their own priority (Linux's nice
// value, which each thread has of its own; elsewhere nothing happens). They keep it: only a
// privileged process could raise it again. An idle machine renders as fast as without.
class PoliteWorkers final : public tbb::task_scheduler_observer {
 public:
  explicit PoliteWorkers(tbb::task_arena& arena);
  ~PoliteWorkers() override;

  void on_scheduler_entry(bool worker) override;
};

}  // namespace emberline
