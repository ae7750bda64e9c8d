// Loads scenes for a session in the background, one at a time. Only the newest request counts.
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
  // `wake` is called on the loader's thread when the status changes.
  explicit SceneLoader(std::function<void()> wake);

  // load(), cancel() and poll() never block and may be called from any thread.
  void load(const RenderOptions& options);
  void cancel();
  // Returns the status. If a scene has been loaded, moves it to `new_scene`; otherwise sets
  // `new_scene` to null.
  LoadStatus poll(std::shared_ptr<LoadedScene>* new_scene);

 private:
  void run_load(const RenderOptions& options, uint64_t number, std::stop_token stop);
  // Changes the status if this load is still the newest.
  void report(uint64_t number, const std::function<void(LoadStatus&)>& change);

  const std::function<void()> wake_;
  std::mutex mutex_;
  uint64_t number_ = 0;    // number of the newest load; cancelling increments it
  std::stop_source stop_;  // stops the newest load
  LoadStatus status_;
  std::shared_ptr<LoadedScene> loaded_;
  std::shared_ptr<MemoryBudget> memory_;  // budget for all scenes; only the loader's thread uses it
  TaskThread thread_;                     // declared last, because its tasks use all members above
};

}  // namespace emberline
