// How the picture is rendered and shown. The settings themselves are RenderSession::settings(), and
// RenderSession::problem() says where they make no sense. The window's thread only; nothing here
// blocks it.
#pragma once

#include "renderer/session/render_session.h"
#include "renderer/window/input/edit_latency.h"
#include "renderer/window/input/journal.h"

namespace emberline {

class SettingsEditor {
 public:
  // All of these must outlive this.
  SettingsEditor(RenderSession& session, EditLatency& latency, Journal& journal);

  void change(const ViewSettings& settings);

  void toggle_pause();
  void restart();  // with the next seed
  void add_exposure(float stops);
  void next_overlay();
  void set_denoise(bool on);
  void set_raw_beside(bool on);
  void set_region(const std::optional<Rect>& region);

 private:
  template <class Change>
  void change_with(Change change_it);

  RenderSession& session_;
  EditLatency& latency_;
  Journal& journal_;
};

}  // namespace emberline
