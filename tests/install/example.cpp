// Renders a scene with one of its lights at half strength: example SCENE MATERIAL
#include <emberline/emberline.h>

#include <cstdio>
#include <string>

int main(int argc, char** argv) {
  namespace em = emberline::api;
  if (argc != 3) return std::fprintf(stderr, "usage: example SCENE MATERIAL\n"), 2;
  try {
    em::Settings settings;
    settings.set("driver", "adaptive").set("size", "96x64").set("spp", "16");
    em::Scene scene(argv[1], settings);
    scene.edit(R"({"emberline_edits": 1, "lights": [{"kind": "material", "name": ")" +
               std::string(argv[2]) + R"(", "intensity": 0.5}]})");
    const em::Picture picture = em::render(scene, settings, {}, {}, [](const em::Progress& now) {
      std::fprintf(stderr, "%llu samples\n", static_cast<unsigned long long>(now.samples));
    });
    double sum = 0;
    for (int y = 0; y < picture.height; ++y) {
      for (int x = 0; x < picture.width; ++x) sum += picture.pixel(x, y)[1];  // green
    }
    std::printf("%s: mean %.9g, error %.9g, %s\n", em::version().c_str(),
                sum / (picture.width * picture.height), picture.error_estimate.value_or(-1),
                picture.complete ? "complete" : "stopped");
  } catch (const em::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
