// Loads scenes for a session, one after another, in the background; only the newest counts.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>

#include "renderer/session/loaded_scene.h"
#include "renderer/session/task_thread.h"

namespace emberline {

class SceneLoader {
 public:
  // `wake` is called, from the loader's thread, when there is news.
  explicit SceneLoader(std::function<void()> wake);

  // Any thread, and none of them waits.
  void load(const RenderOptions& options);
  void cancel();
  // How it stands; and the scene, the first time that it is there.
  LoadStatus poll(std::shared_ptr<LoadedScene>* arrived);

 private:
  void load_now(const RenderOptions& options, uint64_t number, std::stop_token stop);
  // Changes the status if that load is still the one that counts.
  void report(uint64_t number, const std::function<void(LoadStatus&)>& change);

  const std::function<void()> wake_;
  std::mutex mutex_;
  uint64_t number_ = 0;    // of the newest load; cancelling counts as one
  std::stop_source stop_;  // of the same load
  LoadStatus status_;
  std::shared_ptr<LoadedScene> loaded_;
  std::shared_ptr<MemoryBudget> memory_;  // of all scenes there are; the loader's thread's
  TaskThread thread_;                     // last: its tasks use all of the above
};

}  // namespace emberline
