#include "renderer/session/session_host.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <list>
#include <mutex>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "io/json/input.h"
#include "io/json/reader.h"
#include "io/json/value.h"
#include "renderer/core/errors.h"
#include "renderer/core/file_suffix.h"
#include "renderer/core/log.h"
#include "renderer/core/names.h"
#include "renderer/core/utf8.h"
#include "renderer/core/version.h"
#include "renderer/engine/setting_table.h"
#include "renderer/output/report.h"
#include "renderer/session/host_values.h"
#include "renderer/session/line_stream.h"
#include "renderer/session/overlay_picture.h"
#include "renderer/session/render_session.h"
#include "renderer/session/shared_frames.h"

namespace emberline {
namespace {

using Json = nlohmann::json;

constexpr int kSessionProtocol = 1;

// Limits on queued warnings and files waiting to be written.
constexpr size_t kMostWarnings = 100, kMostSavings = 16;
constexpr size_t kLongestId = 1000;
// Polling interval while files are being saved, and the load progress worth an event.
constexpr int kSavingPause_ms = 20;
constexpr double kLoadStep = 0.01;

void check_id(const Json& id, const JsonReader& reader) {
  const bool short_text = id.is_string() && id.get_ref<const std::string&>().size() <= kLongestId;
  if (!id.is_null() && !id.is_number() && !short_text) reader.expected("a number or a short text");
}

class SessionHost {
 public:
  SessionHost(std::function<HostSettings(const HostTexts&)> settings, int in, int out)
      : read_settings_(std::move(settings)), lines_(in, out), session_(read_settings_({}).view) {
    display_ = read_settings_({}).display;
    session_.on_change([this] { lines_.wake(); });
    set_log_sink([this](LogKind kind, std::string_view message) {
      if (kind != LogKind::kWarning) return;
      const std::lock_guard lock(warnings_mutex_);
      if (warnings_.size() < kMostWarnings) warnings_.emplace_back(message);
      lines_.wake();
    });
  }

  ~SessionHost() {
    session_.on_change({});
    set_log_sink({});
  }

  void run() {
    send({{"event", "hello"},
          {"protocol", kSessionProtocol},
          {"emberline", kEmberlineVersion},
          {"isa", instruction_sets()},
          {"pid", int(::getpid())}});
    try {
      serve();
      settle();
    } catch (const InputError& error) {
      settle();
      send({{"event", "error"}, {"text", error.what()}});
      try {
        lines_.flush();
      } catch (const RenderError&) {  // it does not read either
      }
      throw;
    }
    lines_.flush();
    if (failed_saves_ > 1) {
      throw RenderError("{} (and {} more could not be saved)", first_failure_, failed_saves_ - 1);
    }
    if (failed_saves_ > 0) throw RenderError(first_failure_);
  }

 private:
  struct Command {
    std::string_view name;
    std::vector<std::string_view> members;  // besides "id" and "do"
    void (SessionHost::*run)(const Json& command, const JsonReader& root, const std::string& line);
    bool answered = true;  // answered immediately
  };
  // Commands that are answered later.
  struct Opening {
    JsonValue id;
    SceneEdits edits;
    bool edited = false, has_camera = false;
  };
  struct Saving {
    JsonValue id;
    std::future<void> done;
  };

  void serve() {
    while (true) {
      // Commands before the end of input are carried out even if the host does not read; there are
      // few.
      while (!quit_ && (lines_.ended() || !lines_.congested())) {
        const std::optional<std::string> line = lines_.take();
        if (!line) break;
        obey(*line);
      }
      if (quit_) return;
      if (lines_.ended()) {
        throw InputError("standard input", lines_.mid_line()
                                               ? "it ends in the middle of a line"
                                               : "it ends without \"quit\": the host has gone");
      }
      tell();
      lines_.wait(savings_.empty() ? std::nullopt : std::optional(kSavingPause_ms));
    }
  }

  // Waits for files that are being saved, and reports their results.
  void settle() {
    for (const Saving& saving : savings_) saving.done.wait();
    tell_saved();
    if (opening_) refuse(*std::exchange(opening_, std::nullopt)->id, "cancelled: the session ends");
  }

  void obey(const std::string& text) {
    static const std::vector<Command> commands = {
        {"open", {"scene", "edits_file", "edits"}, &SessionHost::open, false},
        {"settings", {"settings"}, &SessionHost::change_settings},
        {"camera", {"camera"}, &SessionHost::change_camera},
        {"edits", {"edits"}, &SessionHost::change_edits},
        {"next", {"after"}, &SessionHost::next},
        {"save", {"file", "of"}, &SessionHost::save, false},
        {"cancel", {}, &SessionHost::cancel},
        {"quit", {}, &SessionHost::quit}};
    const std::string line = "line " + std::to_string(++line_number_);
    const Json document = parse_json(text, line);
    if (!document.is_object()) throw InputError(line, "expected an object with a command");
    Json id;
    const auto verb = document.find("do");
    const bool saves = verb != document.end() && *verb == "save";
    try {
      const JsonReader root(document, line);
      if (root.has("id")) {
        check_id(document["id"], root["id"]);
        id = document["id"];
      }
      const Command& command = find_named(commands, line, "command", root["do"].text());
      std::vector<std::string_view> members = command.members;
      members.insert(members.end(), {"id", "do"});
      root.object(members);
      (this->*command.run)(document, root, line);
      if (command.answered && !id.is_null()) answer(id);
    } catch (const EmberlineError& error) {
      refuse(id, error.what(), saves);
    } catch (const std::bad_alloc&) {
      refuse(id, "not enough memory for this command", saves);
    }
  }

  // ---- commands

  void open(const Json& command, const JsonReader& root, const std::string& line) {
    const std::string scene = text_of_json(command.value("scene", Json()), root["scene"]);
    const std::string edits_file =
        root.has("edits_file") ? text_of_json(command["edits_file"], root["edits_file"]) : "";
    Opening opening{JsonValue(root.has("id") ? command["id"] : Json()), {}};
    if (root.has("edits")) {
      opening.edits = merged_edits(command["edits"], line + ", edits", {}, {});
      opening.edited = true;
      opening.has_camera = command["edits"].contains("camera");
    }
    if (opening_) refuse(*opening_->id, "cancelled: another scene was opened");
    opening_ = std::move(opening);
    told_stage_.clear();
    session_.open(scene, edits_file);
  }

  void change_settings(const Json& command, const JsonReader& root, const std::string&) {
    const JsonReader settings = root["settings"];
    HostTexts texts = texts_;
    for (const std::string& name : settings.members()) {
      const JsonReader value = settings[name];
      if (value.null()) {
        texts.erase(name);
      } else {
        texts[name] = text_of_json(command["settings"][name], value);
      }
    }
    HostSettings made = read_settings_(texts);
    if (made.display != display_) shown_serial_ = 0;  // show the newest picture again
    session_.set_settings(made.view);
    texts_ = std::move(texts);
    display_ = made.display;
  }

  // While a scene loads, the camera also applies to that scene.
  void change_camera(const Json& command, const JsonReader& root, const std::string& line) {
    root["camera"];
    if (!session_.scene() && !opening_) throw UsageError("no scene is open");
    const Json changes = {{"camera", command["camera"]}};
    const CameraEdit camera = merged_edits(changes, line, {}, {}).camera;
    if (session_.scene()) {
      SceneEdits edits = session_.edits();
      edits.camera = camera;
      session_.set_edits(edits);
    }
    if (!opening_) return;
    opening_->edits.camera = camera;
    opening_->edited = opening_->has_camera = true;
  }

  void change_edits(const Json& command, const JsonReader& root, const std::string& line) {
    root["edits"];
    const std::shared_ptr<const ListedScene> scene = session_.scene();
    if (!scene) throw UsageError("no scene is open");
    session_.set_edits(
        merged_edits(command["edits"], line + ", edits", session_.edits(), scene->outline));
  }

  void next(const Json&, const JsonReader& root, const std::string&) {
    const uint64_t after = root["after"].whole(0, UINT64_MAX);
    if (after > number_) throw UsageError("there is no picture {} yet", after);
    if (after == number_) awaited_ = true;
  }

  void save(const Json& command, const JsonReader& root, const std::string& line) {
    const std::string file = text_of_json(command.value("file", Json()), root["file"]);
    if (savings_.size() >= kMostSavings) {
      throw UsageError("{} cannot be saved yet: {} files are being saved; wait for an answer",
                       printable(file), kMostSavings);
    }
    std::future<void> done;
    if (root.has("of")) {
      const OverlayEntry& overlay =
          find_named(overlay_table(), line, "heatmap quantity", root["of"].text());
      done = session_.save_heatmap(file, ViewOverlay(&overlay - overlay_table().data()));
    } else if (lower_suffix(file) == ".json") {
      done = session_.save_edits(file);
    } else {
      done = session_.save(file);
    }
    savings_.push_back({JsonValue(root.has("id") ? command["id"] : Json()), std::move(done)});
  }

  void cancel(const Json&, const JsonReader&, const std::string&) { session_.cancel_load(); }

  void quit(const Json&, const JsonReader&, const std::string&) { quit_ = true; }

  // ---- answers and events

  void answer(const Json& id, Json more = Json::object()) {
    more["id"] = id;
    more["ok"] = true;
    more["edit"] = session_.edit();
    send(more);
  }

  void refuse(const Json& id, const std::string& error, bool of_save = false) {
    if (of_save && failed_saves_++ == 0) first_failure_ = error;
    send({{"id", id}, {"ok", false}, {"error", error}});
  }

  void send(const Json& message) {
    lines_.write(message.dump(-1, ' ', true, Json::error_handler_t::replace));
  }

  void tell() {
    tell_loading();
    tell_saved();
    if (lines_.congested()) return;
    tell_warnings();
    tell_problem();
    show_picture();
  }

  void tell_loading() {
    const LoadStatus status = session_.load_status();
    if (!opening_) return;
    using enum LoadStatus::State;
    switch (status.state) {
      case kReady:
        finish_opening();
        break;
      case kFailed:
        refuse(*std::exchange(opening_, std::nullopt)->id, status.error);
        break;
      case kCancelled:
        refuse(*std::exchange(opening_, std::nullopt)->id, "cancelled");
        break;
      default:
        if (lines_.congested() || (status.stage == told_stage_ &&
                                   std::abs(status.fraction - told_fraction_) < kLoadStep)) {
          break;
        }
        told_stage_ = status.stage;
        told_fraction_ = status.fraction;
        send({{"event", "loading"}, {"stage", status.stage}, {"fraction", status.fraction}});
    }
  }

  void finish_opening() {
    const Opening opening = *std::exchange(opening_, std::nullopt);
    const std::shared_ptr<const ListedScene> scene = session_.scene();
    Json more = Json::object();
    if (opening.edited) {
      try {
        SceneEdits edits = laid_over(opening.edits, session_.edits(), scene->outline);
        if (opening.has_camera) edits.camera = opening.edits.camera;
        session_.set_edits(edits);
      } catch (const EmberlineError& error) {
        more["problem"] = error.what();
      }
    }
    least_edit_ = session_.edit();
    more["scene"] = described(*scene, session_.edits());
    answer(*opening.id, std::move(more));
  }

  void tell_warnings() {
    std::vector<std::string> warnings;
    {
      const std::lock_guard lock(warnings_mutex_);
      warnings.swap(warnings_);
    }
    for (const std::string& text : warnings) send({{"event", "warning"}, {"text", text}});
  }

  void tell_problem() {
    const std::string problem = session_.problem().empty() ? frame_problem_ : session_.problem();
    if (problem == told_problem_) return;
    told_problem_ = problem;
    send({{"event", "problem"}, {"text", problem}});
  }

  void tell_saved() {
    using std::chrono::seconds;
    for (auto saving = savings_.begin(); saving != savings_.end();) {
      if (saving->done.wait_for(seconds(0)) != std::future_status::ready) {
        ++saving;
        continue;
      }
      try {
        saving->done.get();
        answer(*saving->id);
      } catch (const std::exception& error) {
        refuse(*saving->id, error.what(), true);
      }
      saving = savings_.erase(saving);
    }
  }

  void show_picture() {
    const std::shared_ptr<const ShownPicture> picture = session_.picture();
    if (!awaited_ || !picture || picture->serial == shown_serial_ || picture->edit < least_edit_) {
      return;
    }
    shown_serial_ = picture->serial;
    // Overlays have no linear values.
    const bool display = display_ || !picture->overlay_legend.empty();
    const std::span<const std::byte> bytes = display ? std::as_bytes(std::span(picture->rgba8))
                                                     : std::as_bytes(std::span(picture->linear()));
    SharedFrames::Place place;
    try {
      place = frames_.write(bytes, session_.memory(), "a picture in shared memory");
      frame_problem_.clear();
    } catch (const EmberlineError& error) {
      frame_problem_ = error.what();
      tell_problem();
      return;
    }
    awaited_ = false;
    Json event = described(*picture);
    event["number"] = ++number_;
    event["format"] = display ? "display" : "linear";
    event["stride"] = bytes.size() / size_t(picture->height);
    event["memory"] = place.path;
    event["segment"] = place.segment;
    event["bytes"] = place.bytes;
    event["offset"] = place.offset;
    send(event);
  }

  const std::function<HostSettings(const HostTexts&)> read_settings_;
  HostTexts texts_;
  bool display_ = false, quit_ = false;
  LineStream lines_;
  uint64_t line_number_ = 0;
  std::mutex warnings_mutex_;
  std::vector<std::string> warnings_;
  RenderSession session_;
  std::optional<Opening> opening_;
  std::list<Saving> savings_;
  uint64_t failed_saves_ = 0;
  std::string first_failure_;
  std::string told_stage_, told_problem_, frame_problem_;
  double told_fraction_ = 0.0;

  SharedFrames frames_;
  uint64_t least_edit_ = 0;    // earlier pictures show another scene
  uint64_t shown_serial_ = 0;  // of the session's pictures
  uint64_t number_ = 0;        // of our picture events
  bool awaited_ = true;        // the host has consumed the previous picture
};

}  // namespace

void run_session_host(std::function<HostSettings(const HostTexts&)> settings, int in, int out) {
  SessionHost(std::move(settings), in, out).run();
}

}  // namespace emberline
