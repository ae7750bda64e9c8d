#include "renderer/window/workbench/settings_editor.h"

#include <nlohmann/json.hpp>

#include "renderer/session/overlay_picture.h"
#include "renderer/window/workbench/clock.h"

namespace emberline {

SettingsEditor::SettingsEditor(RenderSession& session, EditLatency& latency, Journal& journal)
    : session_(session), latency_(latency), journal_(journal) {}

void SettingsEditor::change(const ViewSettings& settings) {
  session_.set_settings(settings);
  latency_.asked(session_.edit(), "settings", window_time_s());
  nlohmann::json region;
  if (const std::optional<Rect>& r = settings.region) region = {r->x0, r->y0, r->x1, r->y1};
  journal_.write("settings", {{"edit", session_.edit()},
                              {"driver", settings.render.driver},
                              {"overlay", int(settings.overlay)},
                              {"denoise", settings.denoise},
                              {"paused", settings.paused},
                              {"region", region}});
}

template <class Change>
void SettingsEditor::change_with(Change change_it) {
  ViewSettings settings = session_.settings();
  change_it(settings);
  change(settings);
}

void SettingsEditor::toggle_pause() {
  change_with([](ViewSettings& s) { s.paused = !s.paused; });
}

void SettingsEditor::restart() {
  change_with([](ViewSettings& s) { s.render.seed += 1; });
}

void SettingsEditor::add_exposure(float stops) {
  change_with([&](ViewSettings& s) { s.display.exposure += stops; });
}

void SettingsEditor::next_overlay() {
  change_with([](ViewSettings& s) {
    s.overlay = ViewOverlay((size_t(s.overlay) + 1) % overlay_table().size());
  });
}

void SettingsEditor::set_denoise(bool on) {
  change_with([&](ViewSettings& s) { s.denoise = on; });
}

void SettingsEditor::set_raw_beside(bool on) {
  change_with([&](ViewSettings& s) { s.raw_beside = on; });
}

void SettingsEditor::set_region(const std::optional<Rect>& region) {
  change_with([&](ViewSettings& s) { s.region = region; });
}

}  // namespace emberline
