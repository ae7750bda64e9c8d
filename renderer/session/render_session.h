// A scene that renders in the background, again after every change. The window shows it; it knows
// neither a window nor a graphics library, so tests and benchmarks use it too.
//
// One thread owns it and calls everything here. No call blocks for more than about a millisecond,
// except the destructor. README.md describes the session's threads and the way of an edit.
//
// A user's mistake ends nothing: load_status() reports it for scenes, problem() for all else, and
// the previous picture stays.
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
#include "renderer/session/shown_picture.h"
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
  // Stops all work and waits for its end, also for files that are being written.
  ~RenderSession();

  // Loads in the background, with environment and camera of the settings' options. The previous
  // scene stays until the new one has loaded. Cancels a scene that is still loading.
  void open(const std::string& scene, const std::string& edits_file = {});
  void cancel_load();
  // Call after each on_change(). A loaded scene is adopted here: scene(), edits() and edit() change
  // by themselves nowhere else, so edits of one scene are never applied to another.
  LoadStatus load_status();
  std::shared_ptr<const ListedScene> scene() const;  // null before the first
  std::shared_ptr<MemoryBudget> memory() const;      // of the whole session; null before the first

  const ViewSettings& settings() const { return settings_; }
  // Accepts any combination. problem() names an impossible one (a sampler of fixed counts with an
  // adaptive driver), and nothing renders until it is corrected. Only settings of samples restart
  // the frame: display, overlays whose channels exist, and `paused` do not.
  void set_settings(const ViewSettings& settings);

  // The number of the newest edit, settings and scenes included: what ShownPicture::edit reaches.
  uint64_t edit() const { return edit_; }
  // All differences from the file, as set or opened last.
  const SceneEdits& edits() const { return edits_; }
  // Throws InputError for edits that do not fit the scene, and changes nothing then. `solo`:
  // switches all other lights off, without becoming part of saved edits. An environment file
  // without an image is read in the background. Does nothing without a scene.
  void set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo = std::nullopt);

  // The newest picture; null before the first.
  std::shared_ptr<const ShownPicture> picture() const;
  // Keeps an older picture for comparison, graded in the background by the current display settings
  // (unless it has an overlay). Null: no comparison.
  void compare_with(std::shared_ptr<const ShownPicture> kept);
  // Null until it has been graded, after which on_change() is called.
  std::shared_ptr<const ShownPicture> compared() const;
  // Why the newest edit has no picture, in the words of the command line; empty if nothing is
  // wrong.
  std::string problem() const;
  // `wake` is called from a thread of the session when a picture, load status, problem or
  // inspection has changed. It must not call the session, only wake its owner. Never called after
  // on_change({}) has returned.
  void on_change(std::function<void()> wake);

  // Returns what is known of the pixel now, and requests the rest: call again after on_change().
  // Absent outside the picture, or before the first.
  std::optional<PixelInspection> inspect(int x, int y);
  // Ends the inspection of a pixel.
  void end_inspection();
  // Chooses the pixel to explain, independent of inspect(). Later frames record its whole history,
  // the current frame its history from now on.
  void pick(const std::optional<Vec2i>& pixel);
  // As inspect(), for the picked pixel.
  std::optional<PixelInspection> picked() const;

  // Saves the current picture in the background: .exr with its channels, .png, .jpg. The future,
  // which may be dropped, throws RenderError or UsageError, the latter also for a file of the
  // scene.
  std::future<void> save(const std::string& path);
  // Throws UsageError at once for an overlay that is no heatmap.
  std::future<void> save_heatmap(const std::string& path, ViewOverlay quantity);
  // Saves the edits for `render --edits`, including a view that the settings' options chose.
  std::future<void> save_edits(const std::string& path);

 private:
  void post(bool only_edits);
  void adopt(std::shared_ptr<LoadedScene> loaded);
  std::future<void> save_film(const std::string& path,
                              const std::function<void(const FilmCopy&)>& write);
  std::future<void> save_later(const std::string& path, const std::function<void()>& write);
  std::optional<PixelInspection> look(const Vec2i& at, bool picked) const;

  // The last request. Everything else belongs to the threads of the last members.
  ViewSettings settings_;
  ViewSettings rendered_settings_;  // of the newest request
  uint64_t edit_ = 0;
  std::shared_ptr<LoadedScene> scene_;
  SceneEdits edits_;
  std::optional<LightEdit> solo_;
  std::optional<Vec2i> inspected_, picked_;

  // In this order, since each may call those before it while it ends.
  const std::unique_ptr<PicturePublisher> publisher_;
  const std::unique_ptr<TaskThread> writer_;
  const std::unique_ptr<SceneLoader> loader_;
  const std::unique_ptr<ViewRenderer> renderer_;
};

}  // namespace emberline
