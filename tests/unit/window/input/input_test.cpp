// Tests the table of shortcuts: the list in the window agrees with the keys.
#include "renderer/window/input/input.h"

#include <gtest/gtest.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cctype>
#include <set>

namespace emberline {
namespace {

TEST(Input, NoKeyMeansTwoThings) {
  std::set<std::pair<int, int>> taken;
  for (const Shortcut& entry : shortcut_table()) {
    for (int i = 0; i < entry.key_count; ++i) {
      EXPECT_TRUE(taken.insert({entry.key + i, entry.modifiers}).second) << entry.keys;
    }
  }
  for (const FlightKey& entry : flight_table()) {
    EXPECT_TRUE(taken.insert({entry.key, 0}).second) << entry.keys;
  }
  std::set<std::pair<int, int>> drags;
  for (const DragGesture& entry : drag_table()) {
    EXPECT_TRUE(drags.insert({entry.button, entry.modifiers}).second) << entry.keys;
  }
}

TEST(Input, EveryActionIsListedOnce) {
  std::set<Action> listed;
  for (const Shortcut& entry : shortcut_table()) {
    if (!entry.listed) continue;
    EXPECT_TRUE(listed.insert(entry.action).second) << entry.keys;
    EXPECT_FALSE(entry.keys.empty());
    ASSERT_FALSE(entry.effect.empty()) << entry.keys;
    EXPECT_TRUE(std::isupper(entry.effect[0])) << entry.effect;
    EXPECT_FALSE(entry.effect.ends_with('.')) << entry.effect;
    EXPECT_EQ(effect_of(entry.action), entry.effect);
    EXPECT_EQ(keys_of(entry.action), entry.keys);
  }
  EXPECT_EQ(listed.size(), size_t(Action::kMessages) + 1);
}

TEST(Input, ModifiersHaveTheirRealNames) {
  for (const Shortcut& entry : shortcut_table()) {
    if (!entry.listed) continue;
    EXPECT_EQ(entry.keys.find("Ctrl+") != std::string_view::npos,
              (entry.modifiers & GLFW_MOD_CONTROL) != 0)
        << entry.keys;
    EXPECT_EQ(entry.keys.find("Shift+") != std::string_view::npos,
              (entry.modifiers & GLFW_MOD_SHIFT) != 0)
        << entry.keys;
  }
}

TEST(Input, FindsShortcutsAndDrags) {
  ASSERT_TRUE(find_shortcut(GLFW_KEY_Z, GLFW_MOD_CONTROL));
  EXPECT_EQ(find_shortcut(GLFW_KEY_Z, GLFW_MOD_CONTROL)->action, Action::kUndo);
  EXPECT_EQ(find_shortcut(GLFW_KEY_Z, GLFW_MOD_CONTROL | GLFW_MOD_SHIFT)->action, Action::kRedo);
  EXPECT_EQ(find_shortcut(GLFW_KEY_7, 0)->number_of(GLFW_KEY_7), 7);
  EXPECT_FALSE(find_shortcut(GLFW_KEY_Z, GLFW_MOD_ALT));
  EXPECT_EQ(find_drag(GLFW_MOUSE_BUTTON_LEFT, 0)->drag, Drag::kOrbit);
  EXPECT_EQ(find_drag(GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOD_SHIFT)->drag, Drag::kRotateEnvironment);
  EXPECT_FALSE(find_drag(GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOD_ALT));
}

}  // namespace
}  // namespace emberline
