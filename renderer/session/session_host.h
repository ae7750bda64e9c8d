// `emberline session`: a RenderSession for another process, the host, which speaks JSON lines and
// looks at shared memory. PROTOCOL.md is what both sides agree on.
//
// One thread owns the session, carries out the host's commands, and sends events between them. An
// event describes the state of its moment and is sent only while the host reads, so a host that
// lags gets fewer, and nothing piles up.
#pragma once

#include <functional>
#include <future>
#include <list>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io/json/value.h"
#include "renderer/session/line_stream.h"
#include "renderer/session/render_session.h"
#include "renderer/session/shared_frames.h"

namespace emberline {

inline constexpr int kSessionProtocol = 1;

struct HostSettings {
  ViewSettings view;
  bool display = false;  // pictures are as displayed, and not linear
};

// By the name of an option, what it would be given; a switch has "yes" or "no".
using HostTexts = std::map<std::string, std::string>;

class SessionHost {
 public:
  // `settings` makes settings of what the host has said beside the command line, and throws
  // UsageError.
  SessionHost(std::function<HostSettings(const HostTexts&)> settings, int in, int out);
  ~SessionHost();
  SessionHost(const SessionHost&) = delete;
  SessionHost& operator=(const SessionHost&) = delete;

  // Until the host says "quit". Throws InputError for one that is gone or makes no sense,
  // RenderError for one that does not listen, and at the end if a file could not be saved.
  void run();

 private:
  using Json = nlohmann::json;
  struct Command;
  // One that is answered later.
  struct Opening {
    JsonValue id;
    SceneEdits edits;
    bool edited = false, has_camera = false;
  };
  struct Saving {
    JsonValue id;
    std::future<void> done;
  };

  void serve();
  void settle();
  void obey(const std::string& line);
  void open(const Json& command, const std::string& line);
  void change_settings(const Json& command, const std::string& line);
  void change_camera(const Json& command, const std::string& line);
  void change_edits(const Json& command, const std::string& line);
  void next(const Json& command, const std::string& line);
  void save(const Json& command, const std::string& line);
  void cancel(const Json& command, const std::string& line);
  void quit(const Json& command, const std::string& line);

  void answer(const Json& id);
  void answer(const Json& id, Json more);
  void refuse(const Json& id, const std::string& error, bool of_save = false);
  void send(const Json& message);

  void tell();
  void tell_loading();
  void finish_opening();
  void tell_warnings();
  void tell_problem();
  void tell_saved();
  void show_picture();

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
  uint64_t least_edit_ = 0;    // pictures of before are of another scene
  uint64_t shown_serial_ = 0;  // of the session's pictures
  uint64_t number_ = 0;        // of ours
  bool awaited_ = true;        // the host has the one before
};

}  // namespace emberline
