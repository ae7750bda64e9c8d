// The rendering thread of a session. Renders the newest request until a newer one arrives. When the
// driver pauses, this thread serves other threads' requests to copy or inspect the film.
#pragma once

#include <tbb/task_arena.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "renderer/engine/worker_threads.h"
#include "renderer/session/view_frame.h"

namespace emberline {

class ViewRenderer {
 public:
  explicit ViewRenderer(PicturePublisher& publisher);
  // Stops the frame and waits for it. The futures of pending copies throw RenderError.
  ~ViewRenderer();

  // All functions below are thread-safe and only wait for a lock.

  // Replaces a request that has not begun. `only_edits` says that only the edits differ from the
  // previous request. The current frame then shows its first picture before it ends; it does not
  // end at all if its light groups can show the new edits.
  void post(RenderRequest request, bool only_edits);
  void set_paused(bool paused);
  // Changes how the current film is shown.
  void set_display_mode(const DisplayMode& display_mode);
  void republish();

  // Copies the film at the next pause of a frame that has a picture.
  std::future<FilmCopy> copy();
  // Two pixels are inspected independently: the pixel under the cursor (kPointed) and the pixel to
  // explain (kPicked), which also gets the driver's explanation.
  enum class InspectionTarget : uint8_t { kPointed, kPicked };
  // From the next pause on, inspection() describes this pixel. The description is updated with each
  // picture.
  void inspect(InspectionTarget target, std::optional<Vec2i> pixel);
  std::optional<PixelInspection> inspection(InspectionTarget target) const;

 private:
  class LowPriorityWorkers;
  struct InspectedPixel {
    std::optional<Vec2i> pixel;
    bool is_pending = false;
    std::optional<PixelInspection> found;
  };

  template <class Change>
  void update_state(const Change& update);
  void work();
  std::optional<RenderRequest> next_request();
  void render(RenderRequest request);
  std::unique_ptr<PreparedSettings> prepare(const ViewSettings& settings) const;
  void set_threads(int requested);
  void read_environment(RenderRequest& request);
  void pause(bool is_published);
  void serve(std::unique_lock<std::mutex>& lock);
  bool requested() const;      // whether serve() has something to do
  void request_inspections();  // requests an update of both inspections
  InspectedPixel& inspected_pixel(InspectionTarget target) {
    return inspection_targets_[size_t(target)];
  }
  bool is_waiting() const;
  std::optional<LightMix> mix_of(const RenderRequest& request) const;
  static std::shared_ptr<const LightGroups> apply_edits(const RenderRequest& request,
                                                        const PreparedSettings& prepared);

  PicturePublisher& publisher_;

  mutable std::mutex mutex_;
  std::condition_variable state_changed_;
  std::optional<RenderRequest> request_;
  bool let_first_picture_finish_ = false;  // the frame shows a picture before request_ ends it
  bool ending_ = false, paused_ = false;
  std::shared_ptr<StopRequest> stop_;  // stops the current frame; null if there is none
  bool frame_published_ = false;       // the current frame has shown a picture
  bool republish_requested_ = false;
  std::array<InspectedPixel, 2> inspection_targets_;  // indexed by InspectionTarget
  std::vector<std::promise<FilmCopy>> copies_;
  std::shared_ptr<const LightGroups> groups_;  // the current frame's light groups
  std::shared_ptr<LoadedScene> groups_scene_;
  std::optional<RelightRequest> relighting_;
  ViewClock::time_point relight_pause_end_;  // the frame waits until this time, because the user
                                             // is probably still changing the light

  std::atomic<DisplayMode> display_mode_{DisplayMode()};
  std::atomic<bool> pause_requested_{false};  // another thread is waiting for the next pause

  // Only the rendering thread uses the following members.
  std::unique_ptr<PreparedSettings> prepared_;
  ViewSettings prepared_for_;
  LiveDenoiser denoiser_;
  std::unique_ptr<ViewFrame> frame_;
  EnvironmentEdit environment_;  // the environment that was last read from a file
  MemoryReservation environment_memory_;
  std::optional<WorkerThreads> workers_;
  std::optional<tbb::task_arena> arena_;
  std::unique_ptr<LowPriorityWorkers> low_priority_;
  int threads_ = 0;  // number of threads requested for workers_

  std::thread thread_;
};

}  // namespace emberline
