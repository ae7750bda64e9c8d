// Changes how the scene is rendered and shown. RenderSession::settings() returns the settings, and
// RenderSession::problem() says what is wrong with them. Used on the window's thread only; nothing
// here blocks.
#pragma once

#include "renderer/session/render_session.h"
#include "renderer/window/input/edit_latency.h"
#include "renderer/window/input/journal.h"

namespace emberline {

class SettingsEditor {
 public:
  // All arguments must outlive this object.
  SettingsEditor(RenderSession& session, EditLatency& latency, Journal& journal);

  void change(const ViewSettings& settings);
  // Calls change_it(settings) with a copy of the current settings.
  void change_with(const auto& change_it) {
    ViewSettings settings = session_.settings();
    change_it(settings);
    change(settings);
  }

 private:
  RenderSession& session_;
  EditLatency& latency_;
  Journal& journal_;
};

}  // namespace emberline
