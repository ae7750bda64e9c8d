#include "renderer/core/memory_budget.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "renderer/core/errors.h"
#include "renderer/core/load_progress.h"

namespace emberline {
namespace {

std::string rejection_message(MemoryBudget& budget, MemoryPart part, uint64_t bytes) {
  try {
    budget.reserve(part, bytes, "scene.glb#/images/0");
  } catch (const InputError& error) {
    EXPECT_EQ(error.exit_code(), kExitInput);
    return error.what();
  }
  return "";
}

TEST(MemoryBudget, RefusalNamesTheOwnerAndTheAmount) {
  MemoryBudget budget(uint64_t(2) << 30);
  budget.reserve(MemoryPart::kFile, uint64_t(1) << 29, "scene.glb");
  EXPECT_EQ(
      rejection_message(budget, MemoryPart::kTextures, uint64_t(47) << 26),
      "scene.glb#/images/0: needs 2.94 GiB of memory (textures), but only 1.5 GiB of the limit of "
      "2 GiB is left; raise memory-limit");
  EXPECT_EQ(budget.reserved(), uint64_t(1) << 29) << "what is refused is not reserved";
  EXPECT_EQ(rejection_message(budget, MemoryPart::kTextures, uint64_t(3) << 29), "");
  EXPECT_NE(rejection_message(budget, MemoryPart::kBvh, 1), "");
  EXPECT_EQ(budget.reserved(MemoryPart::kTextures), uint64_t(3) << 29);
}

// The message tells how much was left when the request was refused, even if memory has been
// released since.
TEST(MemoryBudget, RefusalTellsWhatWasLeftThen) {
  MemoryBudget budget(2000);
  budget.reserve(MemoryPart::kBvh, 1900, "");
  uint64_t left = 0;
  EXPECT_FALSE(budget.try_reserve(MemoryPart::kBvh, 300, &left));
  budget.release(MemoryPart::kBvh, 1900);
  EXPECT_EQ(budget.limit_message(MemoryPart::kBvh, 300, left),
            "needs 300 B of memory (bvh), but only 100 B of the limit of 1.95 KiB is left; raise "
            "`memory-limit`");
}

TEST(MemoryBudget, RefusalShowsASmallDifference) {
  const MemoryBudget budget(uint64_t(1) << 30);
  EXPECT_NE(budget.limit_message(MemoryPart::kFilm, (5 << 20) + 1, 5 << 20)
                .find("needs 5,242,881 B of memory (film), but only 5,242,880 B of the limit of "
                      "1 GiB is left"),
            std::string::npos);
}

TEST(MemoryBudget, CountsThatOverflowAreTooMuch) {
  MemoryBudget budget(1000);
  budget.reserve(MemoryPart::kFile, 10, "");
  EXPECT_NE(rejection_message(budget, MemoryPart::kFile, UINT64_MAX - 5), "");
  EXPECT_EQ(bytes_of(uint64_t(1) << 40, uint64_t(1) << 30), UINT64_MAX);
  EXPECT_EQ(bytes_of(3, 7), 21u);
}

TEST(MemoryBudget, ReleasesTemporaryMemory) {
  const auto budget = std::make_shared<MemoryBudget>(1000);
  {
    MemoryReservation first(budget, MemoryPart::kFile, 600, "a");
    EXPECT_THROW(MemoryReservation(budget, MemoryPart::kFile, 600, "b"), InputError);
    EXPECT_THROW(first.add(401, "a"), InputError);
    MemoryReservation second(std::move(first));
    second.add(400, "a");
    EXPECT_EQ(budget->reserved(), 1000u);
  }
  EXPECT_EQ(budget->reserved(), 0u);
  EXPECT_EQ(budget->reserved(MemoryPart::kFile), 0u);
  EXPECT_EQ(budget->peak(), 1000u);
}

TEST(MemoryBudget, RestSharesTheLimitAndTracksItsUse) {
  MemoryBudget whole(1000);
  whole.reserve(MemoryPart::kGeometry, 300, "a.gltf");
  const std::shared_ptr<MemoryBudget> child_budget = whole.child_budget();
  EXPECT_EQ(child_budget->limit(), 1000u);
  EXPECT_EQ(child_budget->newly_reserved(), 0u);
  EXPECT_FALSE(child_budget->try_reserve(MemoryPart::kTextures, 701));
  EXPECT_TRUE(child_budget->try_reserve(MemoryPart::kTextures, 700));
  EXPECT_EQ(child_budget->newly_reserved(), 700u);
  EXPECT_EQ(whole.reserved(), 300u);
}

TEST(MemoryBudget, ThreadsTogetherStayWithinTheLimit) {
  const auto budget = std::make_shared<MemoryBudget>(1000);
  std::atomic<int> granted{0};
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 1000; ++i) granted += budget->try_reserve(MemoryPart::kBvh, 7);
      });
    }
  }
  EXPECT_EQ(granted, 1000 / 7);
  EXPECT_EQ(budget->reserved(), 994u);
}

TEST(MemoryBudget, UnlimitedRefusesNothing) {
  EXPECT_TRUE(MemoryBudget::unlimited()->try_reserve(MemoryPart::kFilm, UINT64_MAX));
  EXPECT_TRUE(MemoryBudget::unlimited()->try_reserve(MemoryPart::kFilm, UINT64_MAX));
  EXPECT_EQ(LoadProgress::none().budget(), MemoryBudget::unlimited());
}

TEST(LoadLimits, LoadEndsAtTheTimeout) {
  LoadLimits limits;
  limits.timeout_s = 0.01;
  limits.scene = "scene.glb";
  LoadProgress progress({}, {}, limits);
  progress.check();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(progress.should_stop());
  try {
    progress.begin(LoadStage::kMeshes);
    ADD_FAILURE() << "went on";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "scene.glb: loading took longer than 10 ms; raise load-timeout");
  }
}

}  // namespace
}  // namespace emberline
