// Renders one frame: checks the frame's options, renders the frame and writes its files and report.
// Call the functions of CommandFrame in the order of their declaration. With --replay, replay() is
// the last call; otherwise skip it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/files/register.h"
#include "renderer/app/render_run.h"
#include "renderer/engine/render_job.h"
#include "renderer/engine/render_plan.h"
#include "renderer/output/frame_checkpoint.h"
#include "renderer/output/outputs.h"
#include "renderer/output/remote_viewer.h"
#include "renderer/output/report.h"
#include "renderer/output/report_pictures.h"
#include "renderer/output/sample_plan_file.h"
#include "renderer/output/snapshots.h"

namespace emberline {

class CommandFrame {
 public:
  // Checks names, ranges and paths, and opens the outputs. If a later step fails, no unfinished
  // output file remains. `run` and `options` must outlive the frame.
  CommandFrame(RenderRun& run, const RenderOptions& options);

  void load();
  void build();
  // Prints the ray and the value of the sample that --replay names. Throws UsageError if the
  // sample's address is malformed or outside the frame. Returns kExitDone, or kExitRenderFailed if
  // the value is not finite.
  int replay();
  // Opens the checkpoint and loads what an earlier run left in it.
  void resume();
  void render();
  void write();
  int report();  // returns the exit code
  // Replaces write() and report() for a pilot, a cheap frame that measures the noise of the frame
  // `planned`. Writes the sample counts for `planned` to `path`. Returns the exit code, which is
  // kExitStopped if the pilot was stopped.
  int write_plan(const RenderOptions& planned, const std::string& path);

  const RenderReport& result() const { return report_; }  // valid after report()

 private:
  class FrameSink;

  void open_outputs();
  void open_snapshots();
  void denoise();
  // Whether rendering or denoising was stopped.
  bool unfinished() const { return report_.counters.stopped || denoising_stopped_; }
  void add_light_groups(const LightGroups& groups);
  void on_picture_changed(const JobProgress& now, const LivePicture& picture);
  bool is_forecast_due(double elapsed_s) const;
  void update_forecast(double elapsed_s);
  // Whether a stopped bucket driver left pixels without samples, which are written as black.
  bool has_holes() const;
  void report_holes() const;
  int exit_code() const;
  double part_of_frame() const { return 1.0 / plan_.driver_settings.part.count; }
  std::vector<std::string> failed_outputs() const;
  void end_checkpoint();
  void write_reports();
  std::optional<double> allotted_seconds() const;

  RenderRun& run_;
  const RenderOptions& options_;
  RenderReport report_;
  const OutputSettings output_settings_;
  const std::optional<SamplePlanFile> sample_plan_;
  const RenderPlan plan_;
  FileRegister files_;
  LoadProgress progress_;
  MemoryReservation memory_;            // for film and outputs
  MemoryReservation reference_memory_;  // for --reference
  StopRequest stop_;
  bool denoising_stopped_ = false;  // a signal stopped denoising
  std::optional<SnapshotRecorder> snapshots_;
  std::optional<FrameOutputs> outputs_;
  std::optional<ReportPictures> pictures_;
  Camera camera_;
  SceneLayers layers_;
  std::optional<ReadPose> read_pose_;  // set from load() until build()
  std::unique_ptr<RenderJob> job_;     // set by build()
  RenderResult result_;
  std::optional<RemoteViewer> viewer_;
  FrameCheckpoint checkpoint_;
  std::optional<RenderClock> clock_;
  std::optional<ForecastReport> logged_forecast_;
  std::optional<double> expected_s_;  // total rendering time, by the latest forecast
  double forecast_at_s_ = 0;          // rendering time when that forecast was made
  WriteAttempts attempts_, snapshot_attempts_;
};

// Renders one frame of the run. Returns nullopt if a stop signal arrived before the frame began to
// render.
std::optional<RenderReport> render_frame(RenderRun& run, const RenderOptions& options);

}  // namespace emberline
