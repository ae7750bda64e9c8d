// Fuzzes a frame, which is read as `compare`, `heatmap` and --reference read it.
#include "fuzz/fuzz.h"
#include "io/image/input.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string path = fuzz::write_input(data, size, "frame");
  fuzz::allow_errors([&] {
    const LoadProgress progress({}, {}, fuzz::small_limits(path));
    const FloatImage image = read_float_image(path, progress);
    const size_t pixels = size_t(image.width) * size_t(image.height);
    fuzz::require_none(image.values.size() == pixels * size_t(image.channels()) ? "" : "size");
  });
  return 0;
}
