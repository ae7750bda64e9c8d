#pragma once
#include <string>
#include <vector>
#include "renderer/scene/scene_edits.h"
namespace emberline {
class EditHistory {
 public:
  void reset(const SceneEdits& e) {
    list_ = {e};
    at_ = 0;
    key_.clear();
  }
  void change(const SceneEdits& e, const std::string& key) {
    if (key == key_ && at_ > 0) {
      list_.resize(at_ + 1);
      list_[at_] = e;
      return;
    }
    list_.resize(at_ + 1);
    list_.push_back(e);
    ++at_;
    key_ = key;
  }
  void end_gesture() { key_.clear(); }
  bool can_undo() const { return at_ > 0; }
  bool can_redo() const { return at_ + 1 < list_.size(); }
  const SceneEdits& undo() {
    key_.clear();
    return list_[--at_];
  }
  const SceneEdits& redo() {
    key_.clear();
    return list_[++at_];
  }

 private:
  std::vector<SceneEdits> list_ = {SceneEdits{}};
  size_t at_ = 0;
  std::string key_;
};
}  // namespace emberline
