// A truncated file, or a file with changed bytes, may only result in an InputError or a scene.
#include <nlohmann/json.hpp>
#include <random>

#include "failure/bad_input.h"
#include "renderer/core/log.h"
#include "support/dense_gltf.h"
#include "support/scene_validation.h"

namespace emberline {
namespace {

using test::dense_gltf;
using test::GltfBuilder;
using test::TempFolder;

// Returns true if the file loads, and false if it is rejected with an InputError. Any other
// exception escapes and fails the test.
bool loads_or_rejects(const std::string& path, bool lenient) {
  try {
    EXPECT_EQ(test::find_scene_violation(load_gltf(path, {lenient})), "");
    return true;
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    return false;
  }
}

class Mutated : public testing::Test {
 protected:
  Mutated() { set_log_level(LogLevel::kQuiet); }
  ~Mutated() override { set_log_level(LogLevel::kNormal); }
  TempFolder folder_;
};

TEST_F(Mutated, TheSceneItselfIsSound) {
  EXPECT_TRUE(loads_or_rejects(dense_gltf().write_glb(folder_ / "a.glb"), false));
  EXPECT_TRUE(loads_or_rejects(dense_gltf().write_embedded(folder_ / "a.gltf"), false));
}

TEST_F(Mutated, EveryPrefixOfAGlb) {
  const std::vector<uint8_t> whole = dense_gltf().glb();
  for (size_t size = 0; size < whole.size(); ++size) {
    test::write_bytes(folder_ / "a.glb", whole.data(), size);
    EXPECT_FALSE(loads_or_rejects(folder_ / "a.glb", false))
        << size << " bytes of " << whole.size();
  }
}

// The file is truncated, but the header's length is corrected. So the container is valid and its
// contents are not.
TEST_F(Mutated, EveryPrefixOfAGlbWithAnHonestHeader) {
  const std::vector<uint8_t> whole = dense_gltf().glb();
  for (size_t size = 20; size < whole.size(); ++size) {
    std::vector<uint8_t> bytes(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    for (int i = 0; i < 4; ++i) bytes[8 + size_t(i)] = uint8_t(size >> (8 * i));
    test::write_bytes(folder_ / "a.glb", bytes);
    loads_or_rejects(folder_ / "a.glb", true);
  }
}

// Makes one to four changes. The generator is seeded with the round, so that a failure can be
// replayed.
void mutate(std::vector<uint8_t>& bytes, uint32_t round) {
  std::mt19937 random(round);
  const uint32_t changes = 1 + random() % 4;
  for (uint32_t i = 0; i < changes && !bytes.empty(); ++i) {
    const size_t at = random() % bytes.size();
    switch (random() % 5) {
      case 0:
        bytes[at] = uint8_t(random());
        break;
      case 1:
        bytes[at] ^= uint8_t(1u << random() % 8);
        break;
      case 2:
        bytes[at] = uint8_t("0123456789-.,:[]{}\"e"[random() % 20]);
        break;
      case 3:
        bytes.erase(bytes.begin() + std::ptrdiff_t(at));
        break;
      default:
        bytes.insert(bytes.begin() + std::ptrdiff_t(at), uint8_t(random()));
        break;
    }
  }
}

TEST_F(Mutated, SeededMutationsOfAGlb) {
  const std::vector<uint8_t> whole = dense_gltf().glb();
  for (uint32_t round = 0; round < 4000; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    std::vector<uint8_t> bytes = whole;
    mutate(bytes, round);
    test::write_bytes(folder_ / "a.glb", bytes);
    loads_or_rejects(folder_ / "a.glb", round % 2 == 0);
    if (HasFatalFailure()) return;
  }
}

TEST_F(Mutated, SeededMutationsOfAGltf) {
  const GltfBuilder gltf = dense_gltf();
  const std::string text = gltf.document("data.bin").dump();
  gltf.write_gltf(folder_ / "whole.gltf");
  for (uint32_t round = 0; round < 4000; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    std::vector<uint8_t> bytes(text.begin(), text.end());
    mutate(bytes, round + 1000000);
    test::write_bytes(folder_ / "a.gltf", bytes);
    loads_or_rejects(folder_ / "a.gltf", round % 2 == 0);
    if (HasFatalFailure()) return;
  }
}

// Appends the JSON pointer of each number in `value` to `found`.
void collect_numbers(const nlohmann::json& value, const std::string& pointer,
                     std::vector<std::string>& found) {
  if (value.is_number()) found.push_back(pointer);
  if (!value.is_structured()) return;
  for (const auto& [key, member] : value.items()) {
    collect_numbers(member, pointer + "/" + key, found);
  }
}

TEST_F(Mutated, EveryNumberReplaced) {
  const GltfBuilder gltf = dense_gltf();
  const nlohmann::json whole = gltf.document("data.bin");
  gltf.write_gltf(folder_ / "whole.gltf");
  std::vector<std::string> pointers;
  collect_numbers(whole, "", pointers);
  ASSERT_GT(pointers.size(), 100u);
  for (const std::string& pointer : pointers) {
    for (const double value :
         {-1.0, 0.0, 1.0, 2.0, 5.0, 255.0, 1e9, 4294967295.0, 1e18, 1e38, 0.5}) {
      SCOPED_TRACE(pointer + " = " + std::to_string(value));
      nlohmann::json document = whole;
      nlohmann::json& number = document[nlohmann::json::json_pointer(pointer)];
      if (value == std::floor(value) && std::abs(value) < 1e19) {
        number = int64_t(value);
      } else {
        number = value;
      }
      test::write_text(folder_ / "a.gltf", document.dump());
      loads_or_rejects(folder_ / "a.gltf", true);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace emberline
