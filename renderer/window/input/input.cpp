#include "renderer/window/input/input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>

namespace emberline {
namespace {

constexpr int kShift = GLFW_MOD_SHIFT, kControl = GLFW_MOD_CONTROL, kAlt = GLFW_MOD_ALT;

constexpr std::array kShortcuts = {
    Shortcut{Action::kOpen, GLFW_KEY_O, kControl, "File", "Ctrl+O", "open a scene"},
    Shortcut{Action::kReload, GLFW_KEY_R, kControl, "File", "Ctrl+R",
             "read the scene's file anew; edits stay"},
    Shortcut{Action::kSaveEdits, GLFW_KEY_S, kControl, "File", "Ctrl+S", "save the edits"},
    Shortcut{Action::kSavePicture, GLFW_KEY_S, kControl | kShift, "File", "Ctrl+Shift+S",
             "save the picture or a heatmap"},
    Shortcut{Action::kScreenshot, GLFW_KEY_F12, 0, "File", "F12", "save a picture of the window"},
    Shortcut{Action::kQuit, GLFW_KEY_Q, kControl, "File", "Ctrl+Q", "quit"},

    Shortcut{Action::kUndo, GLFW_KEY_Z, kControl, "Edits", "Ctrl+Z", "undo"},
    Shortcut{Action::kRedo, GLFW_KEY_Z, kControl | kShift, "Edits", "Ctrl+Shift+Z", "redo"},
    Shortcut{Action::kRedo, GLFW_KEY_Y, kControl, "Edits", "Ctrl+Y", "redo", 1, false},
    Shortcut{Action::kResetEdits, GLFW_KEY_BACKSPACE, kControl, "Edits", "Ctrl+Backspace",
             "take all edits back (can be undone)"},

    Shortcut{Action::kPause, GLFW_KEY_SPACE, 0, "Render", "Space", "pause, go on"},
    Shortcut{Action::kRestart, GLFW_KEY_F5, 0, "Render", "F5", "render anew"},
    Shortcut{Action::kClearRegion, GLFW_KEY_ESCAPE, 0, "Render", "Esc", "no region, no solo"},

    Shortcut{Action::kPlay, GLFW_KEY_K, 0, "Time", "K", "play the animation, and stop"},
    Shortcut{Action::kNextFrame, GLFW_KEY_PERIOD, 0, "Time", ".", "a frame on"},
    Shortcut{Action::kPreviousFrame, GLFW_KEY_COMMA, 0, "Time", ",", "a frame back"},

    Shortcut{Action::kFrameAll, GLFW_KEY_F, 0, "Camera", "F", "frame the whole scene"},
    Shortcut{Action::kResetCamera, GLFW_KEY_R, 0, "Camera", "R", "back to the file's camera"},
    Shortcut{Action::kOrthographic, GLFW_KEY_P, 0, "Camera", "P",
             "orthographic, and perspective again"},
    Shortcut{Action::kRecallBookmark, GLFW_KEY_1, 0, "Camera", "1 to 9", "go to a bookmark", 9},
    Shortcut{Action::kStoreBookmark, GLFW_KEY_1, kControl, "Camera", "Ctrl+1 to 9",
             "store a bookmark", 9},

    Shortcut{Action::kZoomFit, GLFW_KEY_0, 0, "Picture", "0", "fit the picture into the window"},
    Shortcut{Action::kZoomOne, GLFW_KEY_Z, 0, "Picture", "Z", "one to one, and back"},
    Shortcut{Action::kZoomIn, GLFW_KEY_EQUAL, 0, "Picture", "+", "larger"},
    Shortcut{Action::kZoomIn, GLFW_KEY_KP_ADD, 0, "Picture", "+", "", 1, false},
    Shortcut{Action::kZoomIn, GLFW_KEY_EQUAL, kShift, "Picture", "+", "", 1, false},
    Shortcut{Action::kZoomOut, GLFW_KEY_MINUS, 0, "Picture", "-", "smaller"},
    Shortcut{Action::kZoomOut, GLFW_KEY_KP_SUBTRACT, 0, "Picture", "-", "", 1, false},
    Shortcut{Action::kExposureUp, GLFW_KEY_RIGHT_BRACKET, 0, "Picture", "]",
             "brighter by 1/4 stop"},
    Shortcut{Action::kExposureDown, GLFW_KEY_LEFT_BRACKET, 0, "Picture", "[", "darker by 1/4 stop"},
    Shortcut{Action::kNextOverlay, GLFW_KEY_O, 0, "Picture", "O", "next overlay"},
    Shortcut{Action::kDenoise, GLFW_KEY_N, 0, "Picture", "N", "denoised, and raw again"},
    Shortcut{Action::kInspector, GLFW_KEY_I, 0, "Picture", "I", "pixel values beside the cursor"},
    Shortcut{Action::kExplain, GLFW_KEY_F3, 0, "Picture", "F3", "why is this pixel done?"},
    Shortcut{Action::kCopyPixel, GLFW_KEY_C, kControl, "Picture", "Ctrl+C",
             "copy the values of the pixel"},
    Shortcut{Action::kStoreSnapshot, GLFW_KEY_B, 0, "Picture", "B", "keep the picture as B"},
    Shortcut{Action::kWipe, GLFW_KEY_V, 0, "Picture", "V", "wipe between the picture and B"},
    Shortcut{Action::kWipeRaw, GLFW_KEY_V, kShift, "Picture", "Shift+V",
             "wipe between the denoised picture and the raw one"},

    Shortcut{Action::kPanels, GLFW_KEY_TAB, 0, "Window", "Tab", "panels away, and back"},
    Shortcut{Action::kFullScreen, GLFW_KEY_F11, 0, "Window", "F11", "full screen"},
    Shortcut{Action::kShortcuts, GLFW_KEY_F1, 0, "Window", "F1", "these shortcuts"},
    Shortcut{Action::kShortcuts, GLFW_KEY_H, 0, "Window", "H", "these shortcuts", 1, false},
    Shortcut{Action::kMessages, GLFW_KEY_F2, 0, "Window", "F2", "messages"},
};

constexpr std::array kFlightKeys = {
    FlightKey{Flight::kForward, GLFW_KEY_W, "W", "fly forward"},
    FlightKey{Flight::kBack, GLFW_KEY_S, "S", "fly back"},
    FlightKey{Flight::kLeft, GLFW_KEY_A, "A", "fly left"},
    FlightKey{Flight::kRight, GLFW_KEY_D, "D", "fly right"},
    FlightKey{Flight::kUp, GLFW_KEY_E, "E", "fly up"},
    FlightKey{Flight::kDown, GLFW_KEY_Q, "Q", "fly down"},
};

constexpr std::array kDrags = {
    DragGesture{Drag::kOrbit, GLFW_MOUSE_BUTTON_LEFT, 0, "Left drag", "orbit"},
    DragGesture{Drag::kPan, GLFW_MOUSE_BUTTON_MIDDLE, 0, "Middle drag", "pan"},
    DragGesture{Drag::kPan, GLFW_MOUSE_BUTTON_LEFT, kShift, "Shift+left drag", "pan"},
    DragGesture{Drag::kDolly, GLFW_MOUSE_BUTTON_LEFT, kAlt, "Alt+left drag", "dolly"},
    DragGesture{Drag::kLookAround, GLFW_MOUSE_BUTTON_RIGHT, 0, "Right drag", "look around"},
    DragGesture{Drag::kTurnEnvironment, GLFW_MOUSE_BUTTON_RIGHT, kShift, "Shift+right drag",
                "turn the environment"},
    DragGesture{Drag::kRegion, GLFW_MOUSE_BUTTON_LEFT, kControl, "Ctrl+left drag",
                "region that gets its samples first"},
    DragGesture{Drag::kMovePicture, GLFW_MOUSE_BUTTON_MIDDLE, kControl, "Ctrl+middle drag",
                "move the picture"},
};

constexpr std::array kListed = {
    ListedGesture{"Wheel", "dolly"},
    ListedGesture{"Ctrl+wheel", "zoom the picture"},
    ListedGesture{"Click", "select the material; choose the pixel that F3 explains"},
    ListedGesture{"Double click", "orbit around this point"},
    ListedGesture{"Shift while flying", "four times as fast"},
};

}  // namespace

std::span<const Shortcut> shortcut_table() { return kShortcuts; }

const Shortcut* find_shortcut(int key, int modifiers) {
  const auto found = std::ranges::find_if(kShortcuts, [&](const Shortcut& entry) {
    return key >= entry.key && key < entry.key + entry.key_count && entry.modifiers == modifiers;
  });
  return found == kShortcuts.end() ? nullptr : &*found;
}

std::string_view keys_of(Action action) {
  const auto found = std::ranges::find(kShortcuts, action, &Shortcut::action);
  return found == kShortcuts.end() ? std::string_view() : found->keys;
}

std::span<const FlightKey> flight_table() { return kFlightKeys; }

std::span<const DragGesture> drag_table() { return kDrags; }

const DragGesture* find_drag(int button, int modifiers) {
  const auto found = std::ranges::find_if(kDrags, [&](const DragGesture& entry) {
    return entry.button == button && entry.modifiers == modifiers;
  });
  return found == kDrags.end() ? nullptr : &*found;
}

std::span<const ListedGesture> listed_gestures() { return kListed; }

}  // namespace emberline
