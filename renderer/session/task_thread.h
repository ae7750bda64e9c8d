// A thread that runs tasks in the order of posting. A session has one each for loading, grading and
// writing.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace emberline {

class TaskThread {
 public:
  TaskThread() : thread_([this] { work(); }) {}
  // Finishes all posted tasks.
  ~TaskThread() {
    post(nullptr);
    thread_.join();
  }

  // May be called on any thread. The task must not throw.
  void post(std::function<void()> task) {
    {
      const std::lock_guard lock(mutex_);
      tasks_.push_back(std::move(task));
    }
    posted_.notify_one();
  }

 private:
  void work() {
    while (true) {
      std::unique_lock lock(mutex_);
      posted_.wait(lock, [this] { return !tasks_.empty(); });
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      lock.unlock();
      if (!task) return;
      task();
    }
  }

  std::mutex mutex_;
  std::condition_variable posted_;
  std::deque<std::function<void()>> tasks_;  // an empty function ends the thread
  std::thread thread_;
};

}  // namespace emberline
