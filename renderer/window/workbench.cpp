#include "renderer/window/workbench.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>

#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/core/readable.h"
#include "renderer/session/overlay_picture.h"
#include "renderer/window/panels/edit_entries.h"

namespace emberline {
namespace {

constexpr size_t kMostMessages = 200;
constexpr float kExposureStep = 0.25f;  // stops
constexpr double kZoomStep = std::numbers::sqrt2;

ViewSettings first_settings(const ViewOptions& options) {
  ViewSettings settings;
  settings.render = options.render;
  settings.display = options.render.display;
  settings.denoise = true;
  settings.light_groups = options.render.light_groups;
  settings.render.heatmap_style.colours = ColourMap::kViridis;
  return settings;
}

void set(bool& flag) { flag = true; }
void toggle(bool& flag) { flag = !flag; }

}  // namespace

double Workbench::now() {
  using Seconds = std::chrono::duration<double>;
  static const auto start = std::chrono::steady_clock::now();
  return Seconds(std::chrono::steady_clock::now() - start).count();
}

Workbench::Workbench(const ViewOptions& options, WindowState& state, std::function<void()> wake)
    : window(state),
      show_inspector(state.inspector),
      options_(options),
      session_(first_settings(options)),
      display_names_(emberline::display_names()),
      settings_(session_.settings()) {
  if (!options.journal.empty()) journal.wait(options.journal);
  if (journal.waits() && options.render.scene.empty()) journal.begin();
  session_.on_change(std::move(wake));
  if (!options.render.scene.empty()) open(options.render.scene);
}

Workbench::~Workbench() { session_.on_change({}); }

void Workbench::fetch_scene() {
  const LoadStatus before = std::exchange(load_status_, session_.load_status());
  if (load_status_.state == LoadStatus::State::kFailed &&
      (before.state != load_status_.state || before.error != load_status_.error)) {
    say(Message::Level::kError, load_status_.error);
    // What such a scene would have read is not known: only a new file is none of it.
    std::error_code none;
    const auto size = std::filesystem::file_size(journal.path(), none);
    if (journal.waits() && (none || size == 0)) journal.begin();
  }
  std::shared_ptr<const ListedScene> scene = session_.scene();
  if (scene == scene_) return;
  const bool first = !scene_;
  const bool again = std::exchange(reloading_, false);
  const SceneEdits before_edits = edits_, saved = saved_edits_;
  scene_ = std::move(scene);
  edits_ = sent_edits_ = saved_edits_ = session_.edits();
  solo_.reset();
  sent_solo_.reset();
  playback.stop();
  history_ = EditHistory(edits_);
  if (!again) bookmarks_ = {};
  material_ = -1;
  clicked_.reset();
  picked_.reset();
  pivot_ = scene_->center;
  fov_before_ = kOrdinaryFov;
  if (!again) edits_file_ = first ? options_.render.edits : std::string();
  window.remember_scene(load_status_.path);
  if (journal.waits()) {
    check_output("`journal`", journal.path());
    journal.begin();
  }
  for (const std::string& warning : scene_->warnings) say(Message::Level::kWarning, warning);
  journal.write("scene", {{"file", load_status_.path},
                          {"materials", scene_->outline.materials.size()},
                          {"lights", list_lights(scene_->outline, edits_).size()}});
  if (again) {
    saved_edits_ = saved;
    restore_edits(before_edits);
  }
  latency.asked(session_.edit(), "open", now());
}

// Edits that no longer fit the file are left out, and the session says why.
void Workbench::restore_edits(const SceneEdits& edits) {
  edits_ = edits;
  send_edits();
  history_ = EditHistory(edits_);
}

// ---- each time the window wakes up

bool Workbench::update() {
  const LoadStatus before = load_status_;
  fetch_scene();
  bool news = before.state != load_status_.state || before.fraction != load_status_.fraction ||
              before.stage != load_status_.stage;
  news |= fetch_picture();
  news |= fetch_picture_b();
  play_on();
  send_edits();
  finish_saves();
  const std::string problem = session_.problem();
  if (problem != problem_) {
    problem_ = problem;
    news = true;
    if (!problem.empty()) say(Message::Level::kError, problem);
  }
  const auto shown = [&] {
    return inspection_ ? std::tuple(inspection_->known, inspection_->samples, inspection_->radiance)
                       : std::tuple(false, 0u, Rgb(0.0f));
  };
  const auto before_look = shown();
  refresh_inspection();
  news |= refresh_explanation();
  return news || shown() != before_look || std::exchange(news_, false);
}

bool Workbench::fetch_picture() {
  std::shared_ptr<const ShownPicture> picture = session_.picture();
  if (picture == picture_) return false;
  picture_ = std::move(picture);
  return true;
}

bool Workbench::fetch_picture_b() {
  session_.compare_with(kept.graded_as_a ? kept.picture : nullptr);
  std::shared_ptr<const ShownPicture> graded = kept.graded_as_a ? session_.compared() : nullptr;
  std::shared_ptr<const ShownPicture> picture = graded ? std::move(graded) : kept.picture;
  if (picture == picture_b_) return false;
  picture_b_ = std::move(picture);
  if (journal.is_open()) {
    journal.write("kept", {{"serial", picture_b_->serial}, {"graded_as_a", kept.graded_as_a}});
  }
  return true;
}

// What plays is one step, too.
void Workbench::gesture_goes_on(bool held) {
  if (!held && !playback.playing()) history_.end_gesture();
}

void Workbench::note_drawn(const std::shared_ptr<const ShownPicture>& picture) {
  if (!picture) return;
  latency.shown(*picture, now());
  if (!journal.is_open()) return;
  const Vec2f corner = placement.to_screen(Vec2f(0.0f));
  const nlohmann::json place = {{"at", {corner.x, corner.y}}, {"zoom", placement.zoom()}};
  if (corner != noted_corner_ || placement.zoom() != noted_zoom_) journal.write("placed", place);
  noted_corner_ = corner;
  noted_zoom_ = placement.zoom();
  if (picture == noted_) return;
  noted_ = picture;
  nlohmann::json members = {{"edit", picture->edit},
                            {"serial", picture->serial},
                            {"size", {picture->width, picture->height}},
                            {"filled", picture->filled},
                            {"complete", picture->complete},
                            {"finished", picture->finished},
                            {"samples", picture->samples},
                            {"driver", picture->driver},
                            {"buckets", picture->in_progress.size()},
                            {"denoised", !picture->denoised.empty()},
                            {"legend", picture->overlay_legend}};
  members.update(place);
  journal.write("picture", members);
}

void Workbench::note_dialog(const std::string& asking) {
  if (std::exchange(noted_dialog_, asking) != asking) journal.write("dialog", {{"asks", asking}});
}

void Workbench::change(const SceneEdits& edits, std::string_view what) {
  if (!scene_ || edits == edits_) return;
  edits_ = edits;
  history_.record(edits, std::string(what));
  send_edits();
  if (edits_ == edits) latency.asked(session_.edit(), std::string(what), now());
}

void Workbench::change_camera(const CameraEdit& camera, std::string_view what) {
  SceneEdits edits = edits_;
  edits.camera = camera;
  change(edits, what);
}

void Workbench::set_environment(const std::string& file) {
  SceneEdits edits = edits_;
  edits.environment.file = file;
  edits.environment.image.reset();
  edits.environment.repaired_texels = 0;
  change(edits, "environment file");
}

void Workbench::clear_environment() {
  SceneEdits edits = edits_;
  EnvironmentEdit& edit = edits.environment;
  edit.file.clear();
  edit.image.reset();
  edit.repaired_texels = 0;
  if (scene_ && !scene_->outline.environment) {  // nothing is left that could be edited
    edit = {};
    std::erase_if(edits.lights,
                  [](const LightEdit& light) { return light.kind == EditedLight::kEnvironment; });
  }
  change(edits, "environment file");
}

void Workbench::set_solo(const std::optional<LightEdit>& solo) {
  solo_ = solo;
  send_edits();
}

// The session takes edits together that come faster than pictures.
void Workbench::send_edits() {
  if (!scene_ || (edits_ == sent_edits_ && solo_ == sent_solo_)) return;
  try {
    session_.set_edits(edits_, solo_);
    sent_edits_ = edits_;
    sent_solo_ = solo_;
    journal_edits();
  } catch (const InputError& error) {
    say(Message::Level::kError, error.what());
    edits_ = sent_edits_;
    solo_ = sent_solo_;
  }
}

void Workbench::journal_edits() {
  journal.write("edit", {{"edit", session_.edit()}});
  const std::optional<Vec3d>& from = edits_.camera.look_from;
  const std::optional<double>& height = edits_.camera.orthographic_height;
  const std::optional<double>& time = edits_.animation.time;
  const nlohmann::json camera = from ? nlohmann::json{from->x, from->y, from->z} : nlohmann::json();
  journal.write("edits", {{"camera", camera},
                          {"orthographic_height", height ? nlohmann::json(*height) : nullptr},
                          {"mirrored", edits_.camera.mirrored},
                          {"animation", edits_.animation.name},
                          {"time", time ? nlohmann::json(*time) : nullptr},
                          {"environment", edits_.environment.file},
                          {"lights", edits_.lights.size()},
                          {"materials", edits_.materials.size()}});
}

void Workbench::change(const ViewSettings& settings) {
  settings_ = settings;
  session_.set_settings(settings);
  latency.asked(session_.edit(), "settings", now());
  nlohmann::json region;
  if (const std::optional<Rect>& r = settings.region) region = {r->x0, r->y0, r->x1, r->y1};
  journal.write("settings", {{"edit", session_.edit()},
                             {"driver", settings.render.driver},
                             {"overlay", int(settings.overlay)},
                             {"denoise", settings.denoise},
                             {"paused", settings.paused},
                             {"region", region}});
}

// ---- actions

void Workbench::act(Action action, int number) {
  switch (action) {
    case Action::kOpen:
      return set(ask_for_scene);
    case Action::kReload:
      return reload();
    case Action::kSaveEdits:
      return save_edits();
    case Action::kSavePicture:
      return set(ask_for_picture_file);
    case Action::kScreenshot:
      return set(want_screenshot);
    case Action::kQuit:
      return set(quit);
    case Action::kUndo:
      return undo();
    case Action::kRedo:
      return redo();
    case Action::kResetEdits:
      return change(SceneEdits(), "reset");
    case Action::kPause:
      return pause();
    case Action::kRestart:
      return restart();
    case Action::kPlay:
      return play();
    case Action::kNextFrame:
      return step(1);
    case Action::kPreviousFrame:
      return step(-1);
    case Action::kFrameAll:
      return show_whole_scene();
    case Action::kResetCamera:
      return reset_camera();
    case Action::kOrthographic:
      return set_orthographic(!orthographic());
    case Action::kRecallBookmark:
      return recall_bookmark(number);
    case Action::kStoreBookmark:
      return store_bookmark(number);
    case Action::kZoomFit:
      return placement.fit();
    case Action::kZoomOne:
      return placement.fitted() ? zoom_to(1.0) : placement.fit();
    case Action::kZoomIn:
      return zoom_to(placement.zoom() * kZoomStep);
    case Action::kZoomOut:
      return zoom_to(placement.zoom() / kZoomStep);
    case Action::kExposureUp:
      return change_exposure(kExposureStep);
    case Action::kExposureDown:
      return change_exposure(-kExposureStep);
    case Action::kNextOverlay:
      return next_overlay();
    case Action::kDenoise:
      return toggle_denoise();
    case Action::kInspector:
      return toggle_inspector();
    case Action::kExplain:
      return explain();
    case Action::kCopyPixel:
      return copy_pixel();
    case Action::kStoreSnapshot:
      return keep_picture();
    case Action::kWipe:
      return toggle_wipe();
    case Action::kWipeRaw:
      return wipe_against_raw(!wipe_raw);
    case Action::kClearRegion:
      return clear_region();
    case Action::kPanels:
      return toggle(window.panels);
    case Action::kFullScreen:
      return toggle(full_screen);
    case Action::kShortcuts:
      return toggle(show_shortcuts);
    case Action::kMessages:
      return toggle(show_messages);
  }
}

void Workbench::undo() {
  playback.stop();
  if (can_undo()) edits_ = history_.undo();
  send_edits();
}

void Workbench::redo() {
  playback.stop();
  if (can_redo()) edits_ = history_.redo();
  send_edits();
}

void Workbench::pause() {
  ViewSettings settings = settings_;
  toggle(settings.paused);
  change(settings);
}

void Workbench::restart() {
  ViewSettings settings = settings_;
  settings.render.seed += 1;
  change(settings);
}

void Workbench::change_exposure(float stops) {
  ViewSettings settings = settings_;
  settings.display.exposure += stops;
  change(settings);
}

void Workbench::show_whole_scene() {
  if (!scene_) return;
  change_view(frame_all(camera(), scene_->center, scene_->radius,
                        double(settings_.render.width) / settings_.render.height));
}

void Workbench::reset_camera() {
  if (scene_) pivot_ = scene_->center;
  change_camera(CameraEdit(), "reset camera");
}

void Workbench::recall_bookmark(int number) {
  if (const auto& camera = bookmarks_[size_t(number - 1)]) {
    return change_camera(*camera, "bookmark");
  }
  say(Message::Level::kNote,
      fmt::format("bookmark {} is empty; Ctrl+{} stores the view", number, number));
}

void Workbench::store_bookmark(int number) {
  if (!scene_) return;
  bookmarks_[size_t(number - 1)] = edits_.camera;
  say(Message::Level::kNote, fmt::format("stored as bookmark {}", number));
}

void Workbench::zoom_to(double zoom) {
  const Rect& area = placement.area();
  placement.zoom_to(zoom, Vec2f(0.5f * float(area.x0 + area.x1), 0.5f * float(area.y0 + area.y1)));
}

void Workbench::toggle_inspector() {
  window.inspector = show_inspector = !show_inspector;
  refresh_inspection();
}

void Workbench::keep_picture() {
  if (!picture_) return;
  kept.picture = picture_;
  kept.display = settings_.display;
  kept.time_s = now();
  say(Message::Level::kNote, "kept as B; V wipes between A and B");
}

void Workbench::toggle_wipe() {
  if (!kept.picture) return say(Message::Level::kNote, "B keeps a picture to compare with first");
  if (!wipe) wipe_against_raw(false);
  toggle(wipe);
}

void Workbench::wipe_against_raw(bool on) {
  if (on && !settings_.denoise)
    return say(Message::Level::kNote, "the picture is raw; N denoises it");
  if (on == wipe_raw) return;
  wipe = wipe && !on;
  wipe_raw = on;
  ViewSettings settings = settings_;
  settings.raw_beside = on;
  change(settings);
}

void Workbench::toggle_denoise() {
  if (settings_.denoise) wipe_against_raw(false);
  ViewSettings settings = settings_;
  toggle(settings.denoise);
  change(settings);
}

void Workbench::clear_region() {
  if (solo_) set_solo(std::nullopt);
  if (!settings_.region) return;
  ViewSettings settings = settings_;
  settings.region.reset();
  change(settings);
}

void Workbench::next_overlay() {
  ViewSettings settings = settings_;
  settings.overlay = ViewOverlay((size_t(settings.overlay) + 1) % overlay_table().size());
  change(settings);
}

void Workbench::say(Message::Level level, const std::string& text) {
  if (!messages_.empty() && messages_.back().text == text) messages_.pop_back();
  messages_.push_back({level, text, now()});
  if (messages_.size() > kMostMessages) messages_.pop_front();
  news_ = true;
  constexpr std::array kNames = {"note", "warning", "error"};
  journal.write("message", {{"level", kNames[size_t(level)]}, {"text", text}});
}

}  // namespace emberline
