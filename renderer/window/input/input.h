// The tables of shortcuts and mouse gestures. The window's list of shortcuts shows them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace emberline {

// Actions that keys, menu entries and buttons can trigger.
enum class Action {
  kOpen,
  kReload,
  kSaveEdits,
  kSavePicture,
  kScreenshot,
  kQuit,
  kUndo,
  kRedo,
  kResetEdits,
  kPause,
  kRestart,
  kPlay,
  kNextFrame,
  kPreviousFrame,
  kFrameAll,
  kResetCamera,
  kOrthographic,
  kRecallBookmark,  // with a number from 1 to 9: see Shortcut::number_of()
  kStoreBookmark,
  kZoomFit,
  kZoomOne,
  kZoomIn,
  kZoomOut,
  kExposureUp,
  kExposureDown,
  kNextOverlay,
  kDenoise,
  kInspector,
  kExplain,
  kCopyPixel,
  kStoreSnapshot,
  kWipe,
  kWipeRaw,
  kClearRegion,
  kPanels,
  kFullScreen,
  kShortcuts,
  kMessages,
};

// Directions in which the camera flies while a key is held.
enum class Flight { kForward, kBack, kLeft, kRight, kUp, kDown };

// Effects of a drag over the picture.
enum class Drag { kOrbit, kPan, kDolly, kLookAround, kRotateEnvironment, kRegion, kMovePicture };

// Keys (GLFW_KEY_...) and modifiers (GLFW_MOD_SHIFT, _CONTROL, _ALT) use GLFW's values.
struct Shortcut {
  Action action;
  int key;
  int modifiers;
  std::string_view group;   // heading in the list
  std::string_view keys;    // shown to the user, for example "Ctrl+Shift+Z"
  std::string_view effect;  // shown to the user, for example "Undo the last edit"
  int key_count = 1;        // number of consecutive keys, from `key` on in GLFW's order
  bool listed = true;       // false for an alternative key of an entry above

  int number_of(int pressed) const { return 1 + pressed - key; }  // `key` itself is number 1
};
std::span<const Shortcut> shortcut_table();
// Returns the entry for a key, or null if there is none.
const Shortcut* find_shortcut(int key, int modifiers);
// Returns the keys of the action's first entry, such as "Ctrl+S", for menus. The result is empty if
// the action has no entry.
std::string_view keys_of(Action action);
// Returns what the action does, for tooltips. Every action has such a text.
std::string_view effect_of(Action action);

struct FlightKey {
  Flight flight;
  int key;
  std::string_view keys, effect;
};
std::span<const FlightKey> flight_table();

struct DragGesture {
  Drag drag;
  int button;  // GLFW_MOUSE_BUTTON_...
  int modifiers;
  std::string_view keys, effect;
};
std::span<const DragGesture> drag_table();
const DragGesture* find_drag(int button, int modifiers);

// A click or wheel gesture. Such gestures have no Action and are only shown in the list of
// shortcuts.
struct ListedGesture {
  std::string_view keys, effect;
};
std::span<const ListedGesture> listed_gestures();

}  // namespace emberline
