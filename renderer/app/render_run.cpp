#include "renderer/app/render_run.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "io/files/atomic_file.h"
#include "renderer/app/failure.h"
#include "renderer/core/log.h"
#include "renderer/core/version.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/report.h"

namespace emberline {
namespace {

// Runs a step that opens the scene, and turns its exceptions into UnusableScene.
template <typename Step>
auto convert_open_errors(const Step& step) {
  try {
    return step();
  } catch (const std::exception& error) {
    const Failure failure = failure_of(error);
    throw UnusableScene(failure.exit_code, failure.message);
  }
}

}  // namespace

CameraDescription PosedScene::camera_of(const FrameSettings& settings) const {
  return apply_turntable(pose.camera, open->posed(settings), pose.bounds);
}

void PosedScene::report(RenderReport& report) const {
  report.camera = pose.camera.name;
  report.coverage = open->coverage();
  report.repairs = open->repairs();
  report.features = open->scene().features();
  report.memory = open->scene().memory();
}

ReadPose RunScene::load(const RenderOptions& options, const SceneBuildOptions& build,
                        LoadProgress& progress) {
  const std::optional<double> time = pose_time(options);
  if (posed_ && (!posed_->open->can_pose() || time == posed_->pose.time)) {
    return {posed_->pose, std::nullopt};
  }
  ReadScene read =
      posed_ ? posed_->open->read(options, edits_, progress) : convert_open_errors([&] {
        return open(options, {.build = build, .poses = has_many_frames_ && time}, progress);
      });
  RenderOptions without_turntable = options;
  without_turntable.turntable.reset();
  ScenePose pose{time, choose_camera(without_turntable, read.description(), read.edits()), {}};
  if (options.turntable) pose.bounds = framed_bounds(read.description());
  return {std::move(pose), std::move(read)};
}

ReadScene RunScene::open(const RenderOptions& options, const OpenOptions& open_options,
                         LoadProgress& progress) {
  loaded_ = LoadedFiles(options, progress);
  edits_ = load_edits(options, progress);
  ReadScene read(options, edits_, open_options, progress);
  files_ = read.description().files;
  loaded_.add(files_);
  return read;
}

const PosedScene& RunScene::build(ReadPose frame, LoadProgress& progress) {
  if (!frame.read) return *posed_;
  if (posed_) {
    posed_->open->pose(*std::move(frame.read), progress);
    posed_->pose = std::move(frame.pose);
  } else {
    posed_ = convert_open_errors([&] {
      return PosedScene{(*std::move(frame.read)).build(progress), std::move(frame.pose)};
    });
  }
  posed_->warnings = warnings_so_far().size();
  return *posed_;
}

const nlohmann::json& RunScene::inputs(const RenderOptions& options, LoadProgress& progress) {
  if (inputs_->is_null()) *inputs_ = loaded_.fingerprints(options, progress);
  return *inputs_;
}

void RunScene::register_inputs(FileRegister& files) const {
  if (!edits_.environment.file.empty()) {
    files.read(edits_.environment.file, "it is the environment of --edits");
  }
  files.read(files_, "the scene reads");
}

RenderRun::RenderRun(const RenderOptions& options)
    : limits(limits_of(options.limits, options.scene)),
      scene(options.frames.size() > 1),
      options_(options) {
  log_verbose(
      fmt::format("emberline {} on {}: {}", kEmberlineVersion, host_name(), instruction_sets()));
}

void RenderRun::begin() {
  // A file at this path that another program wrote may belong to the scene. So it is not
  // overwritten before the scene is read.
  if (progress_file || !is_foreign_file(options_.progress_file)) begin_progress();
  if (workers) return;
  workers.emplace(options_.threads);
  // The arena allows more threads than cores; WorkerThreads only sets an upper limit.
  arena.emplace(workers->count());
}

void RenderRun::begin_progress() {
  if (options_.progress_file.empty() || options_.replay) return;
  if (!progress_file) progress_file.emplace(options_.progress_file);
  if (frame_position) progress_file->begin_frame(*frame_position);
}

void RenderRun::on_scene_read() {
  names.reset();
  if (!progress_file) begin_progress();
}

void RenderRun::save_settings() {
  const std::string& path = options_.save_settings;
  if (path.empty() || settings_saved_) return;
  write_file_atomically(path, settings_json(options_, path));
  settings_saved_ = true;
}

void RenderRun::next_frame() {
  first = false;
  wall = Stopwatch();
  cpu_before_s = process_cpu_seconds();
  if (const PosedScene* posed = scene.posed()) truncate_warnings(posed->warnings);
}

void RenderRun::end(int exit_code) {
  if (progress_file) progress_file->finish(exit_code);
}

}  // namespace emberline
