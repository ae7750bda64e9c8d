// One frame of a session: from an edit to the last sample, or to the edit that replaces it.
//
// A frame is rendered in stages. Each stage is a job with its own driver and film. The stages are:
// the region, if there is one; for `live` and `bucket`, a first picture by bisection; then the main
// driver. The displayed picture switches to the next stage's film once that film is at least as
// good everywhere. Buckets instead replace the first picture one by one.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/engine/live_denoiser.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/stop_request.h"
#include "renderer/scene/camera.h"
#include "renderer/session/bucket_picture.h"
#include "renderer/session/loaded_scene.h"
#include "renderer/session/picture_publisher.h"
#include "renderer/session/prepared_settings.h"

namespace emberline {

using ViewClock = std::chrono::steady_clock;

// The edits and settings that a frame shows.
struct RenderRequest {
  uint64_t edit = 0;
  ViewClock::time_point posted;
  std::shared_ptr<LoadedScene> scene;
  SceneEdits edits;
  ViewSettings settings;
};

// A change of lights that the current frame can show by mixing its light groups.
struct RelightRequest {
  uint64_t edit = 0;
  ViewClock::time_point posted;
  LightMix mix;
};

// A copy of a film, for writing files.
struct FilmCopy {
  Rect crop;  // in the frame described by `options`
  AovSet aovs;
  std::vector<float> channels;  // film_channels(), interleaved; unsampled pixels: RGBA as displayed
  std::vector<float> stops;     // PixelStop; empty if unknown
  RenderOptions options;        // the options used for rendering
};

class ViewFrame final : private RenderSink {
 public:
  // The frame calls this at each pause of the driver. The callback may read the frame and may wait.
  // `is_published` says whether the newest picture shows the present state.
  using Pause = std::function<void(bool is_published)>;

  // All references must outlive the frame. The request's edits must have been applied to the scene,
  // which must not change. `display_mode` and `pause_requested` may change during rendering;
  // `pause_requested` says that another thread is waiting for a pause. Throws UsageError and
  // InputError if the view is invalid.
  ViewFrame(RenderRequest request, const PreparedSettings& prepared, PicturePublisher& publisher,
            LiveDenoiser& denoiser, std::shared_ptr<StopRequest> stop,
            const std::atomic<DisplayMode>& display_mode, const std::atomic<bool>& pause_requested,
            Pause pause);
  // Call before render(). Makes the frame record these light groups. The picture shows the groups
  // mixed by `mix` or, if `mix` is absent, the light as rendered.
  void set_lights(std::shared_ptr<const LightGroups> groups, std::optional<LightMix> mix);
  ~ViewFrame() override;

  // Renders in the calling thread's TBB arena. Records the history of the pixel `explained` for
  // inspect_pixel(). Throws UsageError and RenderError.
  void render(std::optional<Vec2i> explained);

  // The functions below may be called during the pause callback or after render().
  void republish();
  void relight(const RelightRequest& lights);
  bool has_picture() const { return live_picture_ != nullptr; }
  // Returns whether there is a picture of the whole frame, not only of the region.
  bool has_whole_picture() const { return live_picture_ && stage_ != Stage::kRegion; }
  FilmCopy copy() const;
  // If `explained` is true, adds the driver's explanation.
  PixelInspection inspect_pixel(int x, int y, bool explained) const;
  // Subtracts time that was spent waiting at a pause from the frame's time.
  void exclude_time(ViewClock::duration waited) { paused_time_ += waited; }

  bool has_published() const { return published_; }

 private:
  enum class Stage : uint8_t { kRegion, kFirst, kMain };

  void tile_begun(const Rect& pixels) override;
  void tile_finished(const FilmTile& tile) override;
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override;
  bool needs_picture() const override;
  std::optional<uint64_t> next_picture_at() const override;
  PixelStop stop_cause() const override { return stop_->cause(); }

  void render_region();
  RenderCounters render_stage(Stage stage, std::unique_ptr<RenderJob>& job, const std::string& name,
                              const Rect& crop, uint32_t samples_per_pixel);
  void begin_buckets();
  void reserve(const Rect& pixels, uint64_t bytes_per_pixel);
  bool is_first_picture_sufficient() const;
  bool complete() const;
  void finish(const RenderCounters& counters);
  void update_buckets_isolated();
  void update_buckets();
  bool is_time_over(double now_s) const;
  void check_time_limit();
  double seconds() const;  // time since the start, excluding pauses
  bool is_picture_due() const;
  bool is_due_by_time(double now_s) const;
  void publish_picture();
  void denoise(SessionPicture& picture);
  std::string draw(const std::shared_ptr<const Grading>& grading, SessionPicture& picture);
  void resolve_frame(std::span<float> rgba) const;
  DriverFacts driver_facts() const;
  const LivePicture* region_picture() const;
  const LivePicture& picture_of(int x, int y) const;  // the picture that shows the pixel
  PixelStop stop_at(int x, int y) const;
  std::vector<float> stops() const;

  RenderRequest request_;
  const PreparedSettings& prepared_;
  PicturePublisher& publisher_;
  LiveDenoiser& denoiser_;
  const std::shared_ptr<StopRequest> stop_;
  const std::atomic<DisplayMode>& display_mode_;
  const std::atomic<bool>& pause_requested_;
  const Pause pause_;
  const Rect crop_;
  const Camera camera_;

  Stage stage_ = Stage::kMain;
  std::string stage_name_;  // name of the stage's driver
  std::stop_source stage_stop_;
  std::optional<Vec2i> explained_;
  std::unique_ptr<RenderJob> region_, first_, main_;
  std::optional<BucketPicture> bucket_picture_;
  MemoryReservation memory_;  // for films and pictures
  // The picture that is shown and inspected, with its job, driver and progress.
  const LivePicture* live_picture_ = nullptr;
  RenderJob* live_job_ = nullptr;
  std::string live_driver_;
  JobProgress progress_;
  bool finished_ = false;
  std::shared_ptr<const LightGroups> groups_;
  std::optional<LightMix> mix_;

  // Scheduling of pictures.
  const ViewClock::time_point started_ = ViewClock::now();
  ViewClock::duration paused_time_{0};
  bool published_ = false, complete_published_ = false;
  bool may_publish_ = true;  // false while the driver's picture is worse than the displayed one
  double published_at_s_ = 0, cost_s_ = 0;
};

}  // namespace emberline
