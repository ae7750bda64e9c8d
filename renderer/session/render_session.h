// Renders a scene in the background, again after every change. It depends on neither a window nor a
// graphics library, so tests and benchmarks use it too.
//
// One thread owns it and calls everything here. No call blocks for more than about a millisecond,
// except the destructor. README.md describes the session's threads and how an edit is processed.
//
// User errors are not fatal: load_status() reports those of scenes, problem() all others, and the
// previous picture stays.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "renderer/core/memory_budget.h"
#include "renderer/description/scene_edits.h"
#include "renderer/session/listed_scene.h"
#include "renderer/session/session_picture.h"
#include "renderer/session/view_settings.h"

namespace emberline {

class PicturePublisher;
class SceneLoader;
class TaskThread;
class ViewRenderer;
struct FilmCopy;
struct LoadedScene;

class RenderSession {
 public:
  explicit RenderSession(ViewSettings settings);
  // Stops all work and waits for its end, including files that are being written.
  ~RenderSession();

  // Loads in the background, with environment and camera from the settings' options. The previous
  // scene stays until then. Cancels an earlier load.
  void open(const std::string& scene, const std::string& edits_file = {});
  void cancel_load();
  // Call after each on_change(). A loaded scene is adopted only here, so that edits of one scene
  // are never applied to another: scene(), edits() and edit() change nowhere else by themselves.
  LoadStatus load_status();
  std::shared_ptr<const ListedScene> scene() const;  // null before the first
  std::shared_ptr<MemoryBudget> memory()
      const;  // of the whole session; null before the first scene

  const ViewSettings& settings() const { return settings_; }
  // Accepts any combination. problem() names an invalid one (such as a fixed-count sampler with an
  // adaptive driver), and nothing renders until it is corrected. Only settings that affect samples
  // restart the frame: display, overlays with existing channels, and `paused` do not.
  void set_settings(const ViewSettings& settings);

  // The number of the newest edit, counting settings and scenes; see SessionPicture::edit.
  uint64_t edit() const { return edit_; }
  // All differences from the file, as last set or opened.
  const SceneEdits& edits() const { return edits_; }
  // Throws InputError for edits that do not fit the scene and then changes nothing. `solo` switches
  // all other lights off without becoming part of saved edits. An environment file without an image
  // is read in the background. Does nothing without a scene.
  void set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo = std::nullopt);

  // Null before the first.
  std::shared_ptr<const SessionPicture> picture() const;
  // Keeps an older picture for comparison, graded in the background with the current display
  // settings unless it has an overlay. Null: no comparison.
  void compare_with(std::shared_ptr<const SessionPicture> comparison);
  // Null until graded; on_change() is called then.
  std::shared_ptr<const SessionPicture> graded_comparison() const;
  // Why the newest edit has no picture, worded as on the command line; empty if nothing is wrong.
  std::string problem() const;
  // Registers `wake`, which a thread of the session calls when a picture, load status, problem or
  // inspection has changed. It must only wake the owner, not call the session. It is never called
  // after on_change({}) has returned.
  void on_change(std::function<void()> wake);

  // Returns what is known of the pixel and requests the rest: call again after on_change(). Absent
  // outside the picture, or before the first.
  std::optional<PixelInspection> inspect(int x, int y);
  // Ends the inspection of a pixel.
  void end_inspection();
  // Selects the pixel to explain, independent of inspect(). Later frames record its whole history,
  // the current frame from now on.
  void pick(const std::optional<Vec2i>& pixel);
  // As inspect(), for the picked pixel.
  std::optional<PixelInspection> picked() const;

  // Saves the current picture in the background: .exr with its channels, .png or .jpg. The future
  // may be discarded; it throws RenderError, or UsageError, for example for an input file of the
  // scene.
  std::future<void> save(const std::string& path);
  // Throws UsageError immediately for an overlay that is not a heatmap.
  std::future<void> save_heatmap(const std::string& path, ViewOverlay quantity);
  // Saves the edits for `render --edits`, including a view chosen by the settings' options.
  std::future<void> save_edits(const std::string& path);

 private:
  void post(bool only_edits);
  void adopt(std::shared_ptr<LoadedScene> loaded);
  std::future<void> save_film(const std::string& path,
                              const std::function<void(const FilmCopy&)>& write);
  std::future<void> save_in_background(const std::string& path, const std::function<void()>& write);
  std::optional<PixelInspection> inspection_at(const Vec2i& at, bool picked) const;

  // The newest request. All other state belongs to the threads of the last members.
  ViewSettings settings_;
  ViewSettings rendered_settings_;  // of the newest request
  uint64_t edit_ = 0;
  std::shared_ptr<LoadedScene> scene_;
  SceneEdits edits_;
  std::optional<LightEdit> solo_;
  std::optional<Vec2i> inspected_, picked_;

  // Destroyed in reverse order, since each may call the earlier ones until it ends.
  const std::unique_ptr<PicturePublisher> publisher_;
  const std::unique_ptr<TaskThread> writer_;
  const std::unique_ptr<SceneLoader> loader_;
  const std::unique_ptr<ViewRenderer> renderer_;
};

}  // namespace emberline
