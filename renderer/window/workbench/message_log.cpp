#include "renderer/window/workbench/message_log.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "renderer/window/workbench/clock.h"

namespace emberline {
namespace {

constexpr size_t kMaxMessages = 200;

}  // namespace

void MessageLog::note(const std::string& text) { add_message(Message::Level::kNote, text); }
void MessageLog::warning(const std::string& text) { add_message(Message::Level::kWarning, text); }
void MessageLog::error(const std::string& text) { add_message(Message::Level::kError, text); }

bool MessageLog::poll_changed() { return std::exchange(has_changed_, false); }

void MessageLog::add_message(Message::Level level, const std::string& text) {
  if (!messages_.empty() && messages_.back().text == text) messages_.pop_back();
  messages_.push_back({level, text, window_time_s()});
  if (messages_.size() > kMaxMessages) messages_.pop_front();
  has_changed_ = true;
  constexpr std::array kNames = {"note", "warning", "error"};
  journal_.write("message", {{"level", kNames[size_t(level)]}, {"text", text}});
}

}  // namespace emberline
