// Invalid texels: NaN, infinity, 1e30, and negative values.
#include <cstring>

#include "closed_form.h"
#include "io/image/input.h"
#include "support/encoded_images.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kSize = 8;

// Makes a mid-grey image. The first five texels of row 3 are bad, or black if `bad` is false.
std::shared_ptr<Image> float_image(bool bad) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<float> texels(kSize * kSize * 3, 0.5f);
  const float values[] = {nan, inf, -inf, 1e30f, -1.0f};
  for (size_t i = 0; i < std::size(values); ++i) {
    for (size_t c = 0; c < 3; ++c) texels[(3 * kSize + i) * 3 + c] = bad ? values[i] : 0.0f;
  }
  auto image = std::make_shared<Image>();
  image->width = image->height = kSize;
  image->channels = 3;
  image->type = TexelType::kFloat;
  image->texels.resize(texels.size() * sizeof(float));
  std::memcpy(image->texels.data(), texels.data(), image->texels.size());
  return image;
}

bool in_bad_texel(int x, int y) { return y == 3 && x < 5; }

// Renders a square that fills the frame, with one texel per pixel. Its material has the texture in
// `slot`. A flat square does not light itself, so a pixel depends only on its own texel.
RenderedImage picture(const char* slot, bool bad) {
  SceneBuilderForTests b;
  b.description.images.push_back(float_image(bad));
  MaterialDescription m;
  m.metallic = 0.5f;
  m.roughness = 0.5f;
  TextureRef* ref = &m.base_color_texture;
  if (std::string(slot) == "emission") {
    ref = &m.emission_texture;
    m.emission = Rgb(1.0f);
  }
  if (std::string(slot) == "metal and roughness") ref = &m.metallic_roughness_texture;
  if (std::string(slot) == "normal") ref = &m.normal_texture;
  if (std::string(slot) == "specular") ref = &m.specular_color_texture;
  if (std::string(slot) == "transmission") {
    ref = &m.transmission_texture;
    m.transmission = 1.0f;
  }
  ref->image = 0;
  ref->nearest = true;
  b.add_quad({-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}, b.add_material(m));
  b.set_environment(Rgb(1.0f));
  RenderSettings s;
  s.width = s.height = kSize;
  s.spp = 64;
  s.max_depth = 3;
  // As emission, the texel of 1e30 is a lamp and rightly changes how lights are selected for all
  // pixels. So that slot is rendered without light samples.
  s.light_samples = std::string(slot) != "emission" ? 1 : 0;
  return render(*b.build(), orthographic({0, 0, 5}, {0, 0, 0}, 4), s);
}

// Case 21: a non-finite value counts as 0 and affects no other pixel. Values of 1e30 and -1 are
// clamped to the slot's range. A finite emission is used unchanged.
TEST(BadTexels, StayWhereTheyAre) {
  for (const char* slot :
       {"base colour", "emission", "metal and roughness", "normal", "specular", "transmission"}) {
    const RenderedImage good = picture(slot, false), bad = picture(slot, true);
    double changed = 0, not_finite = double(bad.counters.non_finite_samples);
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        for (int c = 0; c < 3; ++c) not_finite += !std::isfinite(bad.pixel(x, y)[c]);
        // Skips the bad row for both possible directions of v.
        if (in_bad_texel(x, kSize - 1 - y) || in_bad_texel(x, y)) continue;
        changed += bad.rgb(x, y) != good.rgb(x, y);
      }
    }
    const std::string replay = "8 x 8, 64 spp, seed 1";
    expect_case({"21", std::string("non-finite values from bad texels, ") + slot},
                {0, not_finite, 0, 0}, replay);
    expect_case({"21", std::string("other pixels changed by bad texels, ") + slot},
                {0, changed, 0, 0}, replay);
  }
}

// Reads environment maps from files whose components are 1, except for six. In one file the six
// are NaN, infinite or negative. They become 0 and are counted, and the picture equals that of the
// other file, in which the six are 0.
TEST(BadTexels, InAnEnvironmentAreCountedAndBlack) {
  const TempFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const auto map = [&](std::initializer_list<float> values, uint64_t* repaired) {
    std::vector<float> texels(16 * 8 * 3, 1.0f);
    std::copy(values.begin(), values.end(), texels.begin() + 16 * 2 * 3);
    write_image<float>(folder / "sky.exr", OIIO::ImageSpec(16, 8, 3, OIIO::TypeDesc::FLOAT),
                       texels);
    return read_environment(folder / "sky.exr", repaired);
  };
  uint64_t repaired = 0, none = 0;
  const auto bad = map({nan, inf, -inf, -1.0f, -1e30f, nan}, &repaired);
  const auto zero = map({0, 0, 0, 0, 0, 0}, &none);
  expect_case({"21", "bad texels of a sky, counted"}, {6, double(repaired), 0, 0}, "sky.exr");
  EXPECT_EQ(none, 0u);
  RenderSettings s;
  s.max_depth = 2;
  const auto picture = [&](const std::shared_ptr<const Image>& sky) {
    SceneBuilderForTests b;
    b.add_floor(5, 0, b.add_material(lambert(Rgb(.7f))));
    b.set_environment(sky);
    return render(*b.build(), perspective({0, 2, 5}, {0, 1, 0}, 90), s);
  };
  const RenderedImage a = picture(bad), b = picture(zero);
  double changed = 0;
  for (size_t i = 0; i < a.values.size(); ++i) changed += a.values[i] != b.values[i];
  expect_case({"21", "values changed by bad texels of a sky, against black ones"},
              {0, changed, 0, 0}, replay(s));
}

}  // namespace
}  // namespace emberline
