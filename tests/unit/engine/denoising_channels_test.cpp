// Tests the channels for a denoiser: sample halves, and features, also as seen in mirrors and
// through glass.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "renderer/core/errors.h"
#include "renderer/film/film.h"
#include "renderer/film/half_channels.h"
#include "renderer/film/shared_samples.h"
#include "support/busy_scene.h"
#include "support/glass_scenes.h"
#include "support/render.h"

namespace emberline::test {
namespace {

AovSet denoising() { return AovSet::parse("denoising"); }

SampleValue grey(float value) { return {Rgb(value), 1.0f, {}, {}}; }

FilmTile film_of(int width, int groups = -1) {
  FilmTile film(denoising(), {.light_groups = groups});
  film.reset({0, 0, width, 1});
  return film;
}

// Returns the value of a channel in one pixel of a film.
float value_of(const FilmTile& film, size_t pixel, const std::string& name) {
  const std::vector<std::string> names = film_channel_names(film.aovs());
  const auto at = std::ranges::find(names, name);
  EXPECT_NE(at, names.end()) << name;
  std::vector<float> values;
  film.resolve(values);
  return values[pixel * names.size() + size_t(at - names.begin())];
}

TEST(HalfChannels, AreMeansOfEachHalf) {
  FilmTile film = film_of(2);
  const DenoiserFeatures near = {Rgb(0.5f, 0.25f, 1.0f), Vec3f(0, 1, 0), 2.0f, 1.0f};
  const DenoiserFeatures far = {Rgb(0.0f), Vec3f(0, 0, 1), 0.0f, 0.0f};
  const SampleShares left = {0.0f, 0.0f, 0.0f, 0.25f}, all = {0.0f, 0.0f, 0.0f, 1.0f};
  EXPECT_TRUE(film.add(1, 0, {grey(1), 1.0f, 0, &near, &left}));
  EXPECT_TRUE(film.add(1, 0, {grey(2), 1.0f, 0, &far, &all}));
  EXPECT_EQ(value_of(film, 1, "half1.shared.3.G"), 1.125f);
  EXPECT_EQ(value_of(film, 1, "half1.shared.3.A"), 0.625f);
  EXPECT_EQ(value_of(film, 1, "half1.shared.4.A"), 0.0f);
  EXPECT_EQ(value_of(film, 1, "half2.shared.3.A"), 0.0f);
  EXPECT_TRUE(film.add(1, 0, {grey(6), 1.0f, 1, &near}));
  EXPECT_EQ(value_of(film, 1, "half1.R"), 1.5f);
  EXPECT_EQ(value_of(film, 1, "half1.samples"), 2.0f);
  EXPECT_EQ(value_of(film, 1, "half1.albedo.G"), 0.125f);
  EXPECT_EQ(value_of(film, 1, "half1.N.Z"), 0.5f);
  EXPECT_EQ(value_of(film, 1, "half1.nearness"), 1.0f);
  EXPECT_EQ(value_of(film, 1, "half1.visibility"), 0.5f);
  EXPECT_EQ(value_of(film, 1, "half2.G"), 6.0f);
  EXPECT_EQ(value_of(film, 1, "half2.visibility"), 1.0f);
  EXPECT_EQ(value_of(film, 1, "half2.samples"), 1.0f);
  for (const PictureChannel& channel : half_channels()) {
    EXPECT_EQ(value_of(film, 0, channel.name), 0.0f) << channel.name;
  }
}

// A pixel's mean may be replaced, for example by an average over rounds. Then both halves are
// shifted by the same amount, so that their weighted mean is the new value. The difference between
// the halves does not change.
TEST(HalfChannels, FollowThePixel) {
  FilmTile film = film_of(1);
  const DenoiserFeatures seen;
  const SampleShares half = {0.5f};
  film.add(0, 0, {grey(1), 1.0f, 0, &seen, &half});
  film.add(0, 0, {grey(3), 1.0f, 1, &seen, &half});
  const float shown[] = {2.5f, 2.0f, 2.0f, 1.0f};
  film.set_override(0, 0, shown);
  EXPECT_EQ(value_of(film, 0, "half1.R"), 1.5f);
  EXPECT_EQ(value_of(film, 0, "half2.R"), 3.5f);
  EXPECT_EQ(value_of(film, 0, "half2.G"), 3.0f);
  EXPECT_EQ(value_of(film, 0, "half1.shared.0.R"), 0.75f);
  EXPECT_EQ(value_of(film, 0, "half2.shared.0.G"), 1.5f);
}

TEST(HalfChannels, SharedValuesStayFinite) {
  FilmTile film = film_of(1);
  const DenoiserFeatures seen;
  const SampleShares shares = {1.0f, 1.0f / 3};
  constexpr float kMost = std::numeric_limits<float>::max();
  for (int i = 0; i < 2; ++i) film.add(0, 0, {grey(kMost), 1.0f, 0, &seen, &shares});
  film.add(0, 0, {grey(0.1f), 1.0f, 1, &seen, &shares});
  EXPECT_GT(value_of(film, 0, "half1.shared.0.R"), 0.4f * kMost);
  EXPECT_TRUE(std::isfinite(value_of(film, 0, "half1.shared.0.R")));
  EXPECT_NEAR(value_of(film, 0, "half2.shared.1.R"), 0.1f / 3, 1e-8f);
  std::vector<std::byte> bytes;
  Archive saving(bytes);
  film.archive(saving);
  saving.end();
  FilmTile loaded = film_of(1);
  Archive loading{std::span<const std::byte>(bytes)};
  EXPECT_NO_THROW(loaded.archive(loading));
}

// Law 4: a sample with a non-finite feature counts as black.
TEST(HalfChannels, FeaturesAreFinite) {
  FilmTile film = film_of(1);
  DenoiserFeatures seen;
  seen.nearness = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(film.add(0, 0, {grey(1), 1.0f, 0, &seen}));
  EXPECT_EQ(film.non_finite(0, 0), 1u);
  EXPECT_EQ(value_of(film, 0, "half1.nearness"), 0.0f);
  EXPECT_EQ(value_of(film, 0, "half1.R"), 0.0f);
}

// Law 3: the channels cost memory only if they are requested, and then as much as documented.
TEST(HalfChannels, MatchTheirDocumentedCost) {
  FilmTile without((AovSet()));
  without.reset({0, 0, 1000, 1});
  EXPECT_FALSE(without.has(Sums::kHalves));
  EXPECT_EQ(film_of(1000).bytes() - without.bytes(), 416000u);
  FilmTile groups(AovSet(), {.light_groups = 2});
  groups.reset({0, 0, 1000, 1});
  EXPECT_EQ(film_of(1000, 2).bytes() - groups.bytes(), 416000u + 72000u);
}

TEST(HalfChannels, AreCopiedAddedAndArchived) {
  LightGroupValues lights(1);
  lights.add(0, 0, Rgb(1.0f), Rgb(3.0f));
  const DenoiserFeatures seen = {Rgb(0.5f), Vec3f(1, 0, 0), 4.0f, 1.0f};
  const SampleShares shares = {0.5f, 1.0f};
  FilmTile film = film_of(1, 1);
  for (int half = 0; half < 2; ++half) {
    film.add(0, 0, {grey(3), 1.0f, half, &seen, &shares, nullptr, &lights});
  }
  FilmTile other = film_of(1, 1);
  other.copy_pixel(film, 0, 0);
  const LightGroupValues dark(1);
  other.add(0, 0, {grey(0), 1.0f, 1, &seen, &shares, nullptr, &dark});
  film.add_film(other);

  std::vector<std::byte> bytes;
  Archive saving(bytes);
  film.archive(saving);
  saving.end();
  FilmTile loaded = film_of(1, 1);
  Archive loading{std::span<const std::byte>(bytes)};
  loaded.archive(loading);
  loading.end();
  float of_half[2][3];
  for (int half = 0; half < 2; ++half) put_half_lights(loaded, 0, half, of_half[half]);
  EXPECT_EQ(of_half[0][0], 3.0f);
  EXPECT_EQ(of_half[1][0], 2.0f);  // the mean of 3, 3 and 0
  EXPECT_EQ(value_of(loaded, 0, "half2.samples"), 3.0f);
  EXPECT_EQ(value_of(loaded, 0, "half2.R"), 2.0f);
  EXPECT_EQ(value_of(loaded, 0, "half2.nearness"), 4.0f);
  EXPECT_EQ(value_of(loaded, 0, "half2.shared.1.R"), 2.0f);
  EXPECT_EQ(value_of(loaded, 0, "half2.shared.0.A"), 0.5f);
}

// A film of 5 x 4 pixels, which is read as rows of its channels. Every sample counts with .75 for
// the pixel to its right and with .25 for its own pixel.
class Sharing : public ::testing::Test {
 protected:
  static constexpr Rect kCrop = {3, 7, 8, 11};

  Sharing() { film_.reset(kCrop); }

  void add(int x, int y, float value, int samples = 1) {
    const DenoiserFeatures seen;
    SampleShares shares = {};
    shares[4] = 0.25f;
    shares[5] = 0.75f;
    for (int i = 0; i < samples; ++i) film_.add(x, y, {grey(value), 1.0f, 0, &seen, &shares});
  }
  void add_all() {
    for (int y = kCrop.y0; y < kCrop.y1; ++y) {
      for (int x = kCrop.x0; x < kCrop.x1; ++x) add(x, y, float(x), 4);
    }
  }
  void read_film(const Rect& rows, std::vector<float>& pixels) const {
    std::vector<float> all;
    film_.resolve(all);
    const size_t channels = names_.size(), first = kCrop.index_of(rows.x0, rows.y0) * channels;
    pixels.assign(&all[first], &all[first] + size_t(rows.area()) * channels);
  }
  std::vector<float> summed() const {
    std::vector<float> pixels;
    ShareResolver rows(kCrop, names_,
                       [&](const Rect& r, std::vector<float>& p) { read_film(r, p); });
    rows.read(kCrop, pixels);
    return pixels;
  }
  float sum_at(const std::vector<float>& pixels, int x, int y) const {
    const auto at = std::ranges::find(summed_names_, "half1.shared.G") - summed_names_.begin();
    return pixels[kCrop.index_of(x, y) * summed_names_.size() + size_t(at)];
  }

  FilmTile film_{denoising()};
  const std::vector<std::string> names_ = film_channel_names(denoising());
  const std::vector<std::string> summed_names_ = resolved_channel_names(names_);
};

TEST_F(Sharing, PixelIsTheSumOfItsWeightedSamples) {
  add_all();
  EXPECT_EQ(summed_names_.size(), names_.size() - 2 * (kSharedValues - 3));
  const std::vector<float> pixels = summed();
  ASSERT_EQ(pixels.size(), summed_names_.size() * size_t(kCrop.area()));
  for (int y = kCrop.y0; y < kCrop.y1; ++y) {
    for (int x = kCrop.x0; x < kCrop.x1; ++x) {
      const bool inside = x > 3 && x < 7 && y > 7 && y < 10;
      const float own = float(x), shared = 0.25f * own + 0.75f * (own - 1);
      EXPECT_EQ(sum_at(pixels, x, y), inside ? shared : own) << x << "," << y;
      // The other channels are unchanged.
      std::vector<float> of_film;
      read_film({3, y, 8, y + 1}, of_film);
      const float* pixel = &pixels[kCrop.index_of(x, y) * summed_names_.size()];
      EXPECT_EQ(pixel[4], 4.0f);
      EXPECT_TRUE(std::equal(pixel, pixel + 5, &of_film[size_t(x - 3) * names_.size()]));
    }
  }
}

TEST_F(Sharing, RowsEqualThoseOfTheWhole) {
  add_all();
  const std::vector<float> whole = summed();
  ShareResolver rows(kCrop, names_, [&](const Rect& r, std::vector<float>& p) { read_film(r, p); });
  std::vector<float> pixels, part;
  for (int y = kCrop.y0; y < kCrop.y1; ++y) {
    rows.read({kCrop.x0, y, kCrop.x1, y + 1}, part);
    pixels.insert(pixels.end(), part.begin(), part.end());
  }
  EXPECT_EQ(pixels, whole);
  std::vector<std::string> names = names_;
  std::vector<float> at_once;
  film_.resolve(at_once);
  resolve_shares(kCrop, names, at_once);
  EXPECT_EQ(at_once, whole);
  EXPECT_EQ(names, summed_names_);
}

// A pixel keeps its own mean if its neighbours have less than half of its samples, or none, or if
// the weights are unknown.
TEST_F(Sharing, NeedsNeighboursThatKnowEnough) {
  add_all();
  add(5, 8, 5.0f, 5);  // 9 in all; the 4 of its neighbours are less than half
  EXPECT_EQ(sum_at(summed(), 5, 8), 5.0f);
  EXPECT_EQ(sum_at(summed(), 4, 9), 3.25f);
  film_.reset(kCrop);
  for (int x = 3; x < 8; ++x) add(x, 8, float(x), 4);
  EXPECT_EQ(sum_at(summed(), 5, 8), 5.0f);  // the row below has none
}

TEST_F(Sharing, StaysFinite) {
  constexpr float kMost = std::numeric_limits<float>::max();
  add_all();
  for (int x = 4; x < 7; ++x) add(x, 9, kMost, 2);
  for (const float value : summed()) ASSERT_TRUE(std::isfinite(value));
}

class Seen : public ::testing::Test {
 protected:
  // Returns the mean of a channel over both halves, at the centre of the frame.
  float middle(const std::string& name) const {
    const auto at = std::ranges::find(image_.channels, "half1." + name);
    EXPECT_NE(at, image_.channels.end()) << name;
    const auto c = size_t(at - image_.channels.begin()), half = half_channels().size() / 2;
    const float* pixel = image_.pixel(8, 8);
    return 0.5f * (pixel[c] + pixel[c + half]);
  }
  void look(const Vec3d& from, const Vec3d& at) {
    RenderSettings settings;
    settings.aovs = "denoising";
    settings.streams = StreamCount::kTwo;
    settings.spp = 256;
    image_ = render(*scene_.build(), perspective(from, at, 1), settings);
  }

  SceneBuilderForTests scene_;
  RenderedImage image_;
};

// The mirror is 3 below the camera, at 45 degrees. It shows the wall beside it, which is 2 farther
// away.
TEST_F(Seen, MirrorsHaveTheFeaturesOfTheirReflection) {
  const int mirror = scene_.add_material(metal(Rgb(0.5f, 1.0f, 1.0f), 0.0f));
  const int wall = scene_.add_material(lambert(Rgb(0.8f, 0.4f, 0.2f)));
  scene_.add_quad({-1, -1, 1}, {1, 1, 1}, {1, 1, -1}, {-1, -1, -1}, mirror);
  scene_.add_quad({-2, -5, 5}, {-2, -5, -5}, {-2, 5, -5}, {-2, 5, 5}, wall);
  scene_.add_point_light({1, 2, 2}, Rgb(10.0f));
  look({0, 3, 0.001}, {0, 0, 0});
  EXPECT_NEAR(middle("nearness"), 1.0 / 5, 0.002);
  EXPECT_NEAR(std::abs(middle("N.X")), 1.0f, 0.01f);
  EXPECT_NEAR(middle("albedo.R"), 0.5f * 0.8f, 0.02f);
  EXPECT_NEAR(middle("albedo.B"), 0.2f, 0.02f);
}

// Features are seen through a pane. One in 13 samples sees the empty background, reflected in the
// pane.
TEST_F(Seen, ThroughAPaneOfGlass) {
  const int pane = scene_.add_material(glass(1.5f, 0.0f, false));
  const int floor = scene_.add_material(lambert(Rgb(0.6f)));
  scene_.add_floor(1, 1, pane);
  scene_.add_floor(5, 0, floor);
  scene_.add_point_light({0.5, 3, 0}, Rgb(10.0f));
  look({0, 4, 0.001}, {0, 0, 0});
  EXPECT_NEAR(middle("nearness"), 0.25f * 12 / 13, 0.02f);
  EXPECT_NEAR(middle("albedo.G"), 0.6f * 12 / 13, 0.05f);
  EXPECT_GT(middle("visibility"), 0.8f);
}

TEST_F(Seen, TheBackgroundIsItsLight) {
  scene_.add_floor(1, 0, scene_.add_material(lambert(Rgb(0.6f))));
  scene_.set_environment(Rgb(0.25f, 0.5f, 7.0f));
  look({0, 4, 0}, {0, 8, 0.001});
  EXPECT_EQ(middle("albedo.R"), 0.25f);
  EXPECT_EQ(middle("albedo.G"), 0.5f);
  EXPECT_EQ(middle("albedo.B"), 1.0f);
  EXPECT_EQ(middle("nearness"), 0.0f);
  EXPECT_EQ(middle("N.Y"), 0.0f);
}

TEST_F(Seen, AShadowIsNotLit) {
  const int grey_floor = scene_.add_material(lambert(Rgb(0.6f)));
  scene_.add_floor(5, 0, grey_floor);
  scene_.add_floor(0.5f, 1, grey_floor, false);
  scene_.add_point_light({0, 2, 0}, Rgb(10.0f));
  look({3, 0.5, 0}, {0, 0, 0});
  EXPECT_EQ(middle("visibility"), 0.0f);
  look({3, 2, 0}, {3, 0, 0.001});
  EXPECT_EQ(middle("visibility"), 1.0f);
}

// Laws 2 and 3: all drivers, thread counts and crops give equal bits, and R G B and all other
// channels are as without denoising.
TEST(DenoisingChannels, DependOnlyOnTheSamples) {
  const std::unique_ptr<Scene> scene = busy_scene();
  RenderSettings s;
  s.width = 37;
  s.height = 29;
  s.spp = 20;
  s.streams = StreamCount::kTwo;
  s.threads = 1;
  s.aovs = "variance,albedo,N,Z,id";
  const RenderedImage without = render(*scene, busy_view(), s);
  s.aovs += ",denoising";
  const RenderedImage with = render(*scene, busy_view(), s);
  for (size_t c = 0; c < without.channels.size(); ++c) {
    const auto at = std::ranges::find(with.channels, without.channels[c]) - with.channels.begin();
    for (size_t i = 0; i < size_t(with.crop.area()); ++i) {
      ASSERT_EQ(with.values[i * with.channels.size() + size_t(at)],
                without.values[i * without.channels.size() + c])
          << without.channels[c];
    }
  }
  s.threads = 3;
  expect_same_bits(render(*scene, busy_view(), s), with, "3 threads");
  s.driver = "bisection";
  expect_same_bits(render(*scene, busy_view(), s), with, "bisection");
  s.crop = {11, 3, 30, 17};
  expect_same_bits(render(*scene, busy_view(), s), with, "a crop");
}

// A small number of samples is split in the middle. A larger number alternates between the two
// halves.
TEST(HalfOfASample, ChangesWithTheStreamOrInTheMiddle) {
  const auto block = [](uint32_t spp) {
    FrameSettings settings;
    settings.denoise = true;
    settings.spp = spp;
    return RenderPlan(settings).half_block;
  };
  EXPECT_EQ(block(2), 1u);
  EXPECT_EQ(block(7), 4u);
  EXPECT_EQ(block(12), 6u);
  EXPECT_EQ(block(16), 8u);
  EXPECT_EQ(block(4096), 8u);
}

}  // namespace
}  // namespace emberline::test
