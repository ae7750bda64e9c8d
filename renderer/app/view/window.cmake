# The window, where its libraries are; elsewhere a sentence that says which are missing.
option(EMBERLINE_WINDOW "Build `emberline view`, if GLFW and Dear ImGui are found" ON)

# What of it needs neither.
target_sources(emberline_view PRIVATE
  edit_entries.cpp edit_latency.cpp histogram.cpp picture_placement.cpp window_state.cpp)
target_link_libraries(emberline_view PRIVATE nlohmann_json::nlohmann_json)

if(EMBERLINE_WINDOW)
  find_package(glfw3 3.3 QUIET)
  find_package(OpenGL QUIET)
  # Debian's package has the back ends compiled in, and no CMake file.
  find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
  find_library(IMGUI_LIBRARY imgui)
  find_library(STB_LIBRARY stb)  # which Debian has taken out of ImGui
  mark_as_advanced(IMGUI_INCLUDE_DIR IMGUI_LIBRARY STB_LIBRARY)
endif()

set(window_missing "")
if(NOT EMBERLINE_WINDOW)
  set(window_missing "EMBERLINE_WINDOW is OFF")
elseif(NOT glfw3_FOUND)
  set(window_missing "GLFW 3.3 (libglfw3-dev) was not found")
elseif(NOT OpenGL_OpenGL_FOUND AND NOT OPENGL_FOUND)
  set(window_missing "OpenGL (libgl-dev) was not found")
elseif(NOT IMGUI_INCLUDE_DIR OR NOT IMGUI_LIBRARY OR
       NOT EXISTS "${IMGUI_INCLUDE_DIR}/backends/imgui_impl_opengl3.h")
  set(window_missing "Dear ImGui with its back ends (libimgui-dev) was not found")
endif()

if(window_missing)
  message(STATUS "emberline view is left out: ${window_missing}")
  set(EMBERLINE_HAS_WINDOW OFF CACHE INTERNAL "")
  emberline_library(emberline_window SOURCES no_window.cpp LINK emberline_core)
  return()
endif()

set(EMBERLINE_HAS_WINDOW ON CACHE INTERNAL "")
emberline_library(emberline_window
  SOURCES
    file_dialog.cpp
    input.cpp
    journal.cpp
    measurement.cpp
    panels.cpp
    panels_picture.cpp
    panels_scene.cpp
    picture_input.cpp
    picture_texture.cpp
    picture_view.cpp
    theme.cpp
    view_command.cpp
    widgets.cpp
    window.cpp
    workbench.cpp
  LINK emberline_view
  PRIVATE_LINK glfw OpenGL::GL ${IMGUI_LIBRARY} ${CMAKE_DL_LIBS} fmt::fmt nlohmann_json::nlohmann_json)
target_include_directories(emberline_window SYSTEM PRIVATE ${IMGUI_INCLUDE_DIR})
if(STB_LIBRARY)
  target_link_libraries(emberline_window PRIVATE ${STB_LIBRARY})
endif()
