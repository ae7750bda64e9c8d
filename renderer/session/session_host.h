// `emberline session`: a RenderSession for another process, the host, which speaks JSON lines and
// looks at shared memory. PROTOCOL.md is what both sides agree on.
//
// One thread owns the session, carries out the host's commands, and sends events between them. An
// event describes the state of its moment and is sent only while the host reads, so a host that
// lags gets fewer, and nothing piles up.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "renderer/session/view_settings.h"

namespace emberline {

struct HostSettings {
  ViewSettings view;
  bool display = false;  // pictures are as displayed, and not linear
};

// By the name of an option, what it would be given; a switch has "yes" or "no".
using HostTexts = std::map<std::string, std::string>;

// Until the host says "quit". `settings` makes settings of what the host has said beside the
// command line, and throws UsageError. Throws InputError for a host that is gone or makes no sense,
// RenderError for one that does not listen, and at the end if a file could not be saved.
void run_session_host(std::function<HostSettings(const HostTexts&)> settings, int in, int out);

}  // namespace emberline
