// Dear ImGui's looks: a dark, neutral grey that leaves the picture the only colour in sight, one
// accent, and letters that can be read.
#pragma once

struct ImFont;
struct ImVec4;

namespace emberline {

// Style and fonts for an interface `scale` times the size that fits a screen of 96 dots an inch, on
// a frame buffer with `pixels_per_unit` pixels for each of the window system's units. Call after
// ImGui::CreateContext and before the first frame; may be called again between frames, the renderer
// must then make its font texture anew.
void apply_theme(float scale, float pixels_per_unit);

// Colours that say something. Okabe & Ito 2008, "Color Universal Design", lightened for a dark
// ground: told apart by colour-blind readers.
ImVec4 accent_colour();
ImVec4 warning_colour();
ImVec4 error_colour();
ImVec4 quiet_colour();  // what matters less than the rest

// ImGuiWindowFlags of a panel that stays where it is, under everything that floats.
int fixed_panel_flags();

// A font of fixed width for tables in text, with Latin letters only.
ImFont* fixed_font();

}  // namespace emberline
