// Dear ImGui's appearance: dark neutral grey, so that only the picture is coloured, one accent
// colour, and readable fonts.
#pragma once

struct ImFont;
struct ImVec4;

namespace emberline {

// Sets style and fonts for an interface `scale` times the size for a 96-dpi screen, on a frame
// buffer with `pixels_per_unit` pixels per window unit. Call after ImGui::CreateContext and before
// the first frame; it may be repeated between frames, after which the renderer must rebuild its
// font texture.
void apply_theme(float scale, float pixels_per_unit);

// Signal colours from Okabe & Ito 2008, "Color Universal Design", lightened for a dark background;
// distinguishable by colour-blind readers.
ImVec4 accent_colour();
ImVec4 warning_colour();
ImVec4 error_colour();
ImVec4 muted_colour();  // less important text

// ImGuiWindowFlags of a panel that is fixed below all floating windows.
int fixed_panel_flags();

// A monospaced font for tables, with Latin letters only.
ImFont* fixed_font();

}  // namespace emberline
