// Cases E1 and E2 compare estimators of the same picture that have less and less in common: MIS of
// light and BSDF samples with one and with three light samples, BSDF sampling alone, and the naive
// path tracer (naive_path_tracer.h), which shares no code with the others. The tests compare blocks
// and the whole frame, channel by channel.
#include <array>

#include "closed_form.h"
#include "io/gltf/gltf_file.h"
#include "naive_path_tracer.h"
#include "renderer/core/moments.h"
#include "support/lit_scenes.h"

namespace emberline {
namespace {

using namespace test;

constexpr int kFrame = 64, kBlock = 8, kBlocks = kFrame / kBlock;
constexpr int kMaxDepth = 5;  // roulette starts at depth 2

// Means over blocks and over the frame, with the variances of these means.
struct BlockMeans {
  std::array<std::array<double, 3>, kBlocks * kBlocks> mean{}, variance{};

  double frame_mean(size_t channel) const {
    double sum = 0;
    for (const auto& m : mean) sum += m[channel];
    return sum / double(mean.size());
  }
  double frame_error(size_t channel) const {
    double sum = 0;
    for (const auto& v : variance) sum += v[channel];
    return std::sqrt(sum) / double(variance.size());
  }
};

// The two streams of a pixel are independent, even where the samples within a stream are
// correlated, so the difference between the streams gives the variance (film.h). A block has 64
// such differences.
BlockMeans rendered(const Scene& scene, const CameraDescription& view, int light_samples,
                    uint32_t spp, uint32_t seed) {
  RenderSettings s;
  s.width = s.height = kFrame;
  s.spp = spp;
  s.seed = seed;
  s.max_depth = kMaxDepth;
  s.light_samples = light_samples;
  s.streams = StreamCount::kTwo;
  s.aovs = "variance";
  const RenderedImage image = render(scene, view, s);
  EXPECT_EQ(image.counters.non_finite_samples, 0u);
  BlockMeans result;
  constexpr double kPixels = kBlock * kBlock;
  for (int y = 0; y < kFrame; ++y)
    for (int x = 0; x < kFrame; ++x) {
      const size_t block = size_t(y / kBlock * kBlocks + x / kBlock);
      const float* pixel = image.pixel(x, y);
      for (size_t c = 0; c < 3; ++c) {  // channels: R G B A samples variance.R ...
        result.mean[block][c] += double(pixel[c]) / kPixels;
        result.variance[block][c] += double(pixel[5 + c]) / square(kPixels);
      }
    }
  return result;
}

BlockMeans traced_naively(const NaivePathTracer& tracer, int paths_per_block, uint64_t seed) {
  BlockMeans result;
  for (size_t block = 0; block < result.mean.size(); ++block) {
    std::mt19937_64 random(seed * 1000 + block);
    std::uniform_real_distribution<double> uniform(0, 1);
    Moments sums[3];
    for (int i = 0; i < paths_per_block; ++i) {
      const double x = (double(block % kBlocks) + uniform(random)) / kBlocks;
      const double y = (double(block / kBlocks) + uniform(random)) / kBlocks;
      const Vec3d radiance = tracer.radiance(x, y, kMaxDepth, random);
      for (int c = 0; c < 3; ++c) sums[c].add(radiance[c]);
    }
    for (size_t c = 0; c < 3; ++c) {
      result.mean[block][c] = sums[c].mean();
      result.variance[block][c] = square(sums[c].standard_error());
    }
  }
  return result;
}

// Frame means may differ from the reference by 5 standard errors of the difference. The worst of
// the 192 block means must lie within 6.5 standard errors. Sidak's limit for a family error of 1e-6
// is 5.9 for a normal variable. It is 6.5 for Student's t with 100 degrees of freedom, and a block
// has at least as many.
void expect_same(const BlockMeans& a, const BlockMeans& reference, const std::string& number,
                 const std::string& what, const std::string& how) {
  const char* names[] = {"R", "G", "B"};
  double worst = 0;
  for (size_t c = 0; c < 3; ++c) {
    const double error = std::hypot(a.frame_error(c), reference.frame_error(c));
    // The tolerance is 1e-6, since the film's channels are float.
    expect_case({number, what + ", frame mean " + names[c]},
                {reference.frame_mean(c), a.frame_mean(c), error, 1e-6 * reference.frame_mean(c)},
                how);
    for (size_t block = 0; block < a.mean.size(); ++block) {
      const double variance = a.variance[block][c] + reference.variance[block][c];
      const double difference = a.mean[block][c] - reference.mean[block][c];
      const double z = variance > 0 ? difference / std::sqrt(variance) : difference * 1e6;
      if (std::abs(z) > std::abs(worst)) worst = z;
    }
  }
  expect_case({number, what + ", worst of 192 block means in standard errors"}, {0, worst, 1, 1.5},
              how);
}

void compare_estimators(const SceneDescription& description, const CameraDescription& view,
                        const std::string& number, const std::string& name, int naive_paths) {
  SceneDescription copy = description;
  const auto scene = build_scene(std::move(copy), {});
  constexpr uint32_t kSpp = 64;  // with fewer, block means would be far from normal
  const BlockMeans both = rendered(*scene, view, 1, kSpp, 1);
  const BlockMeans several = rendered(*scene, view, 3, kSpp / 2, 4);
  const BlockMeans bsdf = rendered(*scene, view, 0, 4 * kSpp, 2);
  const BlockMeans naive = traced_naively(NaivePathTracer(description, view, 1), naive_paths, 3);
  const std::string how = fmt::format(
      "64 x 64, depth 5, seeds 1 (MIS, {} spp), 2 (BSDF, {} spp), 3 (naive, {} paths a "
      "block), 4 (three light samples, {} spp)",
      kSpp, 4 * kSpp, naive_paths, kSpp / 2);
  expect_same(both, bsdf, number, name + ", MIS against BSDF sampling", how);
  expect_same(both, naive, number, name + ", MIS against the naive tracer", how);
  expect_same(several, naive, number, name + ", three light samples against the naive tracer", how);
  expect_same(bsdf, naive, number, name + ", BSDF sampling against the naive tracer", how);
}

// E50 compares three light samples with one, which other cases verify. The scene has lamps without
// extent, an emissive tube, a sky, a smooth coat and its reflections, a mirror, a pane, and solid
// glass.
TEST(Estimators, SeveralLightSamples) {
  SceneDescription description = glazed_scene();
  MaterialDescription& matt = description.materials[kMatt];
  matt.clearcoat = 0.8f;
  matt.specular = 1.0f;
  matt.roughness = 0.4f;
  description.materials[kRed] = metal({.9f, .5f, .4f}, 0.0f);
  const auto scene = build_scene(std::move(description), {});
  const BlockMeans one = rendered(*scene, lit_view(), 1, 128, 5);
  const BlockMeans three = rendered(*scene, lit_view(), 3, 64, 6);
  expect_same(three, one, "E50", "three light samples against one",
              "64 x 64, depth 5, seeds 5 (one, 128 spp), 6 (three, 64 spp)");
}

// Reads the box from this repository, and makes its surfaces Lambertian, as in the measured box.
// Case 1 tests glTF's dielectric layer.
TEST(Estimators, CornellBox) {
  SceneDescription scene = load_gltf(EMBERLINE_SCENES "/cornell_box.glb", {});
  ASSERT_EQ(scene.cameras.size(), 1u);
  for (MaterialDescription& m : scene.materials) m.specular = 0;
  compare_estimators(scene, scene.cameras[0], "E1", "Cornell box", 100'000);
}

// A box and a faceted ball stand under an open sky, with a lamp that faces down and a two-sided
// emissive card. Occlusion is everywhere, and the emitters also reflect.
TEST(Estimators, StillLife) {
  SceneBuilderForTests b;
  b.add_floor(4, 0, b.add_material(lambert({.7f, .6f, .5f})));
  b.place(
      b.add_mesh(SceneBuilderForTests::sphere(.7f, 5, b.add_material(lambert({.2f, .5f, .8f})))),
      translation(-.6, .7, 0));
  const int red = b.add_material(lambert({.8f, .2f, .1f}));
  const Vec3f low(.3f, 0, -.9f), high(1.3f, 1.1f, .1f);
  const auto corner = [&](int i) {
    return Vec3f(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
  };
  for (const auto& [p, q, r, t] :
       {std::array{0, 4, 6, 2}, {1, 3, 7, 5}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}})
    b.add_quad(corner(p), corner(q), corner(r), corner(t), red);
  MaterialDescription lamp = lambert(Rgb(.5f));
  lamp.emission = {12, 10, 7};
  b.add_floor(.4f, 3, b.add_material(lamp), /*up=*/false);
  MaterialDescription card = lambert({.3f, .8f, .3f});
  card.emission = {.5f, 1, 2};
  card.double_sided = true;
  b.add_quad({-.2f, 0, .8f}, {.5f, 0, .5f}, {.5f, .6f, .5f}, {-.2f, .6f, .8f},
             b.add_material(card));
  b.set_environment({.2f, .3f, .5f});
  compare_estimators(b.description, perspective({1, 2, 5}, {0, .5, 0}, 35), "E2", "still life",
                     long_or_short(25'000, 12'500));
}

}  // namespace
}  // namespace emberline
