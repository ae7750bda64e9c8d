// Tests --cryptomatte: the layers and names in a file, refused options, resume and merge. OpenEXR
// reads the file, and the tests check it against the specification.
#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "cli/command_test.h"

namespace emberline::test {
namespace {

// Computes MurmurHash3_32 as the specification's Python code does. Reads the padded text word by
// word.
uint32_t reference_id(const std::string& name) {
  const auto mix = [](uint32_t k) {
    k *= 0xcc9e2d51u;
    return (k << 15 | k >> 17) * 0x1b873593u;
  };
  uint32_t h = 0;
  size_t i = 0;
  for (; i + 4 <= name.size(); i += 4) {
    uint32_t k = 0;
    for (size_t b = 4; b-- > 0;) k = k << 8 | static_cast<unsigned char>(name[i + b]);
    h ^= mix(k);
    h = (h << 13 | h >> 19) * 5 + 0xe6546b64u;
  }
  uint32_t k = 0;
  for (size_t b = name.size(); b-- > i;) k = k << 8 | static_cast<unsigned char>(name[b]);
  h ^= mix(k) ^ uint32_t(name.size());
  h = (h ^ h >> 16) * 0x85ebca6bu;
  h = (h ^ h >> 13) * 0xc2b2ae35u;
  h ^= h >> 16;
  const uint32_t exponent = h >> 23 & 255;
  return exponent == 0 || exponent == 255 ? h ^ 1u << 23 : h;
}

class CryptomatteOption : public CommandTest {
 protected:
  const std::string strange_ = "say \"boo\"\n/ \\ päivää " + std::string(300, 'x');

  // The scene has three strips above a floor. Two of them are children of the node "set". Two
  // strips have the same name, and one has a strange name.
  void SetUp() override {
    GltfBuilder gltf = unlit_scene();
    const int red = gltf.push("materials", {{"name", "paint"}, {"emissiveFactor", {1, 0.2, 0.1}}});
    const int blue = gltf.push("materials", {{"name", "paint"}, {"emissiveFactor", {0, 0.2, 1}}});
    add_quad(gltf, {-0.7f, 0.1f, 0}, {0.33f, 0, 0}, {0, 0.9f, 0}, red);
    add_quad(gltf, {-0.2f, 0.1f, 0}, {0.33f, 0, 0}, {0, 0.9f, 0}, blue);
    add_quad(gltf, {0.3f, 0.1f, 0}, {0.33f, 0, 0}, {0, 0.9f, 0}, red);
    auto& nodes = gltf.root["nodes"];
    auto& roots = gltf.root["scenes"][0]["nodes"];
    const size_t last = nodes.size();
    nodes[last - 3]["name"] = "strip";
    nodes[last - 2]["name"] = "strip";
    nodes[last - 1]["name"] = strange_;
    nodes.push_back({{"name", "set"}, {"children", {last - 2, last - 1}}});
    nlohmann::json kept = nlohmann::json::array();
    for (const auto& root : roots) {
      if (root != last - 2 && root != last - 1) kept.push_back(root);
    }
    kept.push_back(last);
    roots = kept;
    gltf.write_glb(path("scene.glb"));
  }
  Words words(const Words& more) {
    return render_words(
        Words{"--size", "40x30", "--spp", "8", "--cryptomatte", "object,material,asset"} + more);
  }
  ExrPicture picture(const Words& more) {
    render(words(more));
    return read_exr(path("out.exr"));
  }
};

// Returns the manifest of a layer. A manifest maps names to ids.
nlohmann::json manifest_of(const ExrPicture& picture, const std::string& layer) {
  for (const auto& [key, value] : picture.attributes) {
    if (!key.starts_with("cryptomatte/") || !key.ends_with("/name") || value != layer) continue;
    const std::string begin = key.substr(0, key.size() - 4);
    EXPECT_EQ(begin.size(), std::string("cryptomatte/1234567/").size());
    EXPECT_EQ(picture.attributes.at(begin + "hash"), "MurmurHash3_32");
    EXPECT_EQ(picture.attributes.at(begin + "conversion"), "uint32_to_float32");
    return nlohmann::json::parse(picture.attributes.at(begin + "manifest"));
  }
  ADD_FAILURE() << "no manifest of " << layer;
  return {};
}

// Returns the matte that a compositor shows for a name: the sum of the coverages of its id.
std::vector<float> matte(const ExrPicture& picture, const std::string& layer,
                         const std::string& name) {
  std::vector<float> sums(picture.channels.at("A").size(), 0.0f);
  for (int i = 0; i < 3; ++i) {
    const std::string begin = layer + "0" + std::to_string(i);
    for (const auto& [id, coverage] : {std::pair(".R", ".G"), std::pair(".B", ".A")}) {
      EXPECT_EQ(picture.types.at(begin + id), "float");
      const std::vector<float>& ids = picture.channels.at(begin + id);
      const std::vector<float>& coverages = picture.channels.at(begin + coverage);
      for (size_t p = 0; p < sums.size(); ++p) {
        if (std::bit_cast<uint32_t>(ids[p]) == reference_id(name)) sums[p] += coverages[p];
      }
    }
  }
  return sums;
}

double sum_of(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += double(value);
  return sum;
}

TEST_F(CryptomatteOption, FollowsTheSpecification) {
  const ExrPicture seen = picture({"--report", path("report.json")});
  const std::map<std::string, Words> names = {
      {"CryptoObject", {"strip", "strip_2", strange_}},
      {"CryptoMaterial", {"paint", "paint_2"}},
      {"CryptoAsset", {"strip", "set"}},
  };
  for (const auto& [layer, expected] : names) {
    SCOPED_TRACE(layer);
    const nlohmann::json manifest = manifest_of(seen, layer);
    for (const std::string& name : expected) {
      ASSERT_TRUE(manifest.contains(name)) << name;
      EXPECT_GT(sum_of(matte(seen, layer, name)), 3.0) << name;
    }
    std::vector<float> all(seen.channels.at("A").size(), 0.0f);
    for (const auto& [name, hex] : manifest.items()) {
      EXPECT_EQ(hex.get<std::string>().size(), 8u);
      EXPECT_EQ(std::stoul(hex.get<std::string>(), nullptr, 16), reference_id(name)) << name;
      const std::vector<float> of_name = matte(seen, layer, name);
      for (size_t i = 0; i < all.size(); ++i) all[i] += of_name[i];
    }
    for (size_t i = 0; i < all.size(); ++i) {
      const float dropped = seen.channels.at("dropped." + layer)[i];
      ASSERT_NEAR(all[i] + dropped, seen.channels.at("A")[i], 1e-5f) << i;
    }
  }
  // In each pixel, the coverage of the set is the sum of those of the second and the third strip.
  const std::vector<float> set = matte(seen, "CryptoAsset", "set"),
                           second = matte(seen, "CryptoObject", "strip_2"),
                           strange = matte(seen, "CryptoObject", strange_);
  for (size_t i = 0; i < set.size(); ++i) ASSERT_NEAR(set[i], second[i] + strange[i], 1e-6f);
  const nlohmann::json report = read_json("report.json")["cryptomattes"];
  EXPECT_EQ(report["object"]["names"], manifest_of(seen, "CryptoObject").size());
  EXPECT_EQ(report["object"]["dropped_pixels"], 0);
}

TEST_F(CryptomatteOption, DoesNotChangeThePicture) {
  const ExrPicture with = picture({});
  render(render_words({"--size", "40x30", "--spp", "8"}));
  const ExrPicture without = read_exr(path("out.exr"));
  for (const auto& [name, values] : without.channels) EXPECT_EQ(with.channels.at(name), values);
  for (const auto& [name, value] : without.attributes) {
    EXPECT_FALSE(name.starts_with("cryptomatte/"));
    EXPECT_FALSE(name.starts_with("emberline:cryptomatte_levels"));
  }
}

TEST_F(CryptomatteOption, HasTheRequestedLevels) {
  const ExrPicture seen = picture({"--cryptomatte-levels", "3"});
  EXPECT_TRUE(seen.channels.contains("CryptoObject01.A"));
  EXPECT_FALSE(seen.channels.contains("CryptoObject02.R"));
  EXPECT_EQ(sum_of(seen.channels.at("CryptoObject01.B")), 0.0);
}

// Merged parts, a resumed frame and an extended frame must have the same bits as a frame rendered
// at once.
TEST_F(CryptomatteOption, GoesThroughCheckpoints) {
  const Words more = {"--bucket-size", "16"};
  const ExrPicture whole = picture(more);
  for (const char* part : {"1/2", "2/2"}) render(words(more + Words{"--part", part}));
  render({"merge", "-o", path("merged.exr"), path("out.exr.part-1-of-2.checkpoint"),
          path("out.exr.part-2-of-2.checkpoint"), "--report", path("merge.json")});
  const ExrPicture merged = read_exr(path("merged.exr"));
  EXPECT_EQ(first_difference(whole, merged), "");
  EXPECT_EQ(manifest_of(whole, "CryptoObject"), manifest_of(merged, "CryptoObject"));
  EXPECT_EQ(read_json("merge.json")["cryptomattes"]["asset"]["names"],
            manifest_of(whole, "CryptoAsset").size());

  const Words frame = {"render", scene(),         "-o", path("out.exr"), "--size",
                       "40x30",  "--bucket-size", "16", "--cryptomatte", "object,material,asset"};
  for (const char* range : {"0-3", "3-8"}) render(frame + Words{"--sample-range", range});
  render({"merge", "-o", path("ranges.exr"), path("out.exr.samples-0-3.checkpoint"),
          path("out.exr.samples-3-8.checkpoint")});
  const ExrPicture ranges = read_exr(path("ranges.exr"));
  for (const auto& [name, values] : whole.channels) {
    if (!name.starts_with("Crypto")) continue;
    const std::vector<float>& others = ranges.channels.at(name);
    for (size_t i = 0; i < values.size(); ++i) {
      ASSERT_NEAR(others[i], values[i], 1e-6f * std::abs(values[i])) << name << ", " << i;
    }
  }

  render(frame + Words{"--spp", "4", "--resumable"});
  render({"extend", path("out.exr"), "--spp", "8", "-o", path("extended.exr")});
  EXPECT_EQ(first_difference(whole, read_exr(path("extended.exr"))), "");
}

TEST_F(CryptomatteOption, RejectsUnsupportedSettings) {
  expect_failure(words({"--cryptomatte", "objects"}), 2,
                 {"--cryptomatte", "objects", "object, material, asset"});
  expect_failure(words({"--cryptomatte-levels", "0"}), 2, {"--cryptomatte-levels", "1 to 64"});
  expect_failure(render_words({"--cryptomatte-levels", "4"}), 2,
                 {"--cryptomatte-levels requires --cryptomatte"});
  expect_failure({"render", scene(), "-o", path("out.png"), "--cryptomatte", "object"}, 2,
                 {"--cryptomatte", ".exr"});
  expect_failure(words({"--driver", "adaptive", "--unbiased"}), 2, {"--cryptomatte", "--unbiased"});
}

// ---- half, compression, parts

class LayersOption : public CommandTest {
 protected:
  Words words(const Words& more) {
    return render_words(
        Words{"--size", "40x30", "--crop", "3,5,37,28", "--spp", "4", "--aov", "N,albedo,Z"} +
        more);
  }
};

// From a multi-part file, our readers must read the same values as from a single-part file.
TEST_F(LayersOption, OwnReadersAcceptParts) {
  const Words frame = {"render", scene(), "--size", "40x30",       "--crop",        "3,5,37,28",
                       "--spp",  "4",     "--aov",  "N,denoising", "--cryptomatte", "object"};
  render(frame + Words{"-o", path("one.exr")});
  render(frame +
         Words{"-o", path("parts.exr"), "--exr-parts", "layers", "--exr-compression", "piz"});
  render({"denoise", path("one.exr"), "-o", path("a.exr"), "-o", path("a.png")});
  render({"denoise", path("parts.exr"), "-o", path("b.exr"), "-o", path("b.png")});
  EXPECT_EQ(read_bytes(path("a.png")), read_bytes(path("b.png")));
  const ExrPicture a = read_exr(path("a.exr")), b = read_exr(path("b.exr"));  // of the first part
  for (const char* channel : {"R", "G", "B", "A"}) {
    EXPECT_EQ(a.channels.at(channel), b.channels.at(channel)) << channel;
  }
  EXPECT_EQ(a.data, (Rect{3, 5, 37, 28}));
  EXPECT_EQ(a.display, (Rect{0, 0, 40, 30}));
  for (const auto& [name, value] : a.attributes) {
    if (name.starts_with("cryptomatte/")) {
      EXPECT_EQ(b.attributes.at(name), value);
    }
  }
  EXPECT_EQ(std::ranges::count_if(
                b.attributes,
                [](const auto& attribute) { return attribute.first.starts_with("cryptomatte/"); }),
            4);
  constexpr int kMultiPart = 0x10;  // a flag in the byte that follows the version
  EXPECT_EQ(int(read_bytes(path("a.exr"))[5]) & kMultiPart, 0);
  EXPECT_EQ(int(read_bytes(path("b.exr"))[5]) & kMultiPart, kMultiPart);
  const RunResult same = run({"compare", path("one.exr"), path("parts.exr"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(same.out)["mse"], 0.0) << same.describe();
  render({"heatmap", path("parts.exr"), "-o", path("map.png")});
}

TEST_F(LayersOption, DenoiseKeepsTheHalves) {
  render(words({"--aov", "denoising", "--half", "RGBA,N"}));
  render({"denoise", path("out.exr"), "-o", path("clean.exr")});
  const ExrPicture before = read_exr(path("out.exr")), after = read_exr(path("clean.exr"));
  for (const auto& [name, type] : before.types) EXPECT_EQ(after.types.at(name), type) << name;
  EXPECT_EQ(after.types.at("R"), "half");
  EXPECT_EQ(after.types.at("denoised.R"), "float");
}

TEST_F(LayersOption, HalfAppliesToTheNamedLayers) {
  render(words({"--half", "N,RGBA,Z"}));
  const ExrPicture half = read_exr(path("out.exr"));
  render(words({}));
  const ExrPicture whole = read_exr(path("out.exr"));
  for (const auto& [name, type] : half.types) {
    const bool named = !name.starts_with("albedo") && name != "samples";
    EXPECT_EQ(type == "half", named) << name;
    const std::vector<float>& values = whole.channels.at(name);
    for (size_t i = 0; i < values.size(); ++i) {
      const float least = std::min(values[i], 65504.0f), found = half.channels.at(name)[i];
      ASSERT_NEAR(found, least, named ? std::abs(least) / 2048 + 6e-8f : 0.0f) << name;
    }
  }
}

TEST_F(LayersOption, ResumedFrameMayChangeTheFileFormat) {
  const Words frame = {"render", scene(),  "-o",         path("out.exr"), "--size",
                       "40x30",  "--spp",  "4",          "--bucket-size", "8",
                       "--aov",  "albedo", "--resumable"};
  render(frame);
  const ExrPicture whole = read_exr(path("out.exr"));
  render(frame + Words{"--resume", "--exr-compression", "zips", "--half", "albedo"});
  const ExrPicture again = read_exr(path("out.exr"));
  EXPECT_EQ(again.channels.at("R"), whole.channels.at("R"));
  EXPECT_EQ(again.types.at("albedo.R"), "half");
}

TEST_F(LayersOption, RejectUnsupportedSettings) {
  expect_failure(words({"--half", "P"}), 2, {"--half P requires --aov P"});
  expect_failure(words({"--half", "id"}), 2,
                 {"--half", "id", "did you mean 'indirect', 'denoised' or 'light'?"});
  expect_failure(words({"--half", "light"}), 2, {"--half light requires --light-groups"});
  expect_failure(words({"--exr-compression", "lzw"}), 2, {"--exr-compression", "none, zips, zip"});
  expect_failure(words({"--exr-compression", "dwaa", "--cryptomatte", "object"}), 2,
                 {"--exr-compression dwaa", "--exr-parts layers"});
  expect_failure(words({"--exr-compression", "dwab", "--aov", "albedo,P"}), 2,
                 {"--exr-compression dwab", "--aov N", "--exr-parts layers"});
}

}  // namespace
}  // namespace emberline::test
