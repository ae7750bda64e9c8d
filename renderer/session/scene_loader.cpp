#include "renderer/session/scene_loader.h"

#include <new>
#include <utility>

#include "renderer/core/errors.h"

namespace emberline {

SceneLoader::SceneLoader(std::function<void()> wake) : wake_(std::move(wake)) {}

void SceneLoader::load(const RenderOptions& options) {
  uint64_t number;
  std::stop_token stop;
  std::shared_ptr<LoadedScene> unclaimed;  // loaded but not polled; freed on the loader's thread
  {
    const std::lock_guard lock(mutex_);
    number = ++number_;
    stop_.request_stop();
    stop_ = {};
    stop = stop_.get_token();
    unclaimed = std::move(loaded_);
    status_ = {LoadStatus::State::kLoading, options.scene, "waiting", 0.0, {}};
  }
  thread_.post([this, options, number, stop, unclaimed = std::move(unclaimed)]() mutable {
    unclaimed.reset();
    run_load(options, number, stop);
  });
}

void SceneLoader::cancel() {
  const std::lock_guard lock(mutex_);
  if (status_.state != LoadStatus::State::kLoading) return;
  ++number_;
  stop_.request_stop();
  status_.state = LoadStatus::State::kCancelled;
}

LoadStatus SceneLoader::poll(std::shared_ptr<LoadedScene>* new_scene) {
  const std::lock_guard lock(mutex_);
  *new_scene = std::move(loaded_);
  return status_;
}

void SceneLoader::report(uint64_t number, const std::function<void(LoadStatus&)>& change) {
  {
    const std::lock_guard lock(mutex_);
    if (number != number_) return;
    change(status_);
  }
  wake_();
}

void SceneLoader::run_load(const RenderOptions& options, uint64_t number, std::stop_token stop) {
  {
    const std::lock_guard lock(mutex_);
    if (number != number_) return;  // a newer load follows, or this load was cancelled
  }
  const auto fail = [&](const std::string& error) {
    report(number, [&](LoadStatus& status) {
      status.state = LoadStatus::State::kFailed;
      status.error = error;
    });
  };
  try {
    // The open scene stays until the new one is loaded, so the new one gets only the remaining
    // memory.
    LoadLimits limits = limits_of(options.limits, options.scene);
    if (!memory_) memory_ = limits.memory;
    limits.memory = memory_->child_budget();
    LoadProgress progress(
        [&](const std::string& stage, double fraction) {
          report(number, [&](LoadStatus& status) {
            status.stage = stage;
            status.fraction = fraction;
          });
        },
        std::move(stop), limits);
    std::shared_ptr<LoadedScene> scene = load_session_scene(options, progress);
    scene->memory = MemoryReservation(memory_, MemoryPart::kGeometry,
                                      limits.memory->newly_reserved(), options.scene);
    report(number, [&](LoadStatus& status) {
      status.state = LoadStatus::State::kReady;
      status.stage.clear();
      status.fraction = 1.0;
      loaded_ = std::move(scene);
    });
  } catch (const Cancelled&) {
    // cancel() and load() have set the status.
  } catch (const EmberlineError& error) {
    fail(error.what());
  } catch (const std::bad_alloc&) {
    fail(options.scene + ": not enough memory to load it");
  }
}

}  // namespace emberline
