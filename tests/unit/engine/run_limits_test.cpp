#include "renderer/engine/run_limits.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support/temp_folder.h"

namespace emberline::test {
namespace {

namespace fs = std::filesystem;

class CgroupMemoryLimit : public testing::Test {
 protected:
  void set(const std::string& file, const std::string& limit) const {
    const fs::path path = fs::path(folder_ / file);
    fs::create_directories(path.parent_path());
    std::ofstream(path) << limit << "\n";
  }
  std::optional<uint64_t> limit(const std::string& groups) const {
    return cgroup_memory_limit(groups, folder_ / "");
  }
  TempFolder folder_;
};

TEST_F(CgroupMemoryLimit, IsTheLeastOnTheWayUp) {
  set("user/session/memory.max", "max");
  set("user/memory.max", "3000");
  set("memory.max", "9000");
  EXPECT_EQ(limit("0::/user/session\n"), 3000u);
  set("user/session/memory.max", "2000");
  EXPECT_EQ(limit("0::/user/session\n"), 2000u);
  EXPECT_EQ(limit("0::/\n"), 9000u);
}

TEST_F(CgroupMemoryLimit, VersionOneHasItsOwnMount) {
  set("memory/memory.limit_in_bytes", "9223372036854771712");
  set("memory/docker/1a2b/memory.limit_in_bytes", "5000");
  const std::string groups = "12:cpu,cpuacct:/docker/1a2b\n3:memory:/docker/1a2b\n0::/system\n";
  EXPECT_EQ(limit(groups), 5000u);
  // In a container the host's path does not exist, and the top-level limit counts.
  set("memory/memory.limit_in_bytes", "4000");
  EXPECT_EQ(limit("3:memory:/elsewhere\n"), 4000u);
}

TEST_F(CgroupMemoryLimit, NoGroupMeansNoLimit) {
  EXPECT_EQ(limit(""), std::nullopt);
  EXPECT_EQ(limit("0::/user\n"), std::nullopt);
  EXPECT_EQ(limit("nonsense\n:\n::\n"), std::nullopt);
}

TEST(RunLimits, DefaultIsOfThisMachine) {
  const uint64_t limit = default_memory_limit();
  EXPECT_GT(limit, uint64_t(64) << 20);
  EXPECT_LT(limit, uint64_t(1) << 50);
  EXPECT_EQ(limits_of({}, "scene.glb").memory->limit(), limit);
  EXPECT_EQ(limits_of({.memory_bytes = 5, .load_timeout_s = {}}, "scene.glb").memory->limit(), 5u);
}

}  // namespace
}  // namespace emberline::test
