// Keys and mouse: one table from what a hand does to what the window does about it, which the list
// of shortcuts in the window shows as it stands.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace emberline {

// Actions of keys, menu entries and buttons.
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
  kRecallBookmark,  // number 1 to 9: Shortcut::number_of
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

// Movements while a key is held.
enum class Flight { kForward, kBack, kLeft, kRight, kUp, kDown };

// Effects of a drag over the picture.
enum class Drag { kOrbit, kPan, kDolly, kLookAround, kTurnEnvironment, kRegion, kMovePicture };

// As GLFW numbers them: keys (GLFW_KEY_...) and modifiers (GLFW_MOD_SHIFT, _CONTROL, _ALT).
struct Shortcut {
  Action action;
  int key;
  int modifiers;
  std::string_view group;   // of the list
  std::string_view keys;    // "Ctrl+Shift+Z", for people
  std::string_view effect;  // for people
  int key_count = 1;        // keys from `key` on, in GLFW's order
  bool listed = true;       // false: the same as the entry before, by another key

  int number_of(int pressed) const { return 1 + pressed - key; }  // 1: `key`
};
std::span<const Shortcut> shortcut_table();
// The entry for a key; none.
const Shortcut* find_shortcut(int key, int modifiers);
// "Ctrl+S": the first entry for an action, for menus. Empty if none.
std::string_view keys_of(Action action);

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

// Clicks and the wheel, which have no action of their own to look up; for the list alone.
struct ListedGesture {
  std::string_view keys, effect;
};
std::span<const ListedGesture> listed_gestures();

}  // namespace emberline
