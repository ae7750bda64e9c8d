// `emberline session`: offers a RenderSession to another process, the host, through lines of JSON
// and shared memory. PROTOCOL.md defines the protocol.
//
// One thread owns the session, executes the host's commands and sends events in between. An event
// describes the current state and is sent only while the host is reading. So a slow host gets fewer
// events, and events never pile up.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "renderer/session/view_settings.h"

namespace emberline {

struct HostSettings {
  ViewSettings view;
  bool display = false;  // send display values instead of linear ones
};

// The options' values as texts, by option name; a flag has the text "yes" or "no".
using HostTexts = std::map<std::string, std::string>;

// Runs until the host sends "quit". `settings` applies the host's option values on top of the
// command line, and may throw UsageError. Throws InputError if the host ends or violates the
// protocol. Throws RenderError if the host has closed the output or, at the end, if a file could
// not be saved.
void run_session_host(std::function<HostSettings(const HostTexts&)> settings, int in, int out);

}  // namespace emberline
