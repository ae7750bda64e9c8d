// What stands behind the interface's objects.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "renderer/api/emberline.h"
#include "renderer/description/framing.h"
#include "renderer/description/scene_edits.h"
#include "renderer/engine/frame_settings.h"
#include "renderer/engine/open_scene.h"
#include "renderer/engine/run_limits.h"
#include "renderer/output/checkpoint_head.h"
#include "renderer/output/outputs.h"
#include "renderer/scene/build_scene.h"
#include "renderer/statistics/study/options.h"

namespace emberline::api {

struct Settings::State {
  FrameSettings settings;
};

struct Scene::State {
  State(const std::string& path, const Settings& given, const Resources& resources,
        const std::stop_token& stop, bool poses);
  void pose(const FrameSettings& wanted, const std::stop_token& stop);
  void edit(std::string_view json, const Environment& environment);

  Resources resources;
  FrameSettings settings;  // that it was opened with, and posed with
  LoadLimits limits;
  SceneBuildOptions build;
  WorldBounds bounds;
  AnimationEdit animation;  // that it was opened with
  LoadedFiles files;
  // The fingerprint of what edit() was last given; empty: of no edits. Absent: it was not called.
  std::optional<std::string> edited;
  std::unique_ptr<OpenScene> open;
};

// What the file of a picture has beside its pixels.
struct RenderedPicture::Record {
  OutputSettings output;
  SceneLayers layers;
};

struct StudyRequest::State {
  StudyOptions options;
};

struct Access {
  using SceneState = Scene::State;
  using Record = RenderedPicture::Record;
  static std::shared_ptr<const Record>& of(RenderedPicture& picture) { return picture.record_; }
  static const Record* of(const RenderedPicture& picture) { return picture.record_.get(); }
  static const StudyOptions& of(const StudyRequest& request) { return request.state_->options; }
  static const FrameSettings& of(const Settings& settings) { return settings.state_->settings; }
  static FrameSettings& of(Settings& settings) { return settings.state_->settings; }
  static const SceneState& of(const Scene& scene) { return *scene.state_; }
};

int arena_threads(const Resources& resources);

}  // namespace emberline::api
