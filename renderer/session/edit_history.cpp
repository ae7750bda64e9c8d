#include "renderer/session/edit_history.h"

#include <utility>

namespace emberline {

EditHistory::EditHistory(SceneEdits edits) { steps_.push_back(std::move(edits)); }

void EditHistory::record(const SceneEdits& edits, const std::string& gesture) {
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

const SceneEdits& EditHistory::undo() {
  gesture_.clear();
  if (can_undo()) --current_;
  return current();
}

const SceneEdits& EditHistory::redo() {
  gesture_.clear();
  if (can_redo()) ++current_;
  return current();
}

}  // namespace emberline
