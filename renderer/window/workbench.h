// All that the window is about, without a window: the session, the edits and their history, what
// is selected, how the picture lies, what was asked for and what came of it. Panels and input read
// and change it; nothing here draws.
//
// Used by the window's thread alone; nothing here blocks it.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/display/display.h"
#include "renderer/session/edit_history.h"
#include "renderer/session/render_session.h"
#include "renderer/session/view_camera.h"
#include "renderer/window/input/edit_latency.h"
#include "renderer/window/input/input.h"
#include "renderer/window/input/journal.h"
#include "renderer/window/panels/time_line.h"
#include "renderer/window/picture/placement.h"
#include "renderer/window/view_command.h"
#include "renderer/window/window_state.h"

namespace emberline {

struct Message {
  enum class Level : uint8_t { kNote, kWarning, kError } level = Level::kNote;
  std::string text;
  double time_s = 0.0;  // Workbench::now()
};

// A picture that was set aside to be compared with: B.
struct KeptPicture {
  std::shared_ptr<const ShownPicture> picture;  // null: none
  DisplaySettings display;                      // that it was kept with
  double time_s = 0.0;                          // when; Workbench::now()
  bool graded_as_a = true;                      // shown by the display settings of now
};

class Workbench {
 public:
  Workbench(const ViewOptions& options, WindowState& state, std::function<void()> wake);
  ~Workbench();

  // Seconds on the window's clock.
  static double now();
  // Takes in what the session has brought, sends it what was asked for. Once for each time that the
  // window wakes up. True if there is something new to be seen.
  bool update();
  // A slider or the mouse is held: what is changed until it is let go is one step of undo.
  void gesture_goes_on(bool held);

  // The picture is on the screen.
  void note_drawn(const std::shared_ptr<const ShownPicture>& picture);
  // `asking`: the dialog whose name is being typed; empty for none. Each frame.
  void note_dialog(const std::string& asking);

  // ---- what is open
  void open(const std::string& scene);
  // Reads the scene's file again, with the settings' options of loading as they now are; edits,
  // bookmarks and the file of the edits stay, their history does not.
  void reload();
  // A scene, or an environment or edits for the one that is open: whatever was dropped.
  void open_dropped(const std::string& path);
  const std::shared_ptr<const ListedScene>& scene() const { return scene_; }
  const LoadStatus& load_status() const { return load_status_; }
  const std::shared_ptr<const ShownPicture>& picture() const { return picture_; }
  // B as it is to be shown; null if nothing is kept.
  const std::shared_ptr<const ShownPicture>& picture_b() const { return picture_b_; }
  RenderSession& session() { return session_; }
  // Throws UsageError where `option`'s file is one that what is open was read from.
  void check_output(const std::string& option, const std::string& path) const;

  // ---- edits
  const SceneEdits& edits() const { return edits_; }
  // `what` names the control: changes of one control while it is held are one step of undo.
  void change(const SceneEdits& edits, std::string_view what);
  void change_camera(const CameraEdit& camera, std::string_view what);
  void change_animation(const AnimationEdit& animation, std::string_view what);
  // Of an environment that takes the place of the scene's; what was edited of that one stays.
  void set_environment(const std::string& file);
  // The environment that was opened with the scene, or none.
  void clear_environment();
  void set_solo(const std::optional<LightEdit>& solo);
  const std::optional<LightEdit>& solo() const { return solo_; }
  bool can_undo() const { return history_.can_undo(); }
  bool can_redo() const { return history_.can_redo(); }
  bool unsaved() const { return scene_ && !(edits_ == saved_edits_); }

  // ---- how it is rendered and shown
  const ViewSettings& settings() const { return settings_; }
  void change(const ViewSettings& settings);
  const DisplayNames& display_names() const { return display_names_; }
  std::string problem() const { return session_.problem(); }

  // The picture as it was before it was denoised is there, to be looked at beside it.
  bool shows_raw_beside() const { return wipe_raw && picture_ && !picture_->raw8.empty(); }

  // ---- time
  bool has_time_line() const { return scene_ && !scene_->animations.empty(); }
  // When the next frame of what plays is due; Workbench::now().
  double next_frame_s() const;

  // ---- navigation
  void navigate(Drag drag, const Vec2f& pixels);  // of the mouse, in the picture's own pixels
  void dolly_by(double steps);                    // of the wheel, towards the scene
  void fly_along(const std::array<bool, 6>& held, double seconds, bool fast);
  void orbit_around(const Vec2i& pixel);
  // What is orbited keeps its size. Perspective comes back with the angle that it last had here.
  void set_orthographic(bool orthographic);
  bool orthographic() const { return scene_ && camera().orthographic; }
  void set_mirrored(bool mirrored);
  double focus_distance() const;  // of a lens, metres; where none is set, to what is orbited
  const std::array<std::optional<CameraEdit>, 9>& bookmarks() const { return bookmarks_; }

  void act(Action action, int number = 0);

  // ---- the pixel under the cursor, and what was clicked
  void point_at(const std::optional<Vec2i>& pixel);
  const std::optional<Vec2i>& pointed_pixel() const { return pointed_; }
  const std::optional<PixelInspection>& inspection() const { return inspection_; }
  void select_at(const Vec2i& pixel);
  // The pixel whose explanation is shown, if that is wanted: the last one that was clicked.
  const std::optional<Vec2i>& picked_pixel() const { return picked_; }
  const std::optional<PixelInspection>& explanation() const { return explanation_; }
  // As its panel shows it; empty while nothing is known.
  std::string explanation_text() const;
  void copy_explanation();
  int selected_material() const { return material_; }
  void select_material(int material) { material_ = material; }

  // ---- saving; in the background
  void save_picture(const std::string& path);
  void save_heatmap(const std::string& path, ViewOverlay quantity);

  // ---- messages
  void say(Message::Level level, const std::string& text);
  const std::deque<Message>& messages() const { return messages_; }

  // Plain state of the interface, which the panels change as they like.
  WindowState& window;
  PicturePlacement placement;
  KeptPicture kept;
  Playback playback;
  bool show_material = false;  // its tab is to be opened
  bool wipe = false;           // against B
  bool wipe_raw = false;       // of the denoised picture against the raw one; never both
  float wipe_place = 0.5f;     // share of the picture's width that shows A
  bool show_shortcuts = false, show_messages = false, show_inspector = true;
  bool show_explanation = false;
  bool ask_for_scene = false, ask_for_picture_file = false,
       ask_for_environment = false;  // a dialog is to be opened
  bool quit = false, full_screen = false, want_screenshot = false;
  std::function<void(const std::string&)> copy_text;  // to the clipboard

  EditLatency latency;
  Journal journal;

 private:
  struct PendingSave {
    std::future<void> done;
    std::string what;
    std::function<void()> after;
  };

  ViewCamera camera() const;
  void change_view(const ViewCamera& view, std::string_view what = "camera");
  void look_at(const Vec3d& point);
  void turn_environment(double degrees);
  void fetch_scene();
  void restore_edits(const SceneEdits& edits);
  bool fetch_picture();
  bool fetch_picture_b();
  void send_edits();
  void journal_edits();
  void finish_saves();
  void refresh_inspection();
  bool refresh_explanation();
  void explain();
  void save_edits();
  std::string edits_file() const;  // that they came from or went to, or else a new one's name
  void undo();
  void redo();
  void pause();
  void restart();  // with the next seed
  void change_exposure(float stops);
  void play();
  void step(int frames);
  void play_on();
  void show_whole_scene();
  void reset_camera();
  void recall_bookmark(int number);  // from 1
  void store_bookmark(int number);
  void zoom_to(double zoom);  // about the middle of the window
  void toggle_inspector();
  void keep_picture();  // as B
  void toggle_wipe();
  void wipe_against_raw(bool on);
  void toggle_denoise();
  void clear_region();
  void next_overlay();
  void copy_pixel();

  ViewOptions options_;
  RenderSession session_;
  DisplayNames display_names_;
  std::shared_ptr<const ListedScene> scene_;
  std::shared_ptr<const ShownPicture> picture_, noted_, picture_b_;
  std::string noted_dialog_;
  Vec2f noted_corner_ = Vec2f(0.0f);
  double noted_zoom_ = 0.0;
  LoadStatus load_status_;
  std::string problem_;

  SceneEdits edits_, sent_edits_, saved_edits_;
  bool reloading_ = false;
  std::optional<LightEdit> solo_, sent_solo_;
  EditHistory history_;
  std::string edits_file_;  // empty: none yet
  ViewSettings settings_;

  std::array<std::optional<CameraEdit>, 9> bookmarks_;
  Vec3d pivot_ = Vec3d(0.0);
  double fov_before_ = kOrdinaryFov;  // it became orthographic
  std::optional<Vec2i> pointed_, clicked_, pivot_pixel_, picked_;
  std::optional<PixelInspection> inspection_, explanation_;
  int material_ = -1;

  bool news_ = false;
  std::deque<Message> messages_;
  std::vector<PendingSave> saves_;
};

}  // namespace emberline
