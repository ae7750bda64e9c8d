// `emberline view`: GLFW, OpenGL and Dear ImGui around a Workbench, and the loop that wakes up when
// there is something to do. Their headers stay here.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "io/files/register.h"
#include "io/image/output.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/output/outputs.h"
#include "renderer/window/input/imgui_input.h"
#include "renderer/window/input/picture_input.h"
#include "renderer/window/panels/panels.h"
#include "renderer/window/panels/theme.h"
#include "renderer/window/picture/measurement.h"
#include "renderer/window/picture/view.h"
#include "renderer/window/view_command.h"
#include "renderer/window/workbench.h"

namespace emberline {
namespace {

// How often the window is drawn at most: for a hand that moves as a screen refreshes, for a picture
// that gets better as films do. Where the processor draws, that is what it costs the render.
constexpr double kInputPause_s = 1.0 / 60.0, kPicturePause_s = 1.0 / 30.0;
// The clock in the status line, while it renders; and a look around where nothing is to be done.
constexpr double kStatusPause_s = 0.5, kIdlePause_s = 5.0;
// ImGui shows what it was told a frame later: hover, popups, fields that were opened.
constexpr int kFramesAfterInput = 3;

std::string last_glfw_error = "no display";

// GLFW's start and end.
struct Glfw {
  Glfw() {
    glfwSetErrorCallback([](int, const char* description) { last_glfw_error = description; });
#if defined(GLFW_PLATFORM_X11) && defined(__linux__)
    // GLFW 3.4 and later look for Wayland first, whose library says on standard error what it
    // misses.
    if (!std::getenv("WAYLAND_DISPLAY") && !std::getenv("WAYLAND_SOCKET")) {
      glfwInitHint(GLFW_PLATFORM, GLFW_PLATFORM_X11);
    }
#endif
    if (!glfwInit()) {
      throw RenderError("no window can be opened: " + last_glfw_error +
                        "; `emberline render` needs no display");
    }
  }
  ~Glfw() { glfwTerminate(); }
};

struct DestroyWindow {
  void operator()(GLFWwindow* window) const { glfwDestroyWindow(window); }
};
using WindowHandle = std::unique_ptr<GLFWwindow, DestroyWindow>;

WindowHandle open_window(const ViewOptions& options, const WindowState& state, float scale) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 0);
  // What is drawn has no depth, and nothing of the screen shines through it.
  for (const int bits : {GLFW_DEPTH_BITS, GLFW_STENCIL_BITS, GLFW_ALPHA_BITS}) {
    glfwWindowHint(bits, 0);
  }
  glfwWindowHint(GLFW_MAXIMIZED, state.maximized && !options.window_size);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "emberline");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "emberline");
  // What was remembered may be of a larger screen.
  int unused = 0, most_x = 0, most_y = 0;
  if (GLFWmonitor* const screen = glfwGetPrimaryMonitor()) {
    glfwGetMonitorWorkarea(screen, &unused, &unused, &most_x, &most_y);
  }
  const auto remembered = [&](int size, int most) {
    const int wanted = int(float(size) * scale);
    return most > 0 ? std::min(wanted, most) : wanted;
  };
  const int width = options.window_size ? options.window_size->x : remembered(state.width, most_x);
  const int height =
      options.window_size ? options.window_size->y : remembered(state.height, most_y);
  WindowHandle window(glfwCreateWindow(width, height, "Emberline", nullptr, nullptr));
  if (!window) {
    throw RenderError("no window can be opened: " + last_glfw_error +
                      "; `emberline render` needs no display");
  }
  glfwMakeContextCurrent(window.get());
  // Waiting for the screen would stop this thread; the pauses above do what it is for.
  glfwSwapInterval(0);
  return window;
}

// ImGui's context and its two back ends.
struct ImGuiContextOwner {
  explicit ImGuiContextOwner(GLFWwindow* window) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // window_state.h remembers what there is
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    ImGui_ImplOpenGL3_Init("#version 130");
  }
  ~ImGuiContextOwner() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
  }
};

float screen_scale() {
  float x = 1.0f, y = 1.0f;
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) glfwGetMonitorContentScale(monitor, &x, &y);
  return std::max(x, y);
}

class Window {
 public:
  // Throws RenderError where there is no display or no OpenGL 3.0.
  explicit Window(const ViewOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  // Until it is closed, by its user or by what the options asked for.
  void run();

 private:
  void listen();
  void listen_to_input();
  void listen_to_window();
  void set_theme();
  double pause() const;
  bool due(double now) const;
  void draw(double now);
  std::string screenshot_file();
  void take_screenshot(const std::string& path);
  void finish_screenshot();
  void follow_options(double now);
  void set_title();
  void remember();
  void set_full_screen();

  const ViewOptions options_;
  std::string state_file_;
  WindowState state_;
  Glfw glfw_;
  float scale_;
  WindowHandle window_;
  ImGuiContextOwner imgui_;
  Workbench bench_;
  Interface interface_;
  PictureView picture_;
  PictureInput input_;
  std::optional<Measurement> measurement_;

  GLFWcursorposfun imgui_moved_ = nullptr;  // none before ImGui 1.87, which asks GLFW itself
  ImGuiInput imgui_input_;
  bool news_ = true, urgent_ = false;
  int frames_owed_ = kFramesAfterInput;
  double drawn_s_ = -1e9, flown_s_ = 0.0, ready_s_ = -1.0;
  std::string title_;
  bool full_screen_ = false;
  std::array<int, 4> windowed_ = {};
  std::future<void> screenshot_;
  std::string screenshot_name_;
  bool closing_ = false, wanted_screenshot_ = false;
};

Window::Window(const ViewOptions& options)
    : options_(options),
      state_file_(options.forget ? std::string() : window_state_file()),
      state_(read_window_state(state_file_)),
      scale_(options.interface_scale.value_or(screen_scale())),
      window_(open_window(options, state_, scale_)),
      imgui_(window_.get()),
      bench_(options, state_, [] { glfwPostEmptyEvent(); }),
      input_(
          bench_, [this](const Vec2f& point) { return interface_.covers(point); },
          [this] { return ImGui::GetIO().WantTextInput || interface_.popup_open(); }) {
  bench_.copy_text = [this](const std::string& text) {
    glfwSetClipboardString(window_.get(), text.c_str());
  };
  if (!options.measure.empty()) measurement_.emplace(options, bench_);
  listen();
  set_theme();
}

Window::~Window() {
  if (screenshot_.valid()) screenshot_.wait();
}

void Window::set_theme() {
  int window_width = 1, pixels = 1, unused = 0;
  glfwGetWindowSize(window_.get(), &window_width, &unused);
  glfwGetFramebufferSize(window_.get(), &pixels, &unused);
  const float per_unit = float(std::max(pixels, 1)) / float(std::max(window_width, 1));
  apply_theme(scale_ / per_unit, per_unit);
}

void Window::listen() {
  glfwSetWindowUserPointer(window_.get(), this);
  listen_to_input();
  listen_to_window();
}

// What GLFW tells goes to the picture's input, and on to ImGui, whose back end asks for it itself.
void Window::listen_to_input() {
  GLFWwindow* const window = window_.get();
  // Instead of those that ImGui's back end has set: it is called from ours.
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int modifiers) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    ImGui_ImplGlfw_MouseButtonCallback(w, button, action, modifiers);
    self.input_.button(button, action == GLFW_PRESS, modifiers);
    self.frames_owed_ = kFramesAfterInput;
  });
  imgui_moved_ = glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    if (self.imgui_moved_) self.imgui_moved_(w, x, y);
    self.input_.moved(Vec2f(float(x), float(y)));
    self.frames_owed_ = std::max(self.frames_owed_, 2);
  });
  glfwSetCursorEnterCallback(window, [](GLFWwindow* w, int entered) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    ImGui_ImplGlfw_CursorEnterCallback(w, entered);
    if (!entered) self.input_.left_window();
    self.frames_owed_ = kFramesAfterInput;
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double x, double y) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    ImGui_ImplGlfw_ScrollCallback(w, x, y);
    const bool control = glfwGetKey(w, GLFW_KEY_LEFT_CONTROL) == GLFW_PRESS ||
                         glfwGetKey(w, GLFW_KEY_RIGHT_CONTROL) == GLFW_PRESS;
    self.input_.wheel(y, control ? GLFW_MOD_CONTROL : 0);
    self.frames_owed_ = kFramesAfterInput;
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int scancode, int action, int modifiers) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    self.imgui_input_.key(w, key, scancode, action, modifiers);
    if (key == GLFW_KEY_ESCAPE && action == GLFW_PRESS) self.interface_.cancel_dialogs();
    self.input_.key(key, action != GLFW_RELEASE, action == GLFW_REPEAT, modifiers);
    self.frames_owed_ = kFramesAfterInput;
  });
  glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int focused) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    ImGui_ImplGlfw_WindowFocusCallback(w, focused);
    if (!focused) self.input_.lost_focus();
    self.frames_owed_ = kFramesAfterInput;
  });
}

void Window::listen_to_window() {
  GLFWwindow* const window = window_.get();
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    for (int i = 0; i < count; ++i) self.bench_.open_dropped(paths[i]);
  });
  glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) {
    static_cast<Window*>(glfwGetWindowUserPointer(w))->frames_owed_ = kFramesAfterInput;
  });
  glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) {
    static_cast<Window*>(glfwGetWindowUserPointer(w))->frames_owed_ = kFramesAfterInput;
  });
  glfwSetWindowContentScaleCallback(window, [](GLFWwindow* w, float x, float y) {
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(w));
    if (self.options_.interface_scale) return;
    self.scale_ = std::max(x, y);
    self.set_theme();
    ImGui_ImplOpenGL3_DestroyDeviceObjects();  // the next frame makes them anew, with the fonts
    self.frames_owed_ = kFramesAfterInput;
  });
}

void Window::run() {
  const auto stopped = [this] { return options_.stopped && options_.stopped(); };
  while (!glfwWindowShouldClose(window_.get()) && !bench_.quit && !closing_ && !stopped()) {
    glfwWaitEventsTimeout(pause());
    const double began = Workbench::now();
    if (input_.flying()) input_.fly(std::min(began - flown_s_, 0.1));
    flown_s_ = began;
    const uint64_t shown = picture_.drawn() ? picture_.drawn()->edit : 0;
    news_ |= bench_.update();
    // The first picture of an edit does not wait for its turn.
    urgent_ |= bench_.picture() && bench_.picture()->filled && bench_.picture()->edit > shown;
    if (measurement_) measurement_->step(began);
    finish_screenshot();
    if (due(Workbench::now())) draw(Workbench::now());
    follow_options(Workbench::now());
    if (measurement_) {
      measurement_->blocked(Workbench::now() - began);
      closing_ |= measurement_->finished();
    }
  }
  remember();
  if (measurement_) measurement_->write();
}

double Window::pause() const {
  const double now = Workbench::now();
  double until = drawn_s_ + kIdlePause_s;
  const bool renders = bench_.picture() && !bench_.picture()->finished && !bench_.settings().paused;
  if (renders || bench_.load_status().state == LoadStatus::State::kLoading ||
      !bench_.messages().empty()) {
    until = drawn_s_ + kStatusPause_s;
  }
  if (frames_owed_ > 0 || input_.flying()) until = drawn_s_ + kInputPause_s;
  if (news_) until = std::min(until, drawn_s_ + kPicturePause_s);
  until = std::min(until, bench_.next_frame_s());
  if (measurement_) until = std::min(until, measurement_->next_s());
  return std::max(until - now, 1e-4);
}

bool Window::due(double now) const {
  if (urgent_) return true;
  if (frames_owed_ > 0 || input_.flying()) return now >= drawn_s_ + kInputPause_s;
  if (news_) return now >= drawn_s_ + kPicturePause_s;
  return now >= drawn_s_ + kStatusPause_s;
}

void Window::draw(double now) {
  if (bench_.full_screen != full_screen_) set_full_screen();
  int width = 0, height = 0, pixels_x = 0, pixels_y = 0;
  glfwGetWindowSize(window_.get(), &width, &height);
  glfwGetFramebufferSize(window_.get(), &pixels_x, &pixels_y);
  drawn_s_ = now;
  news_ = urgent_ = false;
  frames_owed_ = std::max(0, frames_owed_ - 1);
  if (width < 1 || height < 1) return;  // an icon

  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  interface_.draw(bench_, float(width), float(height));
  picture_.draw(bench_, input_.dragged_region());
  draw_inspector(bench_);
  ImGui::Render();
  if (imgui_input_.end_frame()) frames_owed_ = kFramesAfterInput;
  bench_.gesture_goes_on(ImGui::IsAnyItemActive() || input_.dragging() || input_.flying());

  glViewport(0, 0, pixels_x, pixels_y);
  const ImVec4& ground = ImGui::GetStyleColorVec4(ImGuiCol_WindowBg);  // of the side panel
  glClearColor(ground.x, ground.y, ground.z, 1.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (std::exchange(bench_.want_screenshot, false)) take_screenshot(screenshot_file());
  if (std::exchange(wanted_screenshot_, false)) {
    bench_.check_output("`screenshot`", options_.screenshot);
    take_screenshot(options_.screenshot);
  }
  glfwSwapBuffers(window_.get());

  bench_.note_drawn(picture_.drawn());
  set_title();
}

std::string Window::screenshot_file() {
  const std::string stem =
      bench_.scene() ? std::filesystem::path(bench_.load_status().path).stem().string() : "window";
  return free_file(stem + "-window", ".png");
}

// Before the buffers are swapped: what was drawn is undefined afterwards.
void Window::take_screenshot(const std::string& path) {
  if (screenshot_.valid()) return;  // one after the other
  ByteImage image;
  glfwGetFramebufferSize(window_.get(), &image.width, &image.height);
  const auto row = size_t(image.width) * 3;
  std::vector<uint8_t> rows(row * size_t(image.height));
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, rows.data());
  screenshot_name_ = path;
  screenshot_ = std::async(std::launch::async, [image, rows, row, path]() mutable {
    image.values.resize(rows.size());  // OpenGL's rows begin at the bottom
    for (size_t y = 0; y < size_t(image.height); ++y) {
      std::copy_n(&rows[(size_t(image.height) - 1 - y) * row], row, &image.values[y * row]);
    }
    write_image(path, image);
  });
}

void Window::finish_screenshot() {
  if (!screenshot_.valid() ||
      screenshot_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return;
  }
  const bool wanted = screenshot_name_ == options_.screenshot;
  try {
    screenshot_.get();
    bench_.say(Message::Level::kNote, "picture of the window saved: " + screenshot_name_);
  } catch (const EmberlineError& error) {
    if (wanted) throw;
    bench_.say(Message::Level::kError, error.what());
  }
  closing_ |= wanted;
}

// --screenshot: once the picture is as old, or as finished, as was asked for.
void Window::follow_options(double now) {
  if (options_.screenshot.empty() || screenshot_.valid() || closing_) return;
  const auto& picture = picture_.drawn();
  const bool failed = bench_.load_status().state == LoadStatus::State::kFailed;
  if (!failed && (!picture || !picture->complete)) return;
  if (ready_s_ < 0.0) ready_s_ = now;
  const bool wanted =
      failed || (options_.screenshot_after_s > 0.0 ? now >= ready_s_ + options_.screenshot_after_s
                                                   : picture->finished);
  if (!wanted) return;
  wanted_screenshot_ = true;
  draw(now);
}

void Window::set_title() {
  std::string title = "Emberline";
  if (bench_.scene()) {
    title = std::filesystem::path(bench_.load_status().path).filename().string() +
            (bench_.unsaved() ? " * – " : " – ") + title;
  }
  if (title == title_) return;
  title_ = title;
  glfwSetWindowTitle(window_.get(), title.c_str());
}

void Window::set_full_screen() {
  full_screen_ = bench_.full_screen;
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  if (full_screen_ && monitor) {
    glfwGetWindowPos(window_.get(), &windowed_[0], &windowed_[1]);
    glfwGetWindowSize(window_.get(), &windowed_[2], &windowed_[3]);
    const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
    glfwSetWindowMonitor(window_.get(), monitor, 0, 0, mode->width, mode->height,
                         mode->refreshRate);
  } else if (windowed_[2] > 0) {
    glfwSetWindowMonitor(window_.get(), nullptr, windowed_[0], windowed_[1], windowed_[2],
                         windowed_[3], 0);
  }
  frames_owed_ = kFramesAfterInput;
}

void Window::remember() {
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

}  // namespace

int run_view(const ViewOptions& options) {
  if (options.render.working_space != WorkingSpace::kRec709) {
    throw UsageError("`working-space`: the window works in rec709; valid with render");
  }
  if (options.render.panorama) {
    throw UsageError("`panorama`: the window looks one way; valid with render");
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
