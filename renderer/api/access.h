// The implementation behind the interface's objects, and the mapping of internal errors to the
// interface's errors.
#pragma once

#include <memory>
#include <new>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "renderer/api/emberline.h"
#include "renderer/core/errors.h"
#include "renderer/core/load_progress.h"
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
  State(const std::string& path, const Settings& initial_settings, const Resources& resources,
        const std::stop_token& stop, bool poses);
  void pose(const FrameSettings& pose_settings, const std::stop_token& stop);
  void edit(std::string_view json, const Environment& environment);

  Resources resources;
  FrameSettings settings;  // used to load the scene, but with the current pose
  LoadLimits limits;
  SceneBuildOptions build;
  WorldBounds bounds;
  AnimationEdit animation;  // from the edits that the scene was opened with
  std::vector<AnimationDescription> animations;
  LoadedFiles files;
  // Fingerprint of the edits that edit() set last. It is empty if that call removed all edits, and
  // absent if edit() was never called.
  std::optional<std::string> edited;
  std::unique_ptr<OpenScene> open;
};

// The contents of a picture's file other than its pixels.
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
  static std::shared_ptr<const Record>& impl(RenderedPicture& picture) { return picture.record_; }
  static const Record* impl(const RenderedPicture& picture) { return picture.record_.get(); }
  static const StudyOptions& impl(const StudyRequest& request) { return request.state_->options; }
  static const FrameSettings& impl(const Settings& settings) { return settings.state_->settings; }
  static FrameSettings& impl(Settings& settings) { return settings.state_->settings; }
  static const SceneState& impl(const Scene& scene) { return *scene.state_; }
};

int arena_threads(const Resources& resources);

// Runs `work` and maps its errors to the interface's errors.
template <typename Work>
decltype(auto) translate_errors(const Work& work) {
  try {
    return work();
  } catch (const emberline::UsageError& error) {
    throw UsageError(error.what());
  } catch (const emberline::InputError& error) {
    throw InputError(error.what());
  } catch (const EmberlineError& error) {
    throw RenderError(error.what());
  } catch (const Cancelled&) {
    throw Stopped("the load was stopped");
  } catch (const std::bad_alloc&) {
    throw RenderError("out of memory");
  }
}

// Throws the internal UsageError if the command's options would reject the values.
void check_resources(const Resources& resources);
// Throws the internal UsageError if the picture, which the caller may have filled in, is invalid.
// The message begins with `context`.
void check_picture(const std::string& context, const Picture& picture);

}  // namespace emberline::api
