#include "renderer/session/edit_history.h"

#include <gtest/gtest.h>

namespace emberline {
namespace {

SceneEdits rotated(float degrees) {
  SceneEdits edits;
  edits.environment.rotation_degrees = degrees;
  return edits;
}

TEST(EditHistory, UndoesAndRedoesStepByStep) {
  EditHistory history;
  EXPECT_FALSE(history.can_undo());
  for (int i = 1; i <= 3; ++i) history.record(rotated(float(i)));
  EXPECT_FALSE(history.can_redo());
  EXPECT_EQ(history.undo(), rotated(2));
  EXPECT_EQ(history.undo(), rotated(1));
  EXPECT_EQ(history.undo(), SceneEdits{});
  EXPECT_FALSE(history.can_undo());
  EXPECT_EQ(history.undo(), SceneEdits{});
  EXPECT_EQ(history.redo(), rotated(1));
  EXPECT_EQ(history.redo(), rotated(2));
  EXPECT_EQ(history.redo(), rotated(3));
  EXPECT_EQ(history.redo(), rotated(3));
}

TEST(EditHistory, NewStepDiscardsUndoneSteps) {
  EditHistory history;
  history.record(rotated(1));
  history.record(rotated(2));
  history.undo();
  history.record(rotated(5));
  EXPECT_FALSE(history.can_redo());
  EXPECT_EQ(history.undo(), rotated(1));
}

TEST(EditHistory, ADragIsOneStep) {
  EditHistory history;
  history.record(rotated(1));
  for (int i = 2; i < 50; ++i) history.record(rotated(float(i)), "rotation");
  EXPECT_EQ(history.undo(), rotated(1));
  EXPECT_EQ(history.redo(), rotated(49));
}

TEST(EditHistory, TwoDragsAreTwo) {
  EditHistory history;
  history.record(rotated(1), "rotation");
  history.record(rotated(2), "rotation");
  history.end_gesture();
  history.record(rotated(3), "rotation");
  history.record(rotated(4), "strength");
  EXPECT_EQ(history.undo(), rotated(3));
  EXPECT_EQ(history.undo(), rotated(2));
  EXPECT_EQ(history.undo(), SceneEdits{});
}

// An edit after an undo must not merge with the restored step.
TEST(EditHistory, AnUndoEndsTheDrag) {
  EditHistory history;
  history.record(rotated(1), "rotation");
  history.end_gesture();
  history.record(rotated(2), "rotation");
  history.undo();
  history.record(rotated(3), "rotation");
  EXPECT_EQ(history.undo(), rotated(1));
}

TEST(EditHistory, UnchangedEditsAddNoStep) {
  EditHistory history(rotated(7));
  history.record(rotated(7));
  EXPECT_FALSE(history.can_undo());
  EXPECT_EQ(history.current(), rotated(7));
}

TEST(EditHistory, ForgetsTheOldestSteps) {
  EditHistory history;
  for (size_t i = 1; i <= EditHistory::kMaxSteps + 10; ++i) history.record(rotated(float(i)));
  size_t undone = 0;
  while (history.can_undo()) {
    history.undo();
    ++undone;
  }
  EXPECT_EQ(undone, EditHistory::kMaxSteps - 1);
  EXPECT_EQ(history.current(), rotated(11));
}

}  // namespace
}  // namespace emberline
