#include "renderer/app/progress_file.h"

#include <fmt/chrono.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>

#include "io/files/atomic_file.h"
#include "io/files/input_file.h"
#include "renderer/core/errors.h"
#include "renderer/core/log.h"
#include "renderer/engine/process_usage.h"

namespace emberline {

bool is_foreign_file(const std::string& path) {
  constexpr std::string_view kBegin = "{\n  \"state\": \"";
  try {
    const auto file = InputFile::try_open(path);
    std::string begin(kBegin.size(), '\0');
    return file && file->try_read(0, begin.size(), begin.data()) > 0 && begin != kBegin;
  } catch (const InputError&) {  // not a regular file, or unreadable
    return false;
  }
}

ProgressFile::ProgressFile(const std::string& path) : path_(path) {
  thread_ = std::thread([this] { run(); });
}

ProgressFile::~ProgressFile() {
  if (thread_.joinable()) finish(kExitRenderFailed);
}

void ProgressFile::set_source(std::function<RenderProgress()> source) {
  const std::lock_guard lock(mutex_);
  if (source_) current_ = source_();
  source_ = std::move(source);
}

std::string FramePosition::text() const {
  return fmt::format("frame {} ({} of {})", frame, index, count);
}

void ProgressFile::begin_frame(const FramePosition& frame_position) {
  const std::lock_guard lock(mutex_);
  if (position_) {
    earlier_frames_.done += 1;
    earlier_frames_.samples += current_.samples;
    earlier_frames_.elapsed_s += current_.elapsed_s;
  }
  current_ = {};
  position_ = frame_position;
}

RenderProgress ProgressFile::range_progress() const {
  if (!position_) return current_;
  RenderProgress range_progress;
  const double finished_frames = double(position_->index - 1) + std::clamp(current_.done, 0.0, 1.0);
  const double rendered = earlier_frames_.done + std::clamp(current_.done, 0.0, 1.0);
  const double left = double(position_->count) - finished_frames;
  range_progress.done = finished_frames / double(position_->count);
  range_progress.samples = earlier_frames_.samples + current_.samples;
  range_progress.elapsed_s = earlier_frames_.elapsed_s + current_.elapsed_s;
  if (rendered > 0 && !is_finishing_)
    range_progress.left_s = range_progress.elapsed_s * left / rendered;
  return range_progress;
}

void ProgressFile::finish(int exit_code) {
  {
    const std::lock_guard lock(mutex_);
    state_ = exit_code == kExitDone ? "done" : exit_code == kExitStopped ? "stopped" : "failed";
    if (exit_code == kExitDone) {
      if (position_) position_->index = position_->count;
      current_.done = 1;
      current_.left_s = 0;
    } else {
      current_.left_s.reset();
    }
    source_ = nullptr;
    is_finishing_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void ProgressFile::run() {
  constexpr auto kInterval = std::chrono::seconds(2);
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    last = is_finishing_;
    const std::string text = this->text();
    lock.unlock();
    write(text);
    lock.lock();
    if (!last) wake_.wait_for(lock, kInterval, [&] { return is_finishing_; });
  }
}

std::string ProgressFile::text() {
  if (source_) current_ = source_();
  const RenderProgress now = range_progress();
  nlohmann::ordered_json json = {
      {"state", state_},
      {"done", std::clamp(now.done, 0.0, 1.0)},
      {"samples", now.samples},
      {"elapsed_s", now.elapsed_s},
      {"left_s", nullptr},
      {"host", host_name()},
      {"pid", getpid()},
      {"written", fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr)))}};
  if (now.left_s) json["left_s"] = *now.left_s;
  if (position_) {
    json["frame"] = {{"number", position_->frame},
                     {"index", position_->index},
                     {"count", position_->count},
                     {"done", std::clamp(current_.done, 0.0, 1.0)}};
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void ProgressFile::write(const std::string& text) {
  try {
    write_file_atomically(path_, text);
  } catch (const RenderError& error) {
    if (!warned_) log_warning(std::string(error.what()) + "; the frame continues without it");
    warned_ = true;
  }
}

}  // namespace emberline
