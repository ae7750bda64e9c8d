#include "renderer/session/session_host.h"

#include <unistd.h>

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
constexpr size_t kMaxWarnings = 100, kMaxPendingSaves = 16;
constexpr size_t kMaxIdLength = 1000;
// Polling interval while files are being saved, and the smallest step of load progress that is sent
// as an event.
constexpr int kSavePollInterval_ms = 20;
constexpr double kLoadStep = 0.01;

void check_id(const Json& id, const JsonReader& reader) {
  const bool short_text = id.is_string() && id.get_ref<const std::string&>().size() <= kMaxIdLength;
  if (!id.is_null() && !id.is_number() && !short_text)
    reader.throw_expected("a number or a text of at most " + std::to_string(kMaxIdLength) +
                          " bytes");
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
      if (warnings_.size() < kMaxWarnings) warnings_.emplace_back(message);
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
      process_commands();
      drain_saves();
    } catch (const InputError& error) {
      drain_saves();
      send({{"event", "error"}, {"text", error.what()}});
      try {
        lines_.flush();
      } catch (const RenderError&) {  // the host does not read; report the first error
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
    bool answers_immediately = true;
  };
  // Commands that are answered later.
  struct PendingOpen {
    JsonValue id;
    SceneEdits edits;
    bool edited = false, has_camera = false;
  };
  struct PendingSave {
    JsonValue id;
    std::future<void> done;
  };

  void process_commands() {
    while (true) {
      // After the end of input, the remaining commands are carried out even if the host does not
      // read the answers; there are only a few.
      while (!quit_ && (lines_.ended() || !lines_.congested())) {
        const std::optional<std::string> line = lines_.next_line();
        if (!line) break;
        dispatch(*line);
      }
      if (quit_) return;
      if (lines_.ended()) {
        throw InputError(
            "standard input",
            lines_.has_partial_line()
                ? "it ended in the middle of a line"
                : "it ended without \"quit\"; the host has exited or has closed the input");
      }
      send_events();
      lines_.wait(pending_saves_.empty() ? std::nullopt : std::optional(kSavePollInterval_ms));
    }
  }

  // Waits for files that are being saved, and reports their results.
  void drain_saves() {
    for (const PendingSave& pending_save : pending_saves_) pending_save.done.wait();
    send_saved();
    if (pending_open_)
      reject(*std::exchange(pending_open_, std::nullopt)->id, "cancelled: the session ends");
  }

  void dispatch(const std::string& text) {
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
      if (command.answers_immediately && !id.is_null()) answer(id);
    } catch (const EmberlineError& error) {
      reject(id, error.what(), saves);
    } catch (const std::bad_alloc&) {
      reject(id, "not enough memory for this command", saves);
    }
  }

  // ---- commands

  void open(const Json& command, const JsonReader& root, const std::string& line) {
    const std::string scene = text_of_json(command.value("scene", Json()), root["scene"]);
    const std::string edits_file =
        root.has("edits_file") ? text_of_json(command["edits_file"], root["edits_file"]) : "";
    PendingOpen pending_open{JsonValue(root.has("id") ? command["id"] : Json()), {}};
    if (root.has("edits")) {
      pending_open.edits = merge_json_edits(command["edits"], line + ", edits", {}, {});
      pending_open.edited = true;
      pending_open.has_camera = command["edits"].contains("camera");
    }
    if (pending_open_) reject(*pending_open_->id, "cancelled: another scene was opened");
    pending_open_ = std::move(pending_open);
    sent_stage_.clear();
    session_.open(scene, edits_file);
  }

  void change_settings(const Json& command, const JsonReader& root, const std::string&) {
    const JsonReader settings = root["settings"];
    HostTexts texts = texts_;
    for (const std::string& name : settings.members()) {
      const JsonReader value = settings[name];
      if (value.is_null()) {
        texts.erase(name);
      } else {
        texts[name] = text_of_json(command["settings"][name], value);
      }
    }
    HostSettings new_settings = read_settings_(texts);
    if (new_settings.display != display_) sent_serial_ = 0;  // show the newest picture again
    session_.set_settings(new_settings.view);
    texts_ = std::move(texts);
    display_ = new_settings.display;
  }

  // While a scene loads, the camera also applies to that scene.
  void change_camera(const Json& command, const JsonReader& root, const std::string& line) {
    root["camera"];
    if (!session_.scene() && !pending_open_) throw UsageError("no scene is open");
    const Json changes = {{"camera", command["camera"]}};
    const CameraEdit camera = merge_json_edits(changes, line, {}, {}).camera;
    if (session_.scene()) {
      SceneEdits edits = session_.edits();
      edits.camera = camera;
      session_.set_edits(edits);
    }
    if (!pending_open_) return;
    pending_open_->edits.camera = camera;
    pending_open_->edited = pending_open_->has_camera = true;
  }

  void change_edits(const Json& command, const JsonReader& root, const std::string& line) {
    root["edits"];
    const std::shared_ptr<const ListedScene> scene = session_.scene();
    if (!scene) throw UsageError("no scene is open");
    session_.set_edits(
        merge_json_edits(command["edits"], line + ", edits", session_.edits(), scene->outline));
  }

  void next(const Json&, const JsonReader& root, const std::string&) {
    const uint64_t after = root["after"].whole_number(0, UINT64_MAX);
    if (after > number_) throw UsageError("there is no picture {} yet", after);
    if (after == number_) host_is_ready_ = true;
  }

  void save(const Json& command, const JsonReader& root, const std::string& line) {
    const std::string file = text_of_json(command.value("file", Json()), root["file"]);
    if (pending_saves_.size() >= kMaxPendingSaves) {
      throw UsageError("{} cannot be saved yet: {} files are being saved; wait for an answer",
                       printable(file), kMaxPendingSaves);
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
    pending_saves_.push_back({JsonValue(root.has("id") ? command["id"] : Json()), std::move(done)});
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

  void reject(const Json& id, const std::string& error, bool of_save = false) {
    if (of_save && failed_saves_++ == 0) first_failure_ = error;
    send({{"id", id}, {"ok", false}, {"error", error}});
  }

  void send(const Json& message) {
    lines_.write(message.dump(-1, ' ', true, Json::error_handler_t::replace));
  }

  void send_events() {
    send_loading();
    send_saved();
    if (lines_.congested()) return;
    send_warnings();
    send_problem();
    send_picture();
  }

  void send_loading() {
    const LoadStatus status = session_.load_status();
    if (!pending_open_) return;
    using enum LoadStatus::State;
    switch (status.state) {
      case kReady:
        finish_open();
        break;
      case kFailed:
        reject(*std::exchange(pending_open_, std::nullopt)->id, status.error);
        break;
      case kCancelled:
        reject(*std::exchange(pending_open_, std::nullopt)->id, "cancelled");
        break;
      default:
        if (lines_.congested() || (status.stage == sent_stage_ &&
                                   std::abs(status.fraction - sent_fraction_) < kLoadStep)) {
          break;
        }
        sent_stage_ = status.stage;
        sent_fraction_ = status.fraction;
        send({{"event", "loading"}, {"stage", status.stage}, {"fraction", status.fraction}});
    }
  }

  void finish_open() {
    const PendingOpen pending_open = *std::exchange(pending_open_, std::nullopt);
    const std::shared_ptr<const ListedScene> scene = session_.scene();
    Json more = Json::object();
    if (pending_open.edited) {
      try {
        SceneEdits edits = merge_edits(pending_open.edits, session_.edits(), scene->outline);
        if (pending_open.has_camera) edits.camera = pending_open.edits.camera;
        session_.set_edits(edits);
      } catch (const EmberlineError& error) {
        more["problem"] = error.what();
      }
    }
    min_edit_ = session_.edit();
    more["scene"] = protocol_json(*scene, session_.edits());
    answer(*pending_open.id, std::move(more));
  }

  void send_warnings() {
    std::vector<std::string> warnings;
    {
      const std::lock_guard lock(warnings_mutex_);
      warnings.swap(warnings_);
    }
    for (const std::string& text : warnings) send({{"event", "warning"}, {"text", text}});
  }

  void send_problem() {
    const std::string problem = session_.problem().empty() ? frame_problem_ : session_.problem();
    if (problem == sent_problem_) return;
    sent_problem_ = problem;
    send({{"event", "problem"}, {"text", problem}});
  }

  void send_saved() {
    using std::chrono::seconds;
    for (auto pending_save = pending_saves_.begin(); pending_save != pending_saves_.end();) {
      if (pending_save->done.wait_for(seconds(0)) != std::future_status::ready) {
        ++pending_save;
        continue;
      }
      try {
        pending_save->done.get();
        answer(*pending_save->id);
      } catch (const std::exception& error) {
        reject(*pending_save->id, error.what(), true);
      }
      pending_save = pending_saves_.erase(pending_save);
    }
  }

  void send_picture() {
    const std::shared_ptr<const SessionPicture> picture = session_.picture();
    if (!host_is_ready_ || !picture || picture->serial == sent_serial_ ||
        picture->edit < min_edit_) {
      return;
    }
    sent_serial_ = picture->serial;
    // Overlays have no linear values.
    const bool display = display_ || !picture->overlay_legend.empty();
    const std::span<const std::byte> bytes = display ? std::as_bytes(std::span(picture->rgba8))
                                                     : std::as_bytes(std::span(picture->linear()));
    SharedFrames::Location place;
    try {
      place = frames_.write(bytes, session_.memory(), "a picture in shared memory");
      frame_problem_.clear();
    } catch (const EmberlineError& error) {
      frame_problem_ = error.what();
      send_problem();
      return;
    }
    host_is_ready_ = false;
    Json event = protocol_json(*picture);
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
  std::optional<PendingOpen> pending_open_;
  std::list<PendingSave> pending_saves_;
  uint64_t failed_saves_ = 0;
  std::string first_failure_;
  std::string sent_stage_, sent_problem_, frame_problem_;
  double sent_fraction_ = 0.0;

  SharedFrames frames_;
  uint64_t min_edit_ = 0;      // pictures of earlier edits show the previous scene
  uint64_t sent_serial_ = 0;   // SessionPicture::serial of the picture sent last
  uint64_t number_ = 0;        // number of the last picture event
  bool host_is_ready_ = true;  // the host has consumed the previous picture
};

}  // namespace

void run_session_host(std::function<HostSettings(const HostTexts&)> settings, int in, int out) {
  SessionHost(std::move(settings), in, out).run();
}

}  // namespace emberline
