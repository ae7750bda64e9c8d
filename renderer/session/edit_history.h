// Implements undo and redo. Each step stores the complete edits, that is, every difference from the
// file (scene_edits.h). Undo returns to the edits of the previous step.
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <utility>

#include "renderer/description/scene_edits.h"

namespace emberline {

class EditHistory {
 public:
  // The scene was opened with `edits`, and undo cannot go back beyond them.
  explicit EditHistory(SceneEdits edits = {}) { steps_.push_back(std::move(edits)); }

  // Adds a step and discards undone steps. Edits that equal the current edits add no step.
  // Consecutive steps with the same non-empty `gesture` are merged, for example the steps of one
  // drag, or the steps of a slider that is moved repeatedly.
  void record(const SceneEdits& edits, const std::string& gesture = {}) {
    if (edits == current()) return;
    const bool continues_gesture = !gesture.empty() && gesture == gesture_;
    steps_.resize(current_ + 1);
    gesture_ = gesture;
    if (continues_gesture) {
      steps_.back() = edits;
      return;
    }
    steps_.push_back(edits);
    if (steps_.size() > kMaxSteps) steps_.pop_front();
    current_ = steps_.size() - 1;
  }

  // Ends the gesture, such as a drag: the next step is not merged.
  void end_gesture() { gesture_.clear(); }

  bool can_undo() const { return current_ > 0; }
  bool can_redo() const { return current_ + 1 < steps_.size(); }
  // Return the edits to set, which are the current edits if there is nothing to undo or redo.
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

  // Beyond this number the oldest steps are dropped.
  static constexpr size_t kMaxSteps = 1000;

 private:
  std::deque<SceneEdits> steps_;
  size_t current_ = 0;
  std::string gesture_;  // gesture of the newest step; empty if nothing may be merged with it
};

}  // namespace emberline
