#include "renderer/engine/setting_table.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>

#include "renderer/core/errors.h"
#include "renderer/core/names.h"
#include "renderer/scene/embree_isa.h"
#include "support/gltf_builder.h"
#include "support/temp_folder.h"
#include "unit/setting_values.h"

namespace emberline {
namespace {

const std::map<std::string, std::string>& kNonDefaults = test::non_default_values();

FrameSettings all_non_default() {
  FrameSettings settings;
  for (const Setting& setting : setting_table())
    setting.read(settings, kNonDefaults.at(setting.name));
  return settings;
}

// Does not compile if FrameSettings gets a new member. Give the member a row in the table, or list
// it here.
TEST(SettingTable, HasEveryMember) {
  const FrameSettings settings;
  const auto& [scene, resource_root, driver, integrator, sampler, filter, filter_radius, spp,
               min_spp, max_spp, noise_threshold, estimator, allocation, unbiased, judge,
               time_limit_s, time_budget_s, max_depth, clamp_indirect, light_samples, seed,
               static_noise, streams, bucket_size, bucket_order, bisection_axis, reconstruction,
               width, height, crop, camera, look_from, look_at, fov_y, f_stop, focus_distance,
               panorama, turntable, turntable_center, animation, time, frame, fps, shutter, edits,
               variant, environment, sun, environment_strength, environment_rotation,
               environment_sampling, guiding, transparent, working_space, show_backfaces, lenient,
               isa, part, sample_range, plan, aovs, cryptomattes, cryptomatte_levels, catchers,
               holdouts, catcher_plane, light_groups, half, exr_compression, exr_parts, denoise] =
      settings;
  constexpr size_t kMembers = 71;
  // Every member has a row except the scene, and width and height share one.
  EXPECT_EQ(setting_table().size(), kMembers - 2);
  EXPECT_EQ(kNonDefaults.size(), setting_table().size());
  EXPECT_TRUE(scene.empty());
}

TEST(SettingTable, NamesAreThereOnce) {
  std::set<std::string> names;
  for (const Setting& setting : setting_table()) {
    EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
    EXPECT_TRUE(setting.help.full.ends_with('.')) << setting.name;
    EXPECT_LE(setting.help.brief.size(), 70u) << setting.name;
    // A default is stated once, either by the text of the value or in words.
    EXPECT_TRUE(setting.help.fallback.empty() || setting.text(FrameSettings()).empty())
        << setting.name;
  }
}

TEST(SettingTable, ATextGivesTheSameValue) {
  const FrameSettings settings = all_non_default();
  const FrameSettings defaults;
  for (const Setting& setting : setting_table()) {
    EXPECT_EQ(setting.text(settings), kNonDefaults.at(setting.name));
    EXPECT_NE(setting.text(settings), setting.text(defaults)) << setting.name;
    FrameSettings again;
    setting.read(again, setting.text(settings));
    EXPECT_EQ(setting.text(again), setting.text(settings));
    const bool any_text = setting.file || setting.type.starts_with("NAME|INDEX");
    if (!any_text) {
      EXPECT_THROW(setting.read(again, "x\ty"), UsageError) << setting.name;
    }
  }
}

TEST(SettingTable, ErrorsListTheValidValues) {
  const auto message = [](std::string_view name, std::string_view text) -> std::string {
    FrameSettings settings;
    try {
      find_named(setting_table(), "`settings`", "setting", name).read(settings, text);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message("bucket-order", "hilbet"),
            "bucket-order: unknown order 'hilbet' (did you mean 'hilbert'?); valid names are "
            "hilbert, spiral, scanline, random");
  EXPECT_EQ(message("bisection-axis", "row"),
            "bisection-axis: unknown axis 'row' (did you mean 'rows'?); valid names are rows, "
            "columns, both");
  EXPECT_EQ(message("reconstruction", "cubic"),
            "reconstruction: unknown reconstruction 'cubic'; valid names are duplicate, linear");
  EXPECT_EQ(message("allocation", "rmse"),
            "allocation: unknown allocation 'rmse' (did you mean 'mse'?); valid names are "
            "display, mse, relmse");
  for (const char* size : {"0", "5000"}) {
    EXPECT_EQ(message("bucket-size", size),
              "bucket-size: '" + std::string(size) + "' is not a whole number from 1 to 4096");
  }
}

TEST(SettingTable, AFileGivesTheSameSettings) {
  const test::TempFolder folder;
  const std::string path = folder / "look.json";
  const FrameSettings settings = all_non_default();
  std::ofstream(path) << settings_json(settings, path);
  FrameSettings read;
  read_settings(path, read);
  // Paths in the file are relative to it and are resolved when they are read.
  for (const Setting& setting : setting_table()) {
    const std::string text = setting.text(read);
    if (!setting.file) {
      EXPECT_EQ(text, setting.text(settings)) << setting.name;
    } else {
      EXPECT_EQ(std::filesystem::weakly_canonical(text), setting.text(settings)) << setting.name;
    }
  }
  EXPECT_EQ(settings_json(FrameSettings(), path), "{}\n");
}

TEST(SettingTable, GroupsAndFilesCanBeQueried) {
  const FrameSettings settings = all_non_default();
  EXPECT_EQ(setting_texts(settings, {SettingGroup::kSeed}), (SettingTexts{{"seed", "4294967295"}}));
  EXPECT_EQ(setting_texts(settings, {SettingGroup::kLoading}, false),
            (SettingTexts{{"animation", "Survey"},
                          {"time", "-0.1"},
                          {"frame", "12.5"},
                          {"fps", "23.976"},
                          {"shutter", "-0.25,0.25"},
                          {"lenient", "yes"}}));
  EXPECT_EQ(setting_texts(FrameSettings(), {SettingGroup::kLoading}), SettingTexts());
}

}  // namespace
}  // namespace emberline
