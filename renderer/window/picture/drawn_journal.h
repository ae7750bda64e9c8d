// Writes to the journal what is on the screen. The window's thread only.
#pragma once

#include <memory>
#include <string>

#include "renderer/session/shown_picture.h"
#include "renderer/window/input/journal.h"
#include "renderer/window/picture/placement.h"

namespace emberline {

class DrawnJournal {
 public:
  // `journal` must outlive this.
  explicit DrawnJournal(Journal& journal) : journal_(journal) {}

  // After each frame: the picture that is on the screen, and where.
  void note(const std::shared_ptr<const ShownPicture>& picture, const PicturePlacement& placement);
  // `asking`: the dialog whose name is being typed; empty: none.
  void note_dialog(const std::string& asking);

 private:
  Journal& journal_;
  std::shared_ptr<const ShownPicture> picture_;
  Vec2f corner_ = Vec2f(0.0f);
  double zoom_ = 0.0;
  std::string dialog_;
};

}  // namespace emberline
