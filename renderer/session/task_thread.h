// A thread that does one thing after another for a session: loading, grading, writing.
#pragma once

#include <tbb/concurrent_queue.h>

#include <functional>
#include <thread>
#include <utility>

namespace emberline {

class TaskThread {
 public:
  TaskThread() : thread_([this] { work(); }) {}
  // Does what has been posted, and ends.
  ~TaskThread() {
    tasks_.push(nullptr);
    thread_.join();
  }

  // Any thread. The task must not throw.
  void post(std::function<void()> task) { tasks_.push(std::move(task)); }

 private:
  void work() {
    while (true) {
      std::function<void()> task;
      tasks_.pop(task);
      if (!task) return;
      task();
    }
  }

  tbb::concurrent_bounded_queue<std::function<void()>> tasks_;  // one without a function ends it
  std::thread thread_;
};

}  // namespace emberline
