// Renders a frame with the library and writes it to a file:
//   library_frame SCENE FILE.exr [NAME=TEXT ...]
#include <cstdio>
#include <string>

#include "renderer/api/emberline.h"

int main(int argc, char** argv) {
  namespace em = emberline::api;
  if (argc < 3) return 2;
  try {
    em::Settings settings;
    for (int i = 3; i < argc; ++i) {
      const std::string argument = argv[i];
      const size_t equals = argument.find('=');
      settings.set(argument.substr(0, equals), argument.substr(equals + 1));
    }
    const em::Scene scene(argv[1], settings);
    em::write_picture(argv[2], em::render(em::RenderFiles::none(), scene, settings));
  } catch (const em::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
