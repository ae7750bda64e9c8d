#include "renderer/window/panels/theme.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "io/files/input_file.h"

namespace emberline {
namespace {

constexpr float kFontSize = 15.0f;  // pixels, at scale 1

constexpr float kFixedSize = 0.9f;  // relative to kFontSize, for the monospaced font

// Folders where Debian, Fedora, Arch and openSUSE install DejaVu. Unlike ImGui's own font, DejaVu
// Sans covers most scripts used in scene names.
constexpr std::array kFontFolders = {
    "/usr/share/fonts/truetype/dejavu",
    "/usr/share/fonts/dejavu-sans-fonts",
    "/usr/share/fonts/dejavu-sans-mono-fonts",
    "/usr/share/fonts/TTF",
    "/usr/share/fonts/truetype",
};

// Latin with extensions, Greek, Cyrillic, punctuation, super- and subscripts, arrows, and the
// mathematical and geometric symbols of the panels. Each pair is the first and the last character
// of a range; 0 ends the list.
constexpr std::array<ImWchar, 17> kGlyphRanges = {0x0020, 0x024F, 0x0370, 0x03FF, 0x0400, 0x04FF,
                                                  0x2010, 0x2044, 0x2070, 0x209F, 0x2190, 0x2193,
                                                  0x2200, 0x226F, 0x25A0, 0x25FF, 0};

// Adds the named font or, as a fallback, ImGui's monospaced font.
void add_font(const char* name, float pixels, const ImWchar* glyph_ranges) {
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  for (const char* folder : kFontFolders) {
    const auto file = InputFile::try_open(std::filesystem::path(folder) / name);
    if (!file) continue;
    const std::vector<uint8_t> bytes = file->read_all();
    void* const owned_by_imgui = ImGui::MemAlloc(bytes.size());
    std::ranges::copy(bytes, static_cast<uint8_t*>(owned_by_imgui));
    ImFontConfig config;
    config.OversampleH = 2;
    config.OversampleV = 1;
    fonts.AddFontFromMemoryTTF(owned_by_imgui, int(bytes.size()), pixels, &config, glyph_ranges);
    return;
  }
  ImFontConfig config;  // ImGui's font is 13 pixels high, and is sharp only at multiples of 13
  config.SizePixels = 13.0f * std::max(1.0f, std::round(pixels / 13.0f));
  fonts.AddFontDefault(&config);
}

void load_fonts(float pixels, float pixels_per_unit) {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  io.FontGlobalScale = 1.0f / pixels_per_unit;
  add_font("DejaVuSans.ttf", pixels, kGlyphRanges.data());
  add_font("DejaVuSansMono.ttf", std::round(kFixedSize * pixels), nullptr);
}

ImVec4 grey(float level, float alpha = 1.0f) { return {level, level, level * 1.02f, alpha}; }

void set_colours(ImGuiStyle& style) {
  ImGui::StyleColorsDark(&style);
  const ImVec4 accent = accent_colour();
  const auto tinted = [&](float alpha) { return ImVec4(accent.x, accent.y, accent.z, alpha); };
  ImVec4* const colours = style.Colors;
  colours[ImGuiCol_Text] = grey(0.88f);
  colours[ImGuiCol_TextDisabled] = grey(0.56f);
  colours[ImGuiCol_WindowBg] = grey(0.135f);
  colours[ImGuiCol_ChildBg] = grey(0.135f, 0.0f);
  colours[ImGuiCol_PopupBg] = grey(0.16f, 0.98f);
  colours[ImGuiCol_Border] = grey(0.25f);
  colours[ImGuiCol_FrameBg] = grey(0.21f);
  colours[ImGuiCol_FrameBgHovered] = grey(0.27f);
  colours[ImGuiCol_FrameBgActive] = grey(0.31f);
  colours[ImGuiCol_TitleBg] = grey(0.11f);
  colours[ImGuiCol_TitleBgActive] = grey(0.17f);
  colours[ImGuiCol_MenuBarBg] = grey(0.11f);
  colours[ImGuiCol_ScrollbarBg] = grey(0.12f, 0.0f);
  colours[ImGuiCol_ScrollbarGrab] = grey(0.32f);
  colours[ImGuiCol_CheckMark] = accent;
  colours[ImGuiCol_SliderGrab] = tinted(0.85f);
  colours[ImGuiCol_SliderGrabActive] = accent;
  colours[ImGuiCol_Button] = grey(0.25f);
  colours[ImGuiCol_ButtonHovered] = grey(0.32f);
  colours[ImGuiCol_ButtonActive] = tinted(0.6f);
  colours[ImGuiCol_Header] = tinted(0.3f);  // the selected row
  colours[ImGuiCol_HeaderHovered] = grey(0.28f);
  colours[ImGuiCol_HeaderActive] = tinted(0.5f);
  colours[ImGuiCol_Separator] = grey(0.25f);
  colours[ImGuiCol_ResizeGrip] = grey(0.3f, 0.3f);
  colours[ImGuiCol_Tab] = grey(0.17f);
  colours[ImGuiCol_TabHovered] = grey(0.34f);
  colours[ImGuiCol_TabActive] = grey(0.28f);
  colours[ImGuiCol_TabUnfocused] = colours[ImGuiCol_Tab];
  colours[ImGuiCol_TabUnfocusedActive] = colours[ImGuiCol_TabActive];
  colours[ImGuiCol_PlotHistogram] = tinted(0.9f);
  colours[ImGuiCol_TextSelectedBg] = tinted(0.4f);
  colours[ImGuiCol_ModalWindowDimBg] = ImVec4(0, 0, 0, 0.45f);
}

}  // namespace

ImVec4 accent_colour() { return {0.90f, 0.62f, 0.20f, 1.0f}; }
ImVec4 warning_colour() { return {0.94f, 0.89f, 0.36f, 1.0f}; }
ImVec4 error_colour() { return {1.0f, 0.52f, 0.38f, 1.0f}; }
ImVec4 muted_colour() { return grey(0.60f); }

int fixed_panel_flags() {
  return ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
         ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus;
}

ImFont* fixed_font() { return ImGui::GetIO().Fonts->Fonts.back(); }

void apply_theme(float scale, float pixels_per_unit) {
  ImGuiStyle style;
  set_colours(style);
  style.WindowRounding = 4.0f;
  style.FrameRounding = 3.0f;
  style.PopupRounding = 4.0f;
  style.GrabRounding = 3.0f;
  style.TabRounding = 3.0f;
  style.ScrollbarRounding = 6.0f;
  style.WindowPadding = {10.0f, 8.0f};
  style.FramePadding = {7.0f, 4.0f};
  style.ItemSpacing = {8.0f, 6.0f};
  style.ItemInnerSpacing = {6.0f, 4.0f};
  style.GrabMinSize = 10.0f;
  style.WindowBorderSize = 0.0f;
  style.PopupBorderSize = 1.0f;
  style.ScaleAllSizes(scale);
  ImGui::GetStyle() = style;
  load_fonts(std::round(kFontSize * scale * pixels_per_unit), pixels_per_unit);
}

}  // namespace emberline
