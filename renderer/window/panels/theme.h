// Dear ImGui's appearance: readable fonts, one accent colour, and otherwise dark neutral grey, so
// that nothing distracts from the picture's colours.
#pragma once

struct ImFont;
struct ImVec4;

namespace emberline {

// Sets style and fonts. The interface is `scale` times as large as on a 96-dpi screen; the frame
// buffer has `pixels_per_unit` pixels per window unit. Call after ImGui::CreateContext and before
// the first frame. May be called again between frames; ImGui's back end must then rebuild its font
// texture.
void apply_theme(float scale, float pixels_per_unit);

// Signal colours that colour-blind readers can distinguish. They are from Okabe & Ito 2008, "Color
// Universal Design", and lightened for a dark background.
ImVec4 accent_colour();
ImVec4 warning_colour();
ImVec4 error_colour();
ImVec4 muted_colour();  // less important text

// Returns the ImGuiWindowFlags of a panel that cannot move and stays behind all floating windows.
int fixed_panel_flags();

// Returns a monospaced font for tables, with Latin letters only.
ImFont* fixed_font();

}  // namespace emberline
