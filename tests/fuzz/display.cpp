// Fuzzes the names for --display, --view and --look, and the config in $OCIO. The input has four
// lines (display, view, look and exposure), followed by the config. Without a config, the built-in
// one is used.
#include "io/display/display.h"

#include <cstdlib>
#include <sstream>

#include "fuzz/fuzz.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::istringstream text(std::string(reinterpret_cast<const char*>(data), size));
  DisplaySettings settings;
  std::string exposure;
  std::getline(text, settings.display);
  std::getline(text, settings.view);
  std::getline(text, settings.look);
  std::getline(text, exposure);
  settings.exposure = std::strtof(exposure.c_str(), nullptr);
  const std::string config(std::istreambuf_iterator<char>(text), {});
  if (config.empty()) {
    unsetenv("OCIO");
  } else {
    const std::string path = fuzz::write_input(reinterpret_cast<const uint8_t*>(config.data()),
                                               config.size(), "config.ocio");
    setenv("OCIO", path.c_str(), 1);
  }
  fuzz::allow_errors([] { display_names(); });
  fuzz::allow_errors([&] {
    float rgb[] = {0.0f, 0.18f, 1e30f};
    DisplayTransform(settings).apply(rgb, 1);
  });
  return 0;
}
