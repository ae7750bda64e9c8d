#include "renderer/app/run_scene.h"

#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/frame/frame_scene.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/scene/build_scene.h"

namespace emberline {

void RunScene::load(const RenderOptions& options, bool fingerprints, LoadProgress& progress) {
  if (is_built()) return;
  failed_ = true;
  if (fingerprints) inputs_ = input_fingerprints(options, progress);
  read(options, progress);
  failed_ = false;
}

void RunScene::read(const RenderOptions& options, LoadProgress& progress) {
  SceneEdits edits = load_edits(options, progress);
  description_ = load_scene(options, progress, edits.variant.has_value(), need_tangents(edits));
  edited_environment_ = edits.environment.file;
  files_ = description_.files;
  choose_variant(options, description_, edits);
  if (edits != SceneEdits() || options.light_groups) apply(edits, description_);
  coverage_ = description_.coverage;
  repairs_ = description_.repairs;
  RenderOptions still = options;
  still.turntable.reset();
  camera_ = choose_camera(still, description_, edits);
  if (options.turntable) bounds_ = world_bounds(description_);
}

void RunScene::build(const RenderOptions& options, const SceneBuildOptions& build,
                     LoadProgress& progress) {
  if (is_built()) return;
  failed_ = true;
  if (options.light_groups) groups_.emplace(outline(description_));
  scene_ = build_scene(std::exchange(description_, {}), build, progress);
  failed_ = false;
  warnings_ = warnings_so_far().size();
}

void RunScene::check_inputs(const RenderOptions& options, LoadProgress& progress) {
  if (checked_) return;
  if (inputs_ != input_fingerprints(options, progress)) {
    throw InputError(options.scene, "its files have changed while they were read; start again");
  }
  checked_ = true;
}

CameraDescription RunScene::camera(const RenderOptions& options) const {
  return options.turntable ? turned(camera_, *options.turntable, bounds_) : camera_;
}

void RunScene::register_inputs(FileRegister& files) const {
  if (!edited_environment_.empty()) {
    files.read(edited_environment_, "it is the environment of --edits");
  }
  files.read(files_, "the scene reads");
}

void RunScene::report(RenderReport& report) const {
  report.camera = camera_.name;
  report.coverage = coverage_;
  report.repairs = repairs_;
  report.features = scene_->features();
  report.memory = scene_->memory();
  report.budget = limits_.memory;
}

}  // namespace emberline
