// Writes to the journal what the window displays. Used on the window's thread only.
#pragma once

#include <memory>
#include <string>

#include "renderer/session/session_picture.h"
#include "renderer/window/input/journal.h"
#include "renderer/window/picture/placement.h"

namespace emberline {

class DrawnJournal {
 public:
  // `journal` must outlive this object.
  explicit DrawnJournal(Journal& journal) : journal_(journal) {}

  // Call after each frame with the displayed picture and its placement.
  void record_picture(const std::shared_ptr<const SessionPicture>& picture,
                      const PicturePlacement& placement);
  // `focused_dialog` is the title of the dialog whose name field has keyboard focus, or empty.
  void record_dialog(const std::string& focused_dialog);

 private:
  Journal& journal_;
  std::shared_ptr<const SessionPicture> picture_;
  Vec2f corner_ = Vec2f(0.0f);
  double zoom_ = 0.0;
  std::string dialog_;
};

}  // namespace emberline
