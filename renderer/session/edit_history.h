// Undo and redo. Edits say what differs from the file (scene_edits.h), so that a step of history is
// the edits as they were, and undoing is setting them again.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <utility>

#include "renderer/description/scene_edits.h"

namespace emberline {

class EditHistory {
 public:
  // The first entry, to which undo goes back: the edits that a scene was opened with.
  explicit EditHistory(SceneEdits edits = {}) { steps_.push_back(std::move(edits)); }

  // A new step; what was undone is lost. Edits equal to the current ones are none. Steps in a row
  // with the same `gesture`, not empty, become one: what a drag does from its beginning to its end,
  // or a slider that is moved again.
  void record(const SceneEdits& edits, const std::string& gesture = {}) {
    if (edits == current()) return;
    const bool goes_on = !gesture.empty() && gesture == gesture_;
    steps_.resize(current_ + 1);
    gesture_ = gesture;
    if (goes_on) {
      steps_.back() = edits;
      return;
    }
    steps_.push_back(edits);
    if (steps_.size() > kMostSteps) steps_.pop_front();
    current_ = steps_.size() - 1;
  }

  // The mouse is let go: the next step with the same gesture is one of its own.
  void end_gesture() { gesture_.clear(); }

  bool can_undo() const { return current_ > 0; }
  bool can_redo() const { return current_ + 1 < steps_.size(); }
  // Return what is to be set; without anything to undo or redo, the current edits.
  const SceneEdits& undo() {
    gesture_.clear();
    if (can_undo()) --current_;
    return current();
  }

  const SceneEdits& redo() {
    gesture_.clear();
    if (can_redo()) ++current_;
    return current();
  }

  const SceneEdits& current() const { return steps_[current_]; }

  // The oldest steps beyond this are forgotten.
  static constexpr size_t kMostSteps = 1000;

 private:
  std::deque<SceneEdits> steps_;
  size_t current_ = 0;
  std::string gesture_;  // of the newest step, while it may go on
};

}  // namespace emberline
