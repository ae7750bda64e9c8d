#include "renderer/window/input/input.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>

namespace emberline {
namespace {

constexpr int kShift = GLFW_MOD_SHIFT, kControl = GLFW_MOD_CONTROL, kAlt = GLFW_MOD_ALT;

constexpr std::array kShortcuts = {
    Shortcut{Action::kOpen, GLFW_KEY_O, kControl, "File", "Ctrl+O",
             "Open a scene, an environment or an edits file"},
    Shortcut{Action::kReload, GLFW_KEY_R, kControl, "File", "Ctrl+R",
             "Read the scene again and keep the edits"},
    Shortcut{Action::kSaveEdits, GLFW_KEY_S, kControl, "File", "Ctrl+S",
             "Save the edits to a file beside the scene"},
    Shortcut{Action::kSavePicture, GLFW_KEY_S, kControl | kShift, "File", "Ctrl+Shift+S",
             "Save the picture or the heatmap"},
    Shortcut{Action::kScreenshot, GLFW_KEY_F12, 0, "File", "F12",
             "Save a screenshot of the window"},
    Shortcut{Action::kQuit, GLFW_KEY_Q, kControl, "File", "Ctrl+Q", "Close the window"},

    Shortcut{Action::kUndo, GLFW_KEY_Z, kControl, "Edits", "Ctrl+Z", "Undo the last edit"},
    Shortcut{Action::kRedo, GLFW_KEY_Z, kControl | kShift, "Edits", "Ctrl+Shift+Z",
             "Redo the last undone edit"},
    Shortcut{Action::kRedo, GLFW_KEY_Y, kControl, "Edits", "Ctrl+Y", "Redo the last undone edit", 1,
             false},
    Shortcut{Action::kResetEdits, GLFW_KEY_BACKSPACE, kControl, "Edits", "Ctrl+Backspace",
             "Reset all edits; can be undone"},

    Shortcut{Action::kPause, GLFW_KEY_SPACE, 0, "Render", "Space", "Pause or resume rendering"},
    Shortcut{Action::kRestart, GLFW_KEY_F5, 0, "Render", "F5",
             "Restart rendering with different noise"},
    Shortcut{Action::kClearRegion, GLFW_KEY_ESCAPE, 0, "Render", "Esc",
             "Remove the region and end solo"},

    Shortcut{Action::kPlay, GLFW_KEY_K, 0, "Time", "K", "Play or stop the animation"},
    Shortcut{Action::kNextFrame, GLFW_KEY_PERIOD, 0, "Time", ".", "Go to the next frame"},
    Shortcut{Action::kPreviousFrame, GLFW_KEY_COMMA, 0, "Time", ",", "Go to the previous frame"},

    Shortcut{Action::kFrameAll, GLFW_KEY_F, 0, "Camera", "F",
             "Move the camera to show the whole scene"},
    Shortcut{Action::kResetCamera, GLFW_KEY_R, 0, "Camera", "R", "Go back to the file's camera"},
    Shortcut{Action::kOrthographic, GLFW_KEY_P, 0, "Camera", "P",
             "Switch between orthographic and perspective"},
    Shortcut{Action::kRecallBookmark, GLFW_KEY_1, 0, "Camera", "1 to 9", "Go to a bookmark", 9},
    Shortcut{Action::kStoreBookmark, GLFW_KEY_1, kControl, "Camera", "Ctrl+1 to 9",
             "Store the view as a bookmark", 9},

    Shortcut{Action::kZoomFit, GLFW_KEY_0, 0, "Picture", "0", "Fit the picture to the window"},
    Shortcut{Action::kZoomOne, GLFW_KEY_Z, 0, "Picture", "Z",
             "Switch between actual size and fitting the picture to the window"},
    Shortcut{Action::kZoomIn, GLFW_KEY_EQUAL, 0, "Picture", "+", "Zoom in"},
    Shortcut{Action::kZoomIn, GLFW_KEY_KP_ADD, 0, "Picture", "+", "", 1, false},
    Shortcut{Action::kZoomIn, GLFW_KEY_EQUAL, kShift, "Picture", "+", "", 1, false},
    Shortcut{Action::kZoomOut, GLFW_KEY_MINUS, 0, "Picture", "-", "Zoom out"},
    Shortcut{Action::kZoomOut, GLFW_KEY_KP_SUBTRACT, 0, "Picture", "-", "", 1, false},
    Shortcut{Action::kExposureUp, GLFW_KEY_RIGHT_BRACKET, 0, "Picture", "]",
             "Increase the exposure by 1/4 stop"},
    Shortcut{Action::kExposureDown, GLFW_KEY_LEFT_BRACKET, 0, "Picture", "[",
             "Decrease the exposure by 1/4 stop"},
    Shortcut{Action::kNextOverlay, GLFW_KEY_O, 0, "Picture", "O", "Show the next overlay"},
    Shortcut{Action::kDenoise, GLFW_KEY_N, 0, "Picture", "N", "Turn denoising on or off"},
    Shortcut{Action::kInspector, GLFW_KEY_I, 0, "Picture", "I",
             "Show pixel values beside the cursor"},
    Shortcut{Action::kExplain, GLFW_KEY_F3, 0, "Picture", "F3",
             "Explain why a pixel got its number of samples"},
    Shortcut{Action::kCopyPixel, GLFW_KEY_C, kControl, "Picture", "Ctrl+C",
             "Copy the values of the pixel"},
    Shortcut{Action::kStoreSnapshot, GLFW_KEY_B, 0, "Picture", "B",
             "Keep the picture as B for comparison"},
    Shortcut{Action::kWipe, GLFW_KEY_V, 0, "Picture", "V", "Wipe between the picture and B"},
    Shortcut{Action::kWipeRaw, GLFW_KEY_V, kShift, "Picture", "Shift+V",
             "Wipe between denoised and raw"},

    Shortcut{Action::kPanels, GLFW_KEY_TAB, 0, "Window", "Tab", "Show or hide the side panel"},
    Shortcut{Action::kFullScreen, GLFW_KEY_F11, 0, "Window", "F11", "Enter or leave full screen"},
    Shortcut{Action::kShortcuts, GLFW_KEY_F1, 0, "Window", "F1",
             "Show or hide this list of shortcuts"},
    Shortcut{Action::kShortcuts, GLFW_KEY_H, 0, "Window", "H",
             "Show or hide this list of shortcuts", 1, false},
    Shortcut{Action::kMessages, GLFW_KEY_F2, 0, "Window", "F2", "Show or hide the messages"},
};

constexpr std::array kFlightKeys = {
    FlightKey{Flight::kForward, GLFW_KEY_W, "W", "Fly forward"},
    FlightKey{Flight::kBack, GLFW_KEY_S, "S", "Fly back"},
    FlightKey{Flight::kLeft, GLFW_KEY_A, "A", "Fly left"},
    FlightKey{Flight::kRight, GLFW_KEY_D, "D", "Fly right"},
    FlightKey{Flight::kUp, GLFW_KEY_E, "E", "Fly up"},
    FlightKey{Flight::kDown, GLFW_KEY_Q, "Q", "Fly down"},
};

constexpr std::array kDrags = {
    DragGesture{Drag::kOrbit, GLFW_MOUSE_BUTTON_LEFT, 0, "Left drag", "Orbit"},
    DragGesture{Drag::kPan, GLFW_MOUSE_BUTTON_MIDDLE, 0, "Middle drag", "Pan"},
    DragGesture{Drag::kPan, GLFW_MOUSE_BUTTON_LEFT, kShift, "Shift+left drag", "Pan"},
    DragGesture{Drag::kDolly, GLFW_MOUSE_BUTTON_LEFT, kAlt, "Alt+left drag", "Dolly"},
    DragGesture{Drag::kLookAround, GLFW_MOUSE_BUTTON_RIGHT, 0, "Right drag", "Look around"},
    DragGesture{Drag::kRotateEnvironment, GLFW_MOUSE_BUTTON_RIGHT, kShift, "Shift+right drag",
                "Rotate the environment"},
    DragGesture{Drag::kRegion, GLFW_MOUSE_BUTTON_LEFT, kControl, "Ctrl+left drag",
                "Select a region to sample first"},
    DragGesture{Drag::kMovePicture, GLFW_MOUSE_BUTTON_MIDDLE, kControl, "Ctrl+middle drag",
                "Move the picture"},
};

constexpr std::array kListed = {
    ListedGesture{"Wheel", "Dolly"},
    ListedGesture{"Ctrl+wheel", "Zoom the picture"},
    ListedGesture{"Click", "Select the material, and the pixel for F3"},
    ListedGesture{"Double click", "Orbit around this point and focus on it"},
    ListedGesture{"Shift while flying", "Fly four times as fast"},
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

std::string_view effect_of(Action action) {
  const auto found = std::ranges::find(kShortcuts, action, &Shortcut::action);
  return found == kShortcuts.end() ? std::string_view() : found->effect;
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
