// Messages that the window shows to the user. Used on the window's thread only.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "renderer/window/input/journal.h"

namespace emberline {

struct Message {
  enum class Level : uint8_t { kNote, kWarning, kError } level = Level::kNote;
  std::string text;
  double time_s = 0.0;  // window_time_s() when it was added
};

class MessageLog {
 public:
  // Messages also go to `journal`, which must outlive this object.
  explicit MessageLog(Journal& journal) : journal_(journal) {}

  // A message with the same text as the newest message replaces that message.
  void note(const std::string& text);
  void warning(const std::string& text);
  void error(const std::string& text);

  // Returns the most recent messages, newest last.
  const std::deque<Message>& messages() const { return messages_; }
  // Returns whether there was a message since the last call.
  bool poll_changed();

 private:
  void add_message(Message::Level level, const std::string& text);

  Journal& journal_;
  std::deque<Message> messages_;
  bool has_changed_ = false;
};

}  // namespace emberline
