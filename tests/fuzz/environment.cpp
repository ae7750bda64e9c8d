// Fuzzes an environment map (--env, and "file" in edits).
#include "fuzz/fuzz.h"
#include "io/image/input.h"
#include "support/scene_validation.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = fuzz::write_input(data, size, "environment");
  fuzz::allow_errors([&] {
    uint64_t repaired = 0;
    const LoadProgress progress({}, {}, fuzz::small_limits(path));
    const auto image = read_environment(path, &repaired, progress);
    fuzz::require_none(image->channels == 3 ? test::find_scene_violation(*image) : "channels");
  });
  return 0;
}
