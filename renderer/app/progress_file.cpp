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

bool is_other_file(const std::string& path) {
  constexpr std::string_view kBegin = "{\n  \"state\": \"";
  try {
    const auto file = InputFile::open_if_there(path);
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

void ProgressFile::watch(std::function<RenderProgress()> source) {
  const std::lock_guard lock(mutex_);
  if (source_) last_ = source_();
  source_ = std::move(source);
}

std::string FramePlace::text() const {
  return fmt::format("frame {} ({} of {})", frame, index, count);
}

void ProgressFile::begin_frame(const FramePlace& place) {
  const std::lock_guard lock(mutex_);
  if (place_) {
    earlier_.done += 1;
    earlier_.samples += last_.samples;
    earlier_.elapsed_s += last_.elapsed_s;
  }
  last_ = {};
  place_ = place;
}

RenderProgress ProgressFile::whole() const {
  if (!place_) return last_;
  RenderProgress whole;
  const double behind = double(place_->index - 1) + std::clamp(last_.done, 0.0, 1.0);
  const double rendered = earlier_.done + std::clamp(last_.done, 0.0, 1.0);
  const double left = double(place_->count) - behind;
  whole.done = behind / double(place_->count);
  whole.samples = earlier_.samples + last_.samples;
  whole.elapsed_s = earlier_.elapsed_s + last_.elapsed_s;
  if (rendered > 0 && !ending_) whole.left_s = whole.elapsed_s * left / rendered;
  return whole;
}

void ProgressFile::finish(int exit_code) {
  {
    const std::lock_guard lock(mutex_);
    state_ = exit_code == kExitDone ? "done" : exit_code == kExitStopped ? "stopped" : "failed";
    if (exit_code == kExitDone) {
      if (place_) place_->index = place_->count;
      last_.done = 1;
      last_.left_s = 0;
    } else {
      last_.left_s.reset();
    }
    source_ = nullptr;
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void ProgressFile::run() {
  constexpr auto kInterval = std::chrono::seconds(2);
  std::unique_lock lock(mutex_);
  for (bool last = false; !last;) {
    last = ending_;
    const std::string text = this->text();
    lock.unlock();
    write(text);
    lock.lock();
    if (!last) wake_.wait_for(lock, kInterval, [&] { return ending_; });
  }
}

std::string ProgressFile::text() {
  if (source_) last_ = source_();
  const RenderProgress now = whole();
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
  if (place_) {
    json["frame"] = {{"number", place_->frame},
                     {"index", place_->index},
                     {"count", place_->count},
                     {"done", std::clamp(last_.done, 0.0, 1.0)}};
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
