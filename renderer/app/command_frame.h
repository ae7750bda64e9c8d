// One frame, from options to files and report, in the order of its functions.
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
#include "renderer/output/snapshots.h"

namespace emberline {

class CommandFrame {
 public:
  // Finds whatever is wrong with names, ranges and paths, and opens the outputs: they leave no
  // trace if what follows fails. Both outlive the frame.
  CommandFrame(RenderRun& run, const RenderOptions& options);

  void load();
  void build();
  // Prints the ray and the value of the sample that --replay names. Throws UsageError for a
  // malformed or outside address. Returns kExitDone, or kExitRenderFailed if the value is not
  // finite.
  int replay();
  // Takes the checkpoint, and what an earlier run has left in it.
  void resume();
  void render();
  void write();
  int report();  // the exit code

  const RenderReport& result() const { return report_; }  // after report()

 private:
  class Watcher;

  void open_outputs();
  void open_snapshots();
  void denoise();
  // Not done, or its picture is not.
  bool unfinished() const { return report_.counters.stopped || half_denoised_; }
  void add_light_groups(const LightGroups& groups);
  void note_picture(const JobProgress& now, const LivePicture& picture);
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
  const RenderPlan plan_;
  FileRegister files_;
  LoadProgress progress_;
  MemoryReservation memory_;            // of film and outputs
  MemoryReservation reference_memory_;  // of --reference
  StopRequest stop_;
  bool half_denoised_ = false;  // a signal stopped the pass
  std::optional<SnapshotRecorder> snapshots_;
  std::optional<FrameOutputs> outputs_;
  std::optional<ReportPictures> pictures_;
  Camera camera_;
  SceneLayers layers_;
  std::optional<ReadPose> read_;    // from load() to build()
  std::unique_ptr<RenderJob> job_;  // from build() on
  RenderResult result_;
  std::optional<RemoteViewer> viewer_;
  FrameCheckpoint checkpoint_;
  std::optional<RenderClock> clock_;
  WriteAttempts attempts_, snapshot_attempts_;
};

// One frame of the run: its report. Nothing where a signal has come before it rendered, once the
// run takes signals as requests.
std::optional<RenderReport> render_frame(RenderRun& run, const RenderOptions& options);

}  // namespace emberline
