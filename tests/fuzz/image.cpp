// Fuzzes a texture, embedded or external: PNG, JPEG, WebP, EXR, HDR, KTX 2.
#include "io/image/input.h"

#include "fuzz/fuzz.h"
#include "support/scene_validation.h"

using namespace emberline;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  fuzz::allow_errors([&] {
    const LoadProgress progress({}, {}, fuzz::small_limits("image"));
    const auto image = decode_image({data, size}, "image", size % 2 == 1, progress).image;
    fuzz::require_none(test::find_scene_violation(*image));
  });
  return 0;
}
