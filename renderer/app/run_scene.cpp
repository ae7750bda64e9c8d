#include "renderer/app/run_scene.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/frame_scene.h"

namespace emberline {

void RunScene::load(const RenderOptions& options, const SceneBuildOptions& build,
                    LoadProgress& progress) {
  const std::optional<double> time = chosen_time(options);
  if (is_built() && (!scene_->can_pose() || time == time_)) return;
  time_ = time;
  stands_ = false;
  read_.reset();
  if (scene_ && scene_->can_pose()) {
    read_.emplace(scene_->read(options, edits_, progress));
  } else {
    read(options, build, progress);
  }
  RenderOptions still = options;
  still.turntable.reset();
  camera_ = choose_camera(still, read_->description(), read_->edits());
  if (options.turntable) bounds_ = framed_bounds(read_->description());
}

void RunScene::read(const RenderOptions& options, const SceneBuildOptions& build,
                    LoadProgress& progress) {
  scene_.reset();
  failed_ = !was_built_;
  loaded_ = LoadedFiles(options, progress);
  *inputs_ = nullptr;
  edits_ = load_edits(options, progress);
  read_.emplace(options, edits_, OpenOptions{.build = build, .poses = frames_ && time_}, progress);
  files_ = read_->description().files;
  loaded_.add(files_);
  failed_ = false;
}

void RunScene::build(LoadProgress& progress) {
  if (is_built()) return;
  failed_ = !was_built_;
  if (scene_) {
    scene_->pose(*std::exchange(read_, std::nullopt), progress);
  } else {
    scene_ = std::move(*read_).build(progress);
    read_.reset();
  }
  failed_ = false;
  was_built_ = stands_ = true;
  warnings_ = warnings_so_far().size();
}

const nlohmann::json& RunScene::inputs(const RenderOptions& options, LoadProgress& progress) {
  if (inputs_->is_null()) *inputs_ = loaded_.fingerprints(options, progress);
  return *inputs_;
}

CameraDescription RunScene::camera(const RenderOptions& options) const {
  return turned(camera_, options, bounds_);
}

void RunScene::register_inputs(FileRegister& files) const {
  if (!edits_.environment.file.empty()) {
    files.read(edits_.environment.file, "it is the environment of --edits");
  }
  files.read(files_, "the scene reads");
}

void RunScene::report(RenderReport& report) const {
  report.camera = camera_.name;
  report.coverage = scene_->coverage();
  report.repairs = scene_->repairs();
  report.features = scene().features();
  report.memory = scene().memory();
  report.budget = limits_.memory;
}

}  // namespace emberline
