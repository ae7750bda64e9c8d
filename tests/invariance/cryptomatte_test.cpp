// Cryptomatte: ids follow the specification, coverages sum to alpha, and schedules change no bit.
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <mutex>
#include <numeric>
#include <set>

#include "renderer/core/errors.h"
#include "renderer/core/murmur3.h"
#include "renderer/drivers/driver_table.h"
#include "renderer/engine/film_memory.h"
#include "renderer/engine/render_job.h"
#include "renderer/film/film.h"
#include "renderer/scene/cryptomatte_ids.h"
#include "support/render.h"
#include "support/scenes.h"

namespace emberline {
namespace {

using namespace test;
using Rank = CryptomatteSums::Rank;

constexpr CryptomatteKind kAll[] = {CryptomatteKind::kObject, CryptomatteKind::kMaterial,
                                    CryptomatteKind::kAsset};

// Published test values of MurmurHash3_x86_32.
TEST(Murmur3, HasTheKnownAnswers) {
  EXPECT_EQ(murmur3_32(""), 0u);
  EXPECT_EQ(murmur3_32("", 1), 0x514e28b7u);
  EXPECT_EQ(murmur3_32("", 0xffffffffu), 0x81f16f39u);
  EXPECT_EQ(murmur3_32(std::string_view("\0\0\0\0", 4)), 0x2362f9deu);
  EXPECT_EQ(murmur3_32("aaaa", 0x9747b28cu), 0x5a97808au);
  EXPECT_EQ(murmur3_32("aaa", 0x9747b28cu), 0x283e0130u);
  EXPECT_EQ(murmur3_32("aa", 0x9747b28cu), 0x5d211726u);
  EXPECT_EQ(murmur3_32("a", 0x9747b28cu), 0x7fa09ea6u);
  EXPECT_EQ(murmur3_32("abcd", 0x9747b28cu), 0xf0478627u);
  EXPECT_EQ(murmur3_32("Hello, world!", 0x9747b28cu), 0x24884cbau);
  EXPECT_EQ(murmur3_32("ππππππππ", 0x9747b28cu), 0xd58063c1u);
  EXPECT_EQ(murmur3_32("hello"), 0x248bfa47u);
  EXPECT_EQ(murmur3_32("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

// Several hundred of the 100,000 hashes have an exponent of 0 or 255.
TEST(CryptomatteId, IsAlwaysANormalFloat) {
  int flipped = 0;
  for (int i = 0; i < 100000; ++i) {
    const std::string name = "object " + std::to_string(i);
    const uint32_t id = cryptomatte_id(name), hash = murmur3_32(name);
    ASSERT_TRUE(std::isnormal(std::bit_cast<float>(id))) << name;
    ASSERT_TRUE(id == hash || id == (hash ^ 1u << 23)) << name;
    flipped += id != hash;
  }
  EXPECT_GT(flipped, 500);
  EXPECT_LT(flipped, 1100);
}

TEST(CryptomatteKinds, AreAListInTableOrder) {
  EXPECT_EQ(parse_cryptomattes("asset,object,asset"),
            (std::vector{CryptomatteKind::kObject, CryptomatteKind::kAsset}));
  EXPECT_TRUE(parse_cryptomattes("").empty());
  EXPECT_THROW(parse_cryptomattes("objekt"), UsageError);
}

std::vector<std::string> names_of(const CryptomatteNames& names) {
  std::vector<std::string> list;
  for (const auto& [name, id] : names.ids) {
    EXPECT_EQ(id, cryptomatte_id(name)) << name;
    list.push_back(name);
  }
  return list;
}

// There are six nodes. Two chairs share a name, three legs share another, and one leg has a mesh of
// two primitives.
TEST(CryptomatteIds, DistinguishNodesWithTheSameName) {
  SceneBuilderForTests b;
  b.add_material({});
  b.description.materials[0].name = "oak";
  b.add_material({});
  b.description.materials[1].name = "oak";
  b.add_material({});
  const auto quad = [&](int material) {
    b.add_quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, material);
    return &b.description.instances.back();
  };
  b.description.nodes = {{"chair", 0, false}, {"leg", 0, true},   {"leg", 0, true},
                         {"leg", 3, true},    {"chair", 4, true}, {"lamp", 5, false}};
  // The first leg has no geometry. The other legs keep the names that they have when the first leg
  // is visible.
  quad(0)->node = 2;
  quad(1)->node = 2;
  quad(2)->node = 3;
  quad(-1)->node = 4;
  const CryptomatteIds ids(b.description, kAll);
  ASSERT_EQ(ids.names().size(), 3u);
  EXPECT_EQ(names_of(ids.names()[0]),
            (std::vector<std::string>{"leg_2", "leg_3", "chair", "environment"}));
  EXPECT_EQ(names_of(ids.names()[1]),
            (std::vector<std::string>{"oak", "oak_2", "material 2", "default", "environment"}));
  EXPECT_EQ(names_of(ids.names()[2]),
            (std::vector<std::string>{"chair", "leg", "chair_2", "environment"}));
  EXPECT_EQ(ids.ids_of_hit(1)[0], cryptomatte_id("leg_2"));
  EXPECT_EQ(ids.ids_of_hit(2)[0], cryptomatte_id("leg_2"));
  EXPECT_EQ(ids.ids_of_hit(2)[1], cryptomatte_id("oak_2"));
  EXPECT_EQ(ids.ids_of_hit(1)[2], cryptomatte_id("chair"));
  EXPECT_EQ(ids.ids_of_hit(4)[1], cryptomatte_id("default"));
  EXPECT_EQ(ids.ids_of_hit(0)[2], cryptomatte_id("environment"));
}

// A renamed duplicate does not take a name that another node has.
TEST(CryptomatteIds, KeepUniqueNames) {
  SceneBuilderForTests b;
  b.add_quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, -1);
  b.description.instances.clear();
  b.description.nodes = {
      {"twin", 0, true}, {"twin", 1, true}, {"twin_2", 2, true}, {"environment", 3, true}};
  for (int node = 0; node < 4; ++node) {
    b.place(0);
    b.description.instances.back().node = node;
  }
  const CryptomatteIds ids(b.description, std::span(kAll).first(1));
  EXPECT_EQ(names_of(ids.names()[0]),
            (std::vector<std::string>{"twin", "twin_3", "twin_2", "environment", "environment_2"}));
  EXPECT_EQ(ids.ids_of_hit(3)[0], cryptomatte_id("twin_2"));
}

// Among this many names, some hashes collide. Names with the same hash must still get different
// ids.
TEST(CryptomatteIds, DifferEvenIfHashesCollide) {
  constexpr int kObjects = 200000;
  SceneBuilderForTests b;
  b.add_quad({0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, -1);
  b.description.instances.clear();
  std::set<uint32_t> hashes;
  for (int i = 0; i < kObjects; ++i) {
    b.place(0);
    b.description.instances.back().name = "n" + std::to_string(i);
    hashes.insert(cryptomatte_id(b.description.instances.back().name));
  }
  ASSERT_LT(hashes.size(), size_t(kObjects)) << "no two hashes are equal: take more names";
  const CryptomatteIds ids(b.description, std::span(kAll).first(1));
  std::set<uint32_t> found;
  for (const auto& [name, id] : ids.names()[0].ids) {
    EXPECT_EQ(id, cryptomatte_id(name));
    found.insert(id);
  }
  EXPECT_EQ(found.size(), size_t(kObjects) + 1);
}

// The Cryptomatte list of one pixel with `levels` entries.
struct List {
  explicit List(size_t levels) : ids(levels), weights(levels + 1) {}
  CryptomatteSums sums() {
    return {ids.data(), weights.data(), {.cryptomattes = 1, .cryptomatte_levels = int(ids.size())}};
  }
  std::vector<uint32_t> ids;
  std::vector<double> weights;
};

List sums_of(std::initializer_list<std::pair<uint32_t, float>> samples, size_t levels) {
  List list(levels);
  for (const auto& [id, weight] : samples) list.sums().add(weight, {&id, 1});
  return list;
}

std::vector<Rank> ranks_of(List list, double samples, float* dropped) {
  std::vector<Rank> ranks(list.ids.size());
  *dropped = list.sums().resolve(0, samples, ranks);
  return ranks;
}

TEST(CryptomatteSums, DropTheLeastAndCountIt) {
  float dropped = 0;
  std::vector<Rank> ranks =
      ranks_of(sums_of({{5, 1}, {6, 1}, {5, 1}, {7, 1}, {7, 1}, {8, 1}}, 2), 8, &dropped);
  // 7 replaces 6, and then 8 replaces 7. If entries have equal weights, the later one is dropped.
  EXPECT_EQ(ranks[0].id, 5u);
  EXPECT_FLOAT_EQ(ranks[0].coverage, 2.0f / 8);
  EXPECT_EQ(ranks[1].id, 8u);
  EXPECT_FLOAT_EQ(ranks[1].coverage, 1.0f / 8);
  EXPECT_FLOAT_EQ(dropped, 3.0f / 8);

  ranks = ranks_of(sums_of({{9, 1}, {4, 1}}, 4), 2, &dropped);
  EXPECT_EQ(ranks[0].id, 4u) << "of equals the smaller id";
  EXPECT_EQ(ranks[2].id, 0u);
  EXPECT_EQ(dropped, 0.0f);
}

// Coverages stay within [0, 1] with a filter that has negative lobes.
TEST(CryptomatteSums, StayCoveragesWithNegativeLobes) {
  float dropped = 0;
  std::vector<Rank> ranks = ranks_of(sums_of({{5, 1.5f}, {6, -0.5f}, {5, 1.5f}}, 2), 2, &dropped);
  EXPECT_EQ(ranks[0].id, 5u);
  EXPECT_FLOAT_EQ(ranks[0].coverage, 1.0f);
  EXPECT_EQ(ranks[1].id, 0u);
  ranks = ranks_of(sums_of({{5, -1.5f}}, 2), 2, &dropped);
  EXPECT_EQ(ranks[0].id, 0u);
  EXPECT_EQ(dropped, 0.0f);
}

TEST(CryptomatteSums, RejectInvalidIdsWhenLoading) {
  const auto is_valid = [](uint32_t id, double weight) {
    List list(1);
    list.ids[0] = id;
    list.weights[0] = weight;
    return list.sums().is_valid();
  };
  EXPECT_TRUE(is_valid(0x3f800000u, 2.0));
  EXPECT_TRUE(is_valid(0, 0.0));
  EXPECT_FALSE(is_valid(0x7fc00000u, 2.0));  // NaN
  EXPECT_FALSE(is_valid(1, 2.0));            // denormal
  EXPECT_FALSE(is_valid(0x3f800000u, std::nan("")));
}

// ---- pictures

// For each pixel: alpha, and for each kind the dropped coverage, followed by the ranks.
struct Mattes {
  Rect crop;
  std::vector<float> alpha;
  std::vector<std::vector<uint32_t>> ids;
  std::vector<std::vector<float>> coverages;
  uint64_t dropping = 0;  // number of lists that dropped coverage

  explicit Mattes(const Rect& rect)
      : crop(rect),
        alpha(size_t(rect.area())),
        ids(size_t(rect.area())),
        coverages(size_t(rect.area())) {}
};

class MatteSink final : public RenderSink {
 public:
  explicit MatteSink(Mattes& mattes) : mattes_(mattes) {}
  void tile_finished(const FilmTile& tile) override {
    std::vector<Rank> ranks(size_t(tile.extras().cryptomatte_levels));
    const std::lock_guard lock(mutex_);
    for (size_t i = 0; i < size_t(tile.rect().area()); ++i) {
      const int x = tile.rect().x_of(i), y = tile.rect().y_of(i);
      const size_t at = mattes_.crop.index_of(x, y);
      float rgba[4];
      tile.rgba(x, y, rgba);
      mattes_.alpha[at] = rgba[3];
      for (size_t kind = 0; kind < size_t(tile.extras().cryptomattes); ++kind) {
        const float dropped = tile.mattes(i).resolve(kind, tile.sums(i).samples(), ranks);
        if (dropped > 0) ++mattes_.dropping;
        mattes_.coverages[at].push_back(dropped);
        for (const Rank& rank : ranks) {
          mattes_.ids[at].push_back(rank.id);
          mattes_.coverages[at].push_back(rank.coverage);
        }
      }
    }
  }

 private:
  Mattes& mattes_;
  std::mutex mutex_;
};

// Holds a scene and its ids. The scene of matte_scene() has thin strips, several per pixel and some
// of them moving, behind a veil, and a ball out of focus.
struct MatteScene {
  std::unique_ptr<Scene> scene;
  CryptomatteIds ids;

  explicit MatteScene(const SceneDescription& description)
      : scene(build_scene(description, {})), ids(description, kAll) {}
};

MatteScene matte_scene() {
  SceneBuilderForTests b;
  const int grey = b.add_material(lambert(Rgb(0.5f))), red = b.add_material(lambert({0.8f, 0, 0}));
  MaterialDescription veil = lambert({0.2f, 0.7f, 0.3f});
  veil.alpha = 0.4f;
  veil.alpha_mode = AlphaMode::kBlend;
  veil.double_sided = true;
  for (int i = 0; i < 60; ++i) {
    const float x = -1.5f + 0.05f * float(i);
    b.add_quad({x, -1, 0}, {x + 0.03f, -1, 0}, {x + 0.03f, 1, 0}, {x, 1, 0}, i % 2 ? grey : red);
    InstanceDescription& strip = b.description.instances.back();
    strip.name = "strip " + std::to_string(i / 2);
    if (i % 7 == 0) strip.motion = {translation(0.3, 0.05, 0)};
  }
  b.add_quad({-1, -0.5f, 0.5f}, {0.5f, -0.5f, 0.5f}, {0.5f, 0.2f, 0.5f}, {-1, 0.2f, 0.5f},
             b.add_material(veil));
  b.description.instances.back().name = "veil";
  b.place(b.add_mesh(SceneBuilderForTests::sphere(0.5f, 12, red)), translation(0.9, 0.5, 2));
  b.set_environment(Rgb(0.3f));
  return MatteScene(b.description);
}

CameraDescription matte_view() {
  CameraDescription view = perspective({0.3, 0.2, 5}, {0, 0, 0}, 35);
  view.lens_radius = 0.1;
  view.focus_distance = 5;
  return view;
}

RenderSettings matte_settings() {
  RenderSettings s;
  s.width = 26;
  s.height = 18;
  s.spp = 32;
  s.max_depth = 1;
  s.shutter = Shutter{0, 1};
  s.cryptomattes = "object,material,asset";
  s.filter = kDefaultFilter;
  return s;
}

Mattes mattes(const MatteScene& of, const RenderSettings& s) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(s.threads));
  const Camera camera(matte_view(), s.width, s.height, of.scene->origin(), of.scene->scale());
  RenderPlan plan = plan_of(s);
  const Frame frame = plan.frame(*of.scene, camera, {.cryptomattes = &of.ids});
  Mattes seen(plan.crop);
  MatteSink sink(seen);
  tbb::task_arena arena(s.threads);
  RenderJob render(frame, driver_factory(s.driver, plan.driver_settings));
  arena.execute([&] {
    render.render(sink, {});
    render.deliver(sink);
  });
  return seen;
}

void expect_sums(const Mattes& seen) {
  for (size_t i = 0; i < seen.alpha.size(); ++i) {
    const size_t of_kind = seen.coverages[i].size() / std::size(kAll);
    for (size_t kind = 0; kind < std::size(kAll); ++kind) {
      const float* begin = &seen.coverages[i][kind * of_kind];
      const float sum = std::accumulate(begin, begin + of_kind, 0.0f);
      ASSERT_NEAR(sum, seen.alpha[i], 1e-5f) << "pixel " << i << ", kind " << kind;
      ASSERT_TRUE(std::is_sorted(begin + 1, begin + of_kind, std::greater<>()));
      for (const float* c = begin; c < begin + of_kind; ++c) ASSERT_GE(*c, 0.0f);
    }
  }
}

TEST(Cryptomatte, AddsUpToAlpha) {
  const MatteScene scene = matte_scene();
  for (const bool transparent : {false, true}) {
    for (const char* filter : {"box", "blackman-harris", "mitchell"}) {
      for (const int levels : {1, 2, 6, 7}) {
        RenderSettings s = matte_settings();
        s.transparent = transparent;
        s.filter = filter;
        s.cryptomatte_levels = levels;
        SCOPED_TRACE(testing::Message() << filter << ", levels " << levels);
        const Mattes seen = mattes(scene, s);
        expect_sums(seen);
        if (levels == 1) {
          EXPECT_GT(seen.dropping, 500u);
        }
      }
    }
  }
  RenderSettings s = matte_settings();
  s.sampler = "poisson_disk";  // this sampler weights its samples
  expect_sums(mattes(scene, s));
}

// With enough levels nothing is dropped, and coverages with a box filter are whole numbers of
// samples.
TEST(Cryptomatte, CountsSamples) {
  const MatteScene scene = matte_scene();
  RenderSettings s = matte_settings();
  s.filter = "box";
  s.cryptomatte_levels = 32;
  const Mattes seen = mattes(scene, s);
  EXPECT_EQ(seen.dropping, 0u);
  size_t shared = 0;
  for (size_t i = 0; i < seen.alpha.size(); ++i) {
    for (const float c : seen.coverages[i]) ASSERT_EQ(c * 32, std::round(c * 32));
    shared += seen.coverages[i][3] > 0.0f;  // three objects or more
  }
  EXPECT_GT(shared, 100u);
}

TEST(Cryptomatte, DoesNotDependOnTheSchedule) {
  const MatteScene scene = matte_scene();
  RenderSettings s = matte_settings();
  s.cryptomatte_levels = 3;
  const Mattes whole = mattes(scene, s);
  EXPECT_GT(whole.dropping, 50u) << "there must be something to drop";
  const auto expect_equal = [&](const Mattes& other, const std::string& what) {
    for (int y = other.crop.y0; y < other.crop.y1; ++y) {
      for (int x = other.crop.x0; x < other.crop.x1; ++x) {
        const size_t i = whole.crop.index_of(x, y), j = other.crop.index_of(x, y);
        ASSERT_EQ(other.ids[j], whole.ids[i]) << what << ": " << x << "," << y;
        ASSERT_EQ(other.coverages[j], whole.coverages[i]) << what << ": " << x << "," << y;
      }
    }
  };
  for (const int threads : {1, 3}) {
    for (const char* driver : {"bucket", "bisection"}) {
      for (const int bucket : {5, 64}) {
        RenderSettings other = s;
        other.threads = threads;
        other.driver = driver;
        other.bucket_size = bucket;
        other.find_empty_pixels = threads == 1;
        expect_equal(mattes(scene, other), driver);
      }
    }
  }
  s.crop = {7, 3, 19, 16};
  expect_equal(mattes(scene, s), "crop");
}

// The film of one range of samples, added to the film of the other range, equals the film of all
// samples.
TEST(Cryptomatte, TwoRangesEqualTheWhole) {
  const MatteScene scene = matte_scene();
  RenderSettings s = matte_settings();
  s.cryptomatte_levels = 32;  // nothing is dropped, so the order does not matter
  const Camera camera(matte_view(), s.width, s.height, scene.scene->origin(), scene.scene->scale());
  const auto film = [&](uint32_t first, uint32_t end) {
    RenderSettings range = s;
    range.driver = "bisection";
    range.spp = end - first;
    RenderPlan plan = plan_of(range);
    plan.first_sample = first;
    plan.find_empty_pixels = false;
    const Frame frame = plan.frame(*scene.scene, camera, {.cryptomattes = &scene.ids});
    auto render =
        std::make_unique<RenderJob>(frame, driver_factory("bisection", plan.driver_settings));
    Mattes unseen(plan.crop);
    MatteSink sink(unseen);
    render->render(sink, {});
    return render;
  };
  const auto whole = film(0, 32), first = film(0, 12), second = film(12, 32);
  const FilmExtras extras = whole->film().extras();
  FilmTile sum(AovSet(), extras);
  sum.reset(whole->film().rect());
  sum.add_film(first->film());
  sum.add_film(second->film());
  std::vector<Rank> a(32), b(32);
  for (size_t i = 0; i < size_t(sum.rect().area()); ++i) {
    for (size_t kind = 0; kind < 3; ++kind) {
      EXPECT_EQ(sum.mattes(i).resolve(kind, 32, a), 0.0f);
      whole->film().mattes(i).resolve(kind, 32, b);
      for (size_t r = 0; r < a.size(); ++r) {
        ASSERT_EQ(a[r].id, b[r].id);
        ASSERT_NEAR(a[r].coverage, b[r].coverage, 1e-6f);
      }
    }
  }
}

// A frame without Cryptomatte needs no film memory for it.
TEST(Cryptomatte, CostsNothingIfNotRequested) {
  EXPECT_EQ(film_bytes_per_pixel({}, {}), sizeof(PixelSums) + 4 * sizeof(float));
  FilmExtras extras;
  extras.cryptomattes = 2;
  extras.cryptomatte_levels = 6;
  EXPECT_EQ(film_bytes_per_pixel({}, extras),
            sizeof(PixelSums) + 4 * sizeof(float) + 2 * (6 * 12 + 8));
}

}  // namespace
}  // namespace emberline
