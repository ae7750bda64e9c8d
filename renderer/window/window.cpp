// Implements `emberline view`: GLFW, OpenGL and Dear ImGui around a Workbench, and an event loop
// that wakes up on demand. Only this file includes the headers of all three libraries.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "io/files/register.h"
#include "renderer/core/errors.h"
#include "renderer/output/outputs.h"
#include "renderer/window/glfw_window.h"
#include "renderer/window/input/imgui_input.h"
#include "renderer/window/input/picture_input.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/panels/widgets.h"
#include "renderer/window/picture/drawn_journal.h"
#include "renderer/window/picture/measurement.h"
#include "renderer/window/picture/view.h"
#include "renderer/window/screenshot.h"
#include "renderer/window/view_command.h"
#include "renderer/window/workbench/clock.h"
#include "renderer/window/workbench/workbench.h"

namespace emberline {
namespace {

// Minimum time between redraws: 1/60 s after input, 1/30 s while the picture only gains samples.
// With software OpenGL, redraws take time away from rendering.
constexpr double kInputPause_s = 1.0 / 60.0, kPicturePause_s = 1.0 / 30.0;
// Maximum time between redraws. kStatusPause_s applies while rendering, so that the status line
// shows the current time; kIdlePause_s applies when idle.
constexpr double kStatusPause_s = 0.5, kIdlePause_s = 5.0;
// Number of frames to draw after input. The first frame handles the input, but ImGui may show its
// effect (hover, popups, fields) only in the next frames.
constexpr int kFramesAfterInput = 3;

class Window {
 public:
  // Throws RenderError if there is no display or no OpenGL 3.0.
  explicit Window(const ViewOptions& options)
      : options_(options),
        state_file_(options.forget ? std::string() : window_state_file()),
        state_(read_window_state(state_file_)),
        scale_(options.interface_scale.value_or(screen_scale())),
        window_(open_window(options, state_, scale_)),
        imgui_(window_.get()),
        bench_(
            options, state_, [] { glfwPostEmptyEvent(); },
            [this](const std::string& text) {
              glfwSetClipboardString(window_.get(), text.c_str());
            }),
        drawn_journal_(bench_.journal),
        input_(
            bench_, [this](const Vec2f& point) { return interface_.covers(point); },
            [this] { return ImGui::GetIO().WantTextInput || interface_.popup_open(); }) {
    if (!options.measure.empty()) measurement_.emplace(options, bench_);
    install_callbacks();
    set_theme();
  }

  // Runs until the user or the options close the window.
  void run() {
    const auto stopped = [this] { return options_.stopped && options_.stopped(); };
    while (!glfwWindowShouldClose(window_.get()) && !bench_.interface.quit && !closing_ &&
           !stopped()) {
      glfwWaitEventsTimeout(wait_timeout());
      const double start = window_time_s();
      if (input_.flying()) input_.fly(std::min(start - last_fly_s_, 0.1));
      last_fly_s_ = start;
      const uint64_t displayed = picture_.drawn() ? picture_.drawn()->edit : 0;
      needs_redraw_ |= bench_.update();
      // The first picture of an edit is drawn without delay.
      needs_redraw_now_ |=
          bench_.picture() && bench_.picture()->filled && bench_.picture()->edit > displayed;
      if (measurement_) measurement_->step(start);
      finish_screenshot();
      if (is_redraw_due(window_time_s())) draw(window_time_s());
      check_screenshot_option(window_time_s());
      if (measurement_) {
        measurement_->record_busy(window_time_s() - start);
        closing_ |= measurement_->finished();
      }
    }
    save_state();
    if (measurement_) measurement_->write();
  }

 private:
  static Window& of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }

  void install_callbacks() {
    glfwSetWindowUserPointer(window_.get(), this);
    install_input_callbacks();
    install_window_callbacks();
  }

  // Forwards GLFW's events to the picture's input and to ImGui's back end.
  void install_input_callbacks() {
    GLFWwindow* const window = window_.get();
    // These callbacks replace those that ImGui's back end has installed, and forward the events to
    // them.
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
      Window& self = of(w);
      ImGui_ImplGlfw_MouseButtonCallback(w, button, action, modifiers);
      self.input_.button(button, action == GLFW_PRESS, modifiers);
      self.frames_to_draw_ = kFramesAfterInput;
    });
    imgui_moved_ = glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
      Window& self = of(w);
      if (self.imgui_moved_) self.imgui_moved_(w, x, y);
      self.input_.moved(Vec2f(float(x), float(y)));
      self.frames_to_draw_ = std::max(self.frames_to_draw_, 2);
    });
    glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int entered) {
      Window& self = of(w);
      ImGui_ImplGlfw_CursorEnterCallback(w, entered);
      if (!entered) self.input_.left_window();
      self.frames_to_draw_ = kFramesAfterInput;
    });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double x, double y) {
      Window& self = of(w);
      ImGui_ImplGlfw_ScrollCallback(w, x, y);
      const bool control = glfwGetKey(w, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                           glfwGetKey(w, GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
      self.input_.wheel(y, control ? GLFW_MOD_CONTROL : 0);
      self.frames_to_draw_ = kFramesAfterInput;
    });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
      Window& self = of(w);
      self.imgui_input_.key(w, key, scancode, action, modifiers);
      if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) self.interface_.cancel_dialogs();
      self.input_.key(key, action != GLFW_RELEASE, action == GLFW_REPEAT, modifiers);
      self.frames_to_draw_ = kFramesAfterInput;
    });
    glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
      Window& self = of(w);
      ImGui_ImplGlfw_WindowFocusCallback(w, focused);
      if (!focused) self.input_.lost_focus();
      self.frames_to_draw_ = kFramesAfterInput;
    });
  }

  void install_window_callbacks() {
    GLFWwindow* const window = window_.get();
    glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
      Window& self = of(w);
      for (int i = 0; i < count; ++i) self.bench_.files.open_dropped(paths[i]);
    });
    glfwSetFramebufferSizeCallback(
        window, [](GLFWwindow* w, int, int) { of(w).frames_to_draw_ = kFramesAfterInput; });
    glfwSetWindowRefreshCallback(window,
                                 [](GLFWwindow* w) { of(w).frames_to_draw_ = kFramesAfterInput; });
    glfwSetWindowContentScaleCallback(window, [](GLFWwindow* w, float x, float y) {
      Window& self = of(w);
      if (self.options_.interface_scale) return;
      self.scale_ = std::max(x, y);
      self.set_theme();
      ImGui_ImplOpenGL3_DestroyDeviceObjects();  // the next frame recreates them with the fonts
      self.frames_to_draw_ = kFramesAfterInput;
    });
  }

  void set_theme() {
    int window_width = 1, pixels = 1, unused = 0;
    glfwGetWindowSize(window_.get(), &window_width, &unused);
    glfwGetFramebufferSize(window_.get(), &pixels, &unused);
    const float per_unit = float(std::max(pixels, 1)) / float(std::max(window_width, 1));
    apply_theme(scale_ / per_unit, per_unit);
  }

  double wait_timeout() const {
    const double now = window_time_s();
    double wake_s = drawn_s_ + kIdlePause_s;
    const bool is_rendering =
        bench_.picture() && !bench_.picture()->finished && !bench_.session.settings().paused;
    if (is_rendering || bench_.load_status().state == LoadStatus::State::kLoading ||
        !bench_.messages.messages().empty()) {
      wake_s = drawn_s_ + kStatusPause_s;
    }
    if (frames_to_draw_ > 0 || input_.flying()) wake_s = drawn_s_ + kInputPause_s;
    if (needs_redraw_) wake_s = std::min(wake_s, drawn_s_ + kPicturePause_s);
    wake_s = std::min(wake_s, bench_.player.next_frame_s());
    wake_s = std::min(wake_s, widgets::next_tooltip_s());
    if (measurement_) wake_s = std::min(wake_s, measurement_->next_s());
    return std::max(wake_s - now, 1e-4);
  }

  bool is_redraw_due(double now) const {
    if (needs_redraw_now_) return true;
    if (frames_to_draw_ > 0 || input_.flying()) return now >= drawn_s_ + kInputPause_s;
    if (needs_redraw_) return now >= drawn_s_ + kPicturePause_s;
    return now >= std::min(drawn_s_ + kStatusPause_s, widgets::next_tooltip_s());
  }

  void draw(double now) {
    if (bench_.interface.full_screen != full_screen_) set_full_screen();
    int width = 0, height = 0, pixels_x = 0, pixels_y = 0;
    glfwGetWindowSize(window_.get(), &width, &height);
    glfwGetFramebufferSize(window_.get(), &pixels_x, &pixels_y);
    drawn_s_ = now;
    needs_redraw_ = needs_redraw_now_ = false;
    frames_to_draw_ = std::max(0, frames_to_draw_ - 1);
    if (width < 1 || height < 1) return;  // minimised

    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    interface_.draw(bench_, float(width), float(height));
    drawn_journal_.record_dialog(interface_.focused_dialog());
    picture_.draw(bench_, input_.dragged_region());
    draw_inspector(bench_);
    ImGui::Render();
    if (imgui_input_.end_frame()) frames_to_draw_ = kFramesAfterInput;
    bench_.update_gesture(ImGui::IsAnyItemActive() || input_.dragging() || input_.flying());

    glViewport(0, 0, pixels_x, pixels_y);
    const ImVec4& background =
        ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);  // the side panel's colour
    glClearColor(background.x, background.y, background.z, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    if (std::exchange(bench_.interface.screenshot_requested, false)) {
      screenshot_.take(window_.get(), screenshot_file());
    }
    if (std::exchange(option_screenshot_requested_, false)) {
      bench_.files.check_output("`screenshot`", options_.screenshot);
      screenshot_.take(window_.get(), options_.screenshot);
    }
    glfwSwapBuffers(window_.get());

    record_displayed();
    set_title();
  }

  void record_displayed() {
    if (!picture_.drawn()) return;
    bench_.latency.displayed(*picture_.drawn(), window_time_s());
    drawn_journal_.record_picture(picture_.drawn(), bench_.placement);
  }

  std::string screenshot_file() {
    const std::string stem = bench_.session.scene()
                                 ? std::filesystem::path(bench_.load_status().path).stem().string()
                                 : "window";
    return unused_file_name(stem + "-window", ".png");
  }

  void finish_screenshot() {
    std::string path;
    try {
      if (!screenshot_.finish(&path)) return;
      bench_.messages.note("Screenshot saved: " + path);
    } catch (const EmberlineError& error) {
      if (path == options_.screenshot) throw;
      bench_.messages.error(error.what());
    }
    closing_ |= path == options_.screenshot;
  }

  // Takes the screenshot for --screenshot once the picture is finished, the requested time has
  // passed, or loading has failed.
  void check_screenshot_option(double now) {
    if (options_.screenshot.empty() || screenshot_.is_writing() || closing_) return;
    const auto& picture = picture_.drawn();
    const bool failed = bench_.load_status().state == LoadStatus::State::kFailed;
    if (!failed && (!picture || !picture->complete)) return;
    if (ready_s_ < 0.0) ready_s_ = now;
    const bool is_due =
        failed || (options_.screenshot_after_s > 0.0 ? now >= ready_s_ + options_.screenshot_after_s
                                                     : picture->finished);
    if (!is_due) return;
    option_screenshot_requested_ = true;
    draw(now);
  }

  void set_title() {
    std::string title = "Emberline";
    if (bench_.session.scene()) {
      title = std::filesystem::path(bench_.load_status().path).filename().string() +
              (bench_.edits.has_unsaved_edits() ? " * – " : " – ") + title;
    }
    if (title == title_) return;
    title_ = title;
    glfwSetWindowTitle(window_.get(), title.c_str());
  }

  void save_state() {
    if (state_file_.empty()) return;
    state_.maximized = glfwGetWindowAttrib(window_.get(), GLFW_MAXIMIZED) != 0;
    if (!state_.maximized && !full_screen_) {
      int width = 0, height = 0;
      glfwGetWindowSize(window_.get(), &width, &height);
      state_.width = int(float(width) / scale_);
      state_.height = int(float(height) / scale_);
    }
    write_window_state(state_file_, state_);
  }

  void set_full_screen() {
    full_screen_ = bench_.interface.full_screen;
    GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
    if (full_screen_ && monitor) {
      glfwGetWindowPos(window_.get(), &windowed_rect_[0], &windowed_rect_[1]);
      glfwGetWindowSize(window_.get(), &windowed_rect_[2], &windowed_rect_[3]);
      const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
      glfwSetWindowMonitor(window_.get(), monitor, 0, 0, mode->width, mode->height,
                           mode->refreshRate);
    } else if (windowed_rect_[2] > 0) {
      glfwSetWindowMonitor(window_.get(), nullptr, windowed_rect_[0], windowed_rect_[1],
                           windowed_rect_[2], windowed_rect_[3], 0);
    }
    frames_to_draw_ = kFramesAfterInput;
  }

  const ViewOptions options_;
  std::string state_file_;
  WindowState state_;
  Glfw glfw_;
  float scale_;
  WindowHandle window_;
  ImGuiContextOwner imgui_;
  Workbench bench_;
  DrawnJournal drawn_journal_;
  Interface interface_;
  PictureView picture_;
  PictureInput input_;
  std::optional<Measurement> measurement_;

  GLFWcursorposfun imgui_moved_ = nullptr;  // null for ImGui < 1.87, which polls the cursor
  ImGuiInput imgui_input_;
  bool needs_redraw_ = true, needs_redraw_now_ = false;
  int frames_to_draw_ = kFramesAfterInput;
  double drawn_s_ = -1e9, last_fly_s_ = 0.0, ready_s_ = -1.0;
  std::string title_;
  bool full_screen_ = false;
  std::array<int, 4> windowed_rect_ = {};
  Screenshot screenshot_;
  bool closing_ = false, option_screenshot_requested_ = false;
};

}  // namespace

int run_view(const ViewOptions& options) {
  if (options.render.working_space != WorkingSpace::kRec709) {
    throw UsageError("`working-space`: the window supports only rec709; use `emberline render`");
  }
  if (options.render.panorama) {
    throw UsageError("`panorama`: the window does not show panoramas; use `emberline render`");
  }
  FileRegister files;
  if (!options.measure.empty()) files.write("`measure`", options.measure);
  if (!options.screenshot.empty()) files.write("`screenshot`", options.screenshot);
  if (!options.journal.empty()) files.write("`journal`", options.journal);
  if (!options.measure_script.empty()) files.read(options.measure_script, "it is `measure-script`");
  register_inputs(options.render, files);
  Window(options).run();
  return kExitDone;
}

}  // namespace emberline
