// Renders a scene in the background, and again after every change. A RenderSession needs no window
// and no graphics library, so tests and benchmarks also use it.
//
// Only the thread that owns the session may call its functions. No call except the destructor
// blocks for more than about a millisecond. README.md describes the session's threads and how an
// edit is processed.
//
// User errors are not fatal. load_status() reports errors in loading a scene, and problem() reports
// all other errors. The previous picture stays.
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
  // Stops all work and waits until it has ended. Files that are being written are finished.
  ~RenderSession();

  // Loads the scene in the background, with environment and camera from the settings' options.
  // Meanwhile the previous scene stays. Cancels an earlier load.
  void open(const std::string& scene, const std::string& edits_file = {});
  void cancel_load();
  // Call whenever the on_change() callback has been called. Only this function adopts a loaded
  // scene, so that edits of one scene are never applied to another. Between two calls, scene(),
  // edits() and edit() never change by themselves.
  LoadStatus load_status();
  std::shared_ptr<const ListedScene> scene() const;  // null before the first scene
  std::shared_ptr<MemoryBudget> memory()
      const;  // the session's budget for all scenes; null before the first scene

  const ViewSettings& settings() const { return settings_; }
  // Accepts any combination of settings. If the combination is invalid, such as a fixed-count
  // sampler with an adaptive driver, problem() says why, and nothing is rendered until the settings
  // are corrected. Only settings that affect samples restart the frame. The display, an overlay
  // whose channel exists, and `paused` do not.
  void set_settings(const ViewSettings& settings);

  // Returns the number of the newest edit. Changes of settings and new scenes count as edits; see
  // SessionPicture::edit.
  uint64_t edit() const { return edit_; }
  // Returns all differences from the file: the edits that were set last or, if none were set, those
  // read when the scene was opened.
  const SceneEdits& edits() const { return edits_; }
  // Throws InputError and changes nothing if the edits do not fit the scene. `solo` switches all
  // other lights off, but is not part of saved edits. An environment file whose image is not given
  // is read in the background. Does nothing without a scene.
  void set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo = std::nullopt);

  // Returns the newest picture, or null before the first picture.
  std::shared_ptr<const SessionPicture> picture() const;
  // Sets an older picture for comparison; null ends the comparison. The picture is graded in the
  // background with the current display settings, unless it has an overlay.
  void compare_with(std::shared_ptr<const SessionPicture> comparison);
  // Returns null until the picture for comparison has been graded. Then the on_change() callback is
  // called.
  std::shared_ptr<const SessionPicture> graded_comparison() const;
  // Returns why the newest edit has no picture, in the words of the command line. The text is empty
  // if nothing is wrong.
  std::string problem() const;
  // Registers `wake`, which a thread of the session calls when a picture, load status, problem or
  // inspection has changed. `wake` must only wake the owner, not call the session. `wake` is never
  // called after on_change({}) has returned.
  void on_change(std::function<void()> wake);

  // Returns what is known about the pixel and requests the rest; call again after the on_change()
  // callback has been called. Returns nullopt outside the picture and before the first picture.
  std::optional<PixelInspection> inspect(int x, int y);
  // Ends the inspection of a pixel.
  void end_inspection();
  // Selects the pixel to explain, independently of inspect(). Later frames record the pixel's whole
  // history; the current frame only records what happens from now on.
  void pick(const std::optional<Vec2i>& pixel);
  // Like inspect(), for the picked pixel.
  std::optional<PixelInspection> picked() const;

  // Saves the current picture in the background as .exr with its channels, .png or .jpg. The future
  // may be discarded. Its get() throws RenderError, or UsageError, for example if `path` is an
  // input file of the scene.
  std::future<void> save(const std::string& path);
  // Throws UsageError immediately for an overlay that is not a heatmap.
  std::future<void> save_heatmap(const std::string& path, ViewOverlay quantity);
  // Saves the edits for `render --edits`, including the view if the settings' options chose it.
  std::future<void> save_edits(const std::string& path);

 private:
  void post(bool only_edits);
  void adopt(std::shared_ptr<LoadedScene> loaded);
  std::future<void> save_film(const std::string& path,
                              const std::function<void(const FilmCopy&)>& write);
  std::future<void> save_in_background(const std::string& path, const std::function<void()>& write);
  std::optional<PixelInspection> inspection_at(const Vec2i& at, bool picked) const;

  // The newest request. All other state belongs to the threads that the last members own.
  ViewSettings settings_;
  ViewSettings rendered_settings_;  // the settings in the newest request
  uint64_t edit_ = 0;
  std::shared_ptr<LoadedScene> scene_;
  SceneEdits edits_;
  std::optional<LightEdit> solo_;
  std::optional<Vec2i> inspected_, picked_;

  // The order of these members matters for destruction. Until its thread has ended, each member may
  // call the members declared before it.
  const std::unique_ptr<PicturePublisher> publisher_;
  const std::unique_ptr<TaskThread> writer_;
  const std::unique_ptr<SceneLoader> loader_;
  const std::unique_ptr<ViewRenderer> renderer_;
};

}  // namespace emberline
