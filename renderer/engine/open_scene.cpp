#include "renderer/engine/open_scene.h"

#include <utility>

#include "renderer/description/catcher_plane.h"
#include "renderer/engine/frame_scene.h"
#include "renderer/engine/scene_file.h"

namespace emberline {

ReadScene::ReadScene(const FrameSettings& settings, SceneEdits edits, const OpenOptions& options,
                     std::shared_ptr<SceneSource> source)
    : settings_(settings), edits_(std::move(edits)), options_(options), source_(std::move(source)) {
  apply_animation(edits_.animation, settings_);
  source_->begin();
}

ReadScene::ReadScene(const FrameSettings& settings, SceneEdits edits, const OpenOptions& options,
                     LoadProgress& progress)
    : ReadScene(settings, std::move(edits), options,
                std::make_shared<SceneSource>(progress.budget())) {
  source_->open(settings_, progress,
                {.variants = options.edits || edits_.variant,
                 .tangents = need_tangents(edits_),
                 .nodes = options.nodes});
  read({}, progress);
  if (!options.poses) hint_at_rest(settings_, description_);
  const bool may_pose = options.poses && !description_.animations.empty();
  if (!may_pose) source_->close();
  if (!options.edits) options_.build.editable = may_pose;
  options_.build.posable = may_pose;
}

ReadScene::~ReadScene() {
  if (source_) source_->roll_back();
}

void ReadScene::read(std::span<const uint64_t> held, LoadProgress& progress) {
  description_ = source_->file().pose(settings_, held, progress);
  if (const auto& plane = settings_.catcher_plane) add_catcher_plane(plane->height, description_);
  choose_variant(settings_, description_, edits_);
  if (options_.edits) return;
  if (edits_ != SceneEdits() || settings_.light_groups) apply(edits_, description_);
}

OpenScene::Parts::Parts(const ReadScene& read) {
  const FrameSettings& settings = read.settings_;
  const SceneDescription& scene = read.description_;
  if (settings.light_groups) light_groups.emplace(copy_without_geometry(scene));
  if (!settings.cryptomattes.empty()) {
    cryptomattes.emplace(scene, parse_cryptomattes(settings.cryptomattes));
  }
  if (has_catchers(settings) || !settings.holdouts.empty()) {
    roles.emplace(scene, settings.catchers, settings.holdouts);
  }
}

SceneParts OpenScene::Parts::pointers() const {
  return {.light_groups = light_groups ? &*light_groups : nullptr,
          .cryptomattes = cryptomattes ? &*cryptomattes : nullptr,
          .roles = roles ? &*roles : nullptr};
}

std::unique_ptr<OpenScene> ReadScene::build(LoadProgress& progress) && {
  std::unique_ptr<OpenScene> open(new OpenScene(options_, settings_, source_));
  open->parts_ = OpenScene::Parts(*this);
  open->coverage_ = description_.coverage;
  open->repairs_ = description_.repairs;
  open->build(*this, progress);
  std::exchange(source_, nullptr)->commit();
  return open;
}

void OpenScene::build(ReadScene& read, LoadProgress& progress) {
  SceneDescription description = std::exchange(read.description_, {});
  if (options_.edits) {
    editable_.emplace(std::move(description), options_.build, progress);
  } else {
    scene_ = build_scene(std::move(description), options_.build, progress);
  }
}

FrameSettings OpenScene::posed(FrameSettings settings) const {
  settings.animation = settings_.animation;
  settings.time = settings_.time;
  settings.frame = settings_.frame;
  settings.fps = settings_.fps;
  settings.shutter = settings_.shutter;
  return settings;
}

const std::shared_ptr<MemoryBudget>& OpenScene::memory() const { return source_->budget(); }

bool OpenScene::can_pose() const { return source_->is_open(); }

ReadScene OpenScene::read(const FrameSettings& settings, SceneEdits edits, LoadProgress& progress) {
  ReadScene read(settings, std::move(edits), options_, source_);
  read.read(scene().mesh_keys(), progress);
  return read;
}

bool OpenScene::repose(ReadScene& read, LoadProgress& progress) {
  SceneDescription description = std::exchange(read.description_, {});
  return editable_ ? editable_->repose(std::move(description), read.edits_, progress)
                   : repose_scene(scene_, std::move(description), options_.build, progress);
}

bool OpenScene::pose(ReadScene read, LoadProgress& progress) {
  Parts parts(read);
  CoverageReport coverage = read.description_.coverage;
  const LoadRepairs repairs = read.description_.repairs;
  const bool reposed = repose(read, progress);
  if (!reposed) {
    source_->roll_back();
    source_->begin();
    read.read({}, progress);
    OpenScene rebuilt(options_, read.settings_, source_);
    rebuilt.build(read, progress);
    if (editable_) rebuilt.editable_->set(read.edits_);
    scene_ = std::move(rebuilt.scene_);
    editable_ = std::move(rebuilt.editable_);
  }
  std::exchange(read.source_, nullptr)->commit();
  settings_ = std::move(read.settings_);
  parts_ = std::move(parts);
  coverage_ = std::move(coverage);
  repairs_ = repairs;
  return reposed;
}

}  // namespace emberline
