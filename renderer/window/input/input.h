// The table of keys and mouse gestures and their actions, which the window's list of shortcuts
// shows.
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
  kRecallBookmark,  // number 1 to 9: see Shortcut::number_of()
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
enum class Drag { kOrbit, kPan, kDolly, kLookAround, kRotateEnvironment, kRegion, kMovePicture };

// Keys (GLFW_KEY_...) and modifiers (GLFW_MOD_SHIFT, _CONTROL, _ALT) use GLFW's values.
struct Shortcut {
  Action action;
  int key;
  int modifiers;
  std::string_view group;   // heading in the list
  std::string_view keys;    // readable, for example "Ctrl+Shift+Z"
  std::string_view effect;  // readable: "Undo the last edit"
  int key_count = 1;        // number of consecutive keys from `key` on, in GLFW's order
  bool listed = true;       // false: another key for the previous entry

  int number_of(int pressed) const { return 1 + pressed - key; }  // 1 for `key`
};
std::span<const Shortcut> shortcut_table();
// The entry for a key, or null.
const Shortcut* find_shortcut(int key, int modifiers);
// The keys of an action's first entry, such as "Ctrl+S", for menus. Empty if none.
std::string_view keys_of(Action action);
// What the action does, for tooltips; every action has a text.
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

// Clicks and the wheel, which have no action; only for the list.
struct ListedGesture {
  std::string_view keys, effect;
};
std::span<const ListedGesture> listed_gestures();

}  // namespace emberline
