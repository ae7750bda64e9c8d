// One frame of a session: from an edit to the last sample or to the edit that ends it.
//
// It goes through stages, each a driver with a film of its own: the region, if there is one; of
// `live` a first sample for every pixel by bisection, of `bucket` a first picture likewise; then
// the driver that goes on. The picture changes from one film to the next when the next is as good
// everywhere; buckets replace the first picture one by one.
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

// What is to be rendered: everything that was edited and set, as of one moment.
struct RenderRequest {
  uint64_t edit = 0;
  ViewClock::time_point posted;
  std::shared_ptr<LoadedScene> scene;
  SceneEdits edits;
  ViewSettings settings;
};

// The newest lights of a frame whose light groups are enough for it.
struct Relighting {
  uint64_t edit = 0;
  ViewClock::time_point posted;
  LightMix mix;
};

// A copy of what a film holds, that files can be made of.
struct FilmCopy {
  Rect crop;  // of the frame that `options` say
  AovSet aovs;
  std::vector<float> channels;  // in film_channels() order, interleaved; pixels without samples
                                // have R G B A as shown
  std::vector<float> stops;     // PixelStop; empty where it is not known
  RenderOptions options;        // that it was rendered by
};

class ViewFrame final : private RenderSink {
 public:
  // Called at a pause of the driver, while the frame stands still: may read the frame, and may
  // wait. `shown`: whether the newest picture is of this very moment.
  using Pause = std::function<void(bool shown)>;

  // All that is given must outlive the frame; the scene has the request's edits, and nobody changes
  // it. `shown_as` and `pause_wanted`, that somebody waits for the next pause, may change while the
  // frame renders. Throws what is wrong with the view.
  ViewFrame(RenderRequest request, const PreparedSettings& prepared, PicturePublisher& publisher,
            LiveDenoiser& denoiser, std::shared_ptr<StopRequest> stop,
            const std::atomic<ShownAs>& shown_as, const std::atomic<bool>& pause_wanted,
            Pause pause);
  // Before render(): keeps the lights apart, and shows them so mixed; without a mix, as they are.
  void set_lights(std::shared_ptr<const LightGroups> groups, std::optional<LightMix> mix);
  ~ViewFrame() override;

  // On the calling thread's TBB arena; of `explained`, all will be known that look_at() can tell.
  // Throws UsageError and RenderError.
  void render(std::optional<Vec2i> explained);

  // What follows, from the pause or after render().
  void show_again();
  void relight(const Relighting& lights);
  bool readable() const { return readable_ != nullptr; }
  // A region's film is no picture of the frame.
  bool whole() const { return readable_ && stage_ != Stage::kRegion; }
  FilmCopy copy() const;
  // With the driver's explanation, if asked for.
  PixelInspection look_at(int x, int y, bool explained) const;
  // Time spent waiting in a pause is nobody's pace.
  void exclude_time(ViewClock::duration waited) { waited_ += waited; }

  bool has_shown() const { return shown_; }

 private:
  enum class Stage : uint8_t { kRegion, kFirst, kMain };

  void tile_begun(const Rect& pixels) override;
  void tile_finished(const FilmTile& tile) override;
  void picture_changed(const JobProgress& progress, const LivePicture& picture) override;
  bool picture_wanted() const override;
  std::optional<uint64_t> picture_wanted_at() const override;
  PixelStop stop_cause() const override { return stop_->cause(); }

  void render_region();
  RenderCounters render_stage(Stage stage, std::unique_ptr<RenderJob>& job, const std::string& name,
                              const Rect& crop, uint32_t samples_per_pixel);
  void begin_buckets();
  void reserve(const Rect& pixels, uint64_t bytes_per_pixel);
  bool first_is_enough() const;
  bool complete() const;
  void finish(const RenderCounters& counters);
  void look_at_buckets();
  void buckets_changed();
  bool time_is_over(double now_s) const;
  void check_time_limit();
  double seconds() const;  // of rendering, pauses left out
  bool due() const;
  bool due_by_time(double now_s) const;
  void show();
  void denoise(ShownPicture& picture);
  std::string draw(const std::shared_ptr<const Grading>& grading, ShownPicture& picture);
  void resolve_whole(std::span<float> rgba) const;
  DriverFacts driver_facts() const;
  const LivePicture* region_picture() const;
  const LivePicture& picture_of(int x, int y) const;  // that a pixel is shown from
  PixelStop stop_at(int x, int y) const;
  std::vector<float> stops() const;

  RenderRequest request_;
  const PreparedSettings& prepared_;
  PicturePublisher& publisher_;
  LiveDenoiser& denoiser_;
  const std::shared_ptr<StopRequest> stop_;
  const std::atomic<ShownAs>& shown_as_;
  const std::atomic<bool>& pause_wanted_;
  const Pause pause_;
  const Rect crop_;
  const Camera camera_;

  Stage stage_ = Stage::kMain;
  std::string stage_name_;  // its driver's
  std::stop_source stage_end_;
  std::optional<Vec2i> explained_;
  std::unique_ptr<RenderJob> region_, first_, main_;
  std::optional<BucketPicture> bucket_picture_;
  MemoryReservation memory_;  // of films and pictures
  // What is shown and looked at, from which driver, and how far that is.
  const LivePicture* readable_ = nullptr;
  RenderJob* shown_render_ = nullptr;
  std::string shown_name_;
  JobProgress progress_;
  bool finished_ = false;
  std::shared_ptr<const LightGroups> groups_;
  std::optional<LightMix> mix_;

  // When pictures are due.
  const ViewClock::time_point started_ = ViewClock::now();
  ViewClock::duration waited_{0};
  bool shown_ = false, complete_shown_ = false;
  bool showable_ = true;  // what the driver has, which may be less than what is shown
  double shown_at_s_ = 0, cost_s_ = 0;
};

}  // namespace emberline
