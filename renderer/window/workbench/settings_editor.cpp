#include "renderer/window/workbench/settings_editor.h"

#include <nlohmann/json.hpp>

#include "renderer/window/workbench/clock.h"

namespace emberline {

SettingsEditor::SettingsEditor(RenderSession& session, EditLatency& latency, Journal& journal)
    : session_(session), latency_(latency), journal_(journal) {}

void SettingsEditor::change(const ViewSettings& settings) {
  session_.set_settings(settings);
  latency_.add_edit(session_.edit(), "settings", window_time_s());
  nlohmann::json region;
  if (const std::optional<Rect>& r = settings.region) region = {r->x0, r->y0, r->x1, r->y1};
  journal_.write("settings", {{"edit", session_.edit()},
                              {"driver", settings.render.driver},
                              {"overlay", int(settings.overlay)},
                              {"denoise", settings.denoise},
                              {"paused", settings.paused},
                              {"region", region}});
}

}  // namespace emberline
