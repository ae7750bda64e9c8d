// What the window looks at: a scene that renders in the background, again whenever something is
// changed. Knows neither a window nor a graphics library, so that tests and benchmarks use it too.
//
// One thread owns it (the window's) and calls everything here; nothing blocks that thread for more
// than about a millisecond, but for the destructor. README.md has the session's own threads, and
// what becomes of an edit.
//
// What is wrong with what the user asked for ends nothing: scenes say it in load_status(), all else
// in problem(), and the picture of before stays.
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
  // Stops what is under way, and waits for it; for files that are being written, too.
  ~RenderSession();
  RenderSession(const RenderSession&) = delete;
  RenderSession& operator=(const RenderSession&) = delete;

  // Loads in the background, with the surroundings and the camera of the settings' options; the
  // scene of before stays until the new one is there. A scene that is loading already is cancelled.
  void open(const std::string& scene, const std::string& edits_file = {});
  void cancel_load();
  // Also where a scene that has been loaded comes in: scene(), edits() and edit() change here and
  // nowhere else by themselves, so that edits of one scene never meet another. To be called after
  // each on_change().
  LoadStatus load_status();
  std::shared_ptr<const ListedScene> scene() const;  // null before the first
  std::shared_ptr<MemoryBudget> memory() const;  // what all of it may take; null before the first

  const ViewSettings& settings() const { return settings_; }
  // Takes any combination. One that makes no sense (a sampler of fixed counts with an adaptive
  // driver) is stated by problem(), and nothing is rendered until it is mended. Only what concerns
  // samples restarts the frame: display, overlays whose channels are there, and `paused` do not.
  void set_settings(const ViewSettings& settings);

  // The number of the newest edit, settings and scenes included: what ShownPicture::edit reaches.
  uint64_t edit() const { return edit_; }
  // The whole of what differs from the file, as set or opened last.
  const SceneEdits& edits() const { return edits_; }
  // Throws InputError for edits that do not fit the scene; all is then as it was. `solo`: only this
  // light shines, without being an edit that is saved. An environment's file that has no image
  // yet is read in the background. Nothing happens without a scene.
  void set_edits(const SceneEdits& edits, const std::optional<LightEdit>& solo = std::nullopt);

  // The newest picture; null before the first.
  std::shared_ptr<const ShownPicture> picture() const;
  // A picture of before, to be looked at beside the newest: its light, graded in the background by
  // the display settings of now, whatever those are. Null: none any more. One with an overlay stays
  // as it is.
  void compare_with(std::shared_ptr<const ShownPicture> kept);
  // Null until it has been graded, after which on_change() is called.
  std::shared_ptr<const ShownPicture> compared() const;
  // Why there is none of the newest edit, in the words of the command line; empty while all is
  // well.
  std::string problem() const;
  // Is called, from a thread of the session's, when there is a newer picture, load status, problem
  // or inspection. Must not call the session, only wake its owner up. Never called after
  // on_change({}) has returned.
  void on_change(std::function<void()> wake);

  // What is known of the pixel, at once; and asks for the rest, after which on_change() is called:
  // ask again. Nothing outside the picture, or before there is one.
  std::optional<PixelInspection> inspect(int x, int y);
  // No pixel is looked at any more.
  void end_inspection();
  // The pixel that is explained until another is, whatever inspect() looks at: frames that begin
  // from now on keep its whole history, the one under way from here on.
  void pick(const std::optional<Vec2i>& pixel);
  // As inspect() does, of that pixel.
  std::optional<PixelInspection> picked() const;

  // The picture as it stands, with its channels: .exr, .png, .jpg. In the background; the returned
  // future, which may be dropped, throws RenderError or UsageError, that for a file of the scene's
  // too.
  std::future<void> save(const std::string& path);
  // Throws UsageError at once for an overlay that is none of a heatmap.
  std::future<void> save_heatmap(const std::string& path, ViewOverlay quantity);
  // The edits, for `render --edits`: with the view stated if the settings' options chose it.
  std::future<void> save_edits(const std::string& path);

 private:
  void post(bool only_edits);
  void adopt(std::shared_ptr<LoadedScene> loaded);
  std::future<void> save_film(const std::string& path,
                              const std::function<void(const FilmCopy&)>& write);
  std::future<void> save_later(const std::string& path, const std::function<void()>& write);
  std::optional<PixelInspection> look(const Vec2i& at, bool picked) const;

  // What was asked for last. All else is in the threads of the last members.
  ViewSettings settings_;
  ViewSettings rendered_settings_;  // of the newest request
  uint64_t edit_ = 0;
  std::shared_ptr<LoadedScene> scene_;
  SceneEdits edits_;
  std::optional<LightEdit> solo_;
  std::optional<Vec2i> inspected_, picked_;

  // In the order of their use: each may still call those before it while it ends.
  const std::unique_ptr<PicturePublisher> publisher_;
  const std::unique_ptr<TaskThread> writer_;
  const std::unique_ptr<SceneLoader> loader_;
  const std::unique_ptr<ViewRenderer> renderer_;
};

}  // namespace emberline
