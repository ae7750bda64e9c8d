#include "renderer/app/run_scene.h"

#include <utility>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/frame/frame_scene.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/scene/build_scene.h"

namespace emberline {

namespace {

constexpr std::array kLoaded = {MemoryPart::kFile, MemoryPart::kGeometry, MemoryPart::kTextures,
                                MemoryPart::kLights};

}  // namespace

void RunScene::load(const RenderOptions& options, bool fingerprints, LoadProgress& progress) {
  const std::optional<double> time = chosen_time(options);
  if (is_built() && (!animated_ || time == time_)) return;
  time_ = time;
  stands_ = false;
  if (scene_ && file_) {
    posed_memory_->begin(*file_);
    try {
      return pose(options, scene_->mesh_keys(), progress);
    } catch (...) {
      posed_memory_->fail(*file_);
      throw;
    }
  }
  release();
  failed_ = !was_built_;
  if (fingerprints) inputs_ = input_fingerprints(options, progress);
  checked_ = false;
  read(options, progress);
  failed_ = false;
}

// Also of a load that has failed half-way.
void RunScene::release() {
  if (begun_ && !scene_) used_ = use();
  if (begun_) used_[0] = use()[0];
  groups_.reset();
  cryptomattes_.reset();
  roles_.reset();
  scene_.reset();
  description_ = {};
  // What the file has, it gives back itself, but for what has become the scene's.
  const uint64_t before = limits_.memory->reserved(MemoryPart::kFile);
  file_.reset();
  used_[0] -= before - limits_.memory->reserved(MemoryPart::kFile);
  for (size_t i = 0; i < kLoaded.size(); ++i) limits_.memory->give_back(kLoaded[i], used_[i]);
  before_ = used_ = {};
  before_ = use();
  begun_ = true;
}

RunScene::MemoryUse RunScene::use() const {
  MemoryUse use = {};
  for (size_t i = 0; i < kLoaded.size(); ++i) {
    use[i] = limits_.memory->reserved(kLoaded[i]) - before_[i];
  }
  return use;
}

void RunScene::read(const RenderOptions& options, LoadProgress& progress) {
  edits_ = load_edits(options, progress);
  edited_environment_ = edits_.environment.file;
  file_.emplace(options, progress, edits_.variant.has_value(), need_tangents(edits_));
  posed_memory_.emplace(limits_.memory);
  posed_memory_->begin(*file_);
  pose(options, {}, progress);
  files_ = description_.files;
  animated_ = !description_.animations.empty();
  if (!frames_ || !description_.rest_bounds) file_.reset();
}

void RunScene::pose(const RenderOptions& options, const std::vector<uint64_t>& held,
                    LoadProgress& progress) {
  RenderOptions timed = options;
  apply_animation(edits_.animation, timed);
  description_ = file_->pose(timed, held, progress);
  SceneEdits edits = edits_;
  choose_variant(options, description_, edits);
  if (edits != SceneEdits() || options.light_groups) apply(edits, description_);
  coverage_ = description_.coverage;
  repairs_ = description_.repairs;
  RenderOptions still = options;
  still.turntable.reset();
  camera_ = choose_camera(still, description_, edits);
  if (options.turntable) bounds_ = framed_bounds(description_);
}

void RunScene::build(const RenderOptions& options, const SceneBuildOptions& build,
                     LoadProgress& progress) {
  if (is_built()) return;
  failed_ = !was_built_;
  if (options.light_groups) groups_.emplace(outline(description_));
  if (!options.cryptomattes.empty()) {
    cryptomattes_.emplace(description_, parse_cryptomattes(options.cryptomattes));
  }
  if (!options.catchers.empty() || !options.holdouts.empty()) {
    roles_.emplace(description_, options.catchers, options.holdouts);
  }
  SceneBuildOptions building = build;
  building.editable = building.posable = file_.has_value();
  if (scene_) {
    repose(options, building, progress);
  } else {
    scene_ = build_scene(std::exchange(description_, {}), building, progress);
    if (file_) posed_memory_->end(*file_);
  }
  failed_ = false;
  was_built_ = stands_ = true;
  used_ = use();
  warnings_ = warnings_so_far().size();
}

void RunScene::repose(const RenderOptions& options, const SceneBuildOptions& build,
                      LoadProgress& progress) {
  try {
    if (!repose_scene(scene_, std::exchange(description_, {}), build, progress)) {
      posed_memory_->fail(*file_);
      posed_memory_->begin(*file_);
      pose(options, {}, progress);
      scene_ = build_scene(std::exchange(description_, {}), build, progress);
    }
  } catch (...) {
    posed_memory_->fail(*file_);
    throw;
  }
  posed_memory_->end(*file_);
}

void RunScene::check_inputs(const RenderOptions& options, LoadProgress& progress) {
  if (checked_) return;
  if (inputs_ != input_fingerprints(options, progress)) {
    throw InputError(options.scene, "its files have changed while they were read; start again");
  }
  checked_ = true;
}

CameraDescription RunScene::camera(const RenderOptions& options) const {
  return turned(camera_, options, bounds_);
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
