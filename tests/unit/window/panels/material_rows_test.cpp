// Tests the groups that the material panel offers, and their order.
#include "renderer/window/panels/material_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

std::vector<std::string> names(const MaterialDescription& original, const MaterialEdit& edit = {}) {
  std::vector<std::string> result;
  for (const MaterialGroup* group : applicable_groups(original, edit))
    result.emplace_back(group->name);
  return result;
}

TEST(MaterialRows, EveryParameterHasOneWithinItsRange) {
  std::multiset<std::string_view> shown;
  for (const MaterialGroup& group : material_groups()) {
    for (const MaterialRow& row : group.rows) {
      shown.insert(row.parameter);
      const MaterialParameter& p = material_parameter(row.parameter);
      EXPECT_EQ(p.name, row.parameter);
      EXPECT_GE(double(row.minimum), p.minimum) << row.parameter;
      EXPECT_LE(double(row.maximum), p.maximum) << row.parameter;
    }
  }
  EXPECT_EQ(shown.size(), material_parameters().size());
  for (const MaterialParameter& p : material_parameters())
    EXPECT_EQ(shown.count(p.name), 1u) << p.name;
}

TEST(MaterialRows, UsedParametersComeFirst) {
  MaterialDescription original;
  EXPECT_EQ(names(original), (std::vector<std::string>{"", "Clear Coat", "Sheen", "Iridescence",
                                                       "Diffuse Transmission", "Reflection"}));
  original.sheen_color = Rgb(0.5f);
  original.ior = 1.4f;
  original.thin_walled = false;
  EXPECT_EQ(names(original),
            (std::vector<std::string>{"", "Sheen", "Interior", "Reflection", "Clear Coat",
                                      "Iridescence", "Diffuse Transmission"}));
  // An edit does not change the order.
  MaterialEdit edit;
  edit.clearcoat = 1.0f;
  EXPECT_EQ(names(original, edit), names(original));
  const auto groups = applicable_groups(original, edit);
  EXPECT_TRUE(groups[4]->edited(edit));
  EXPECT_FALSE(groups[1]->edited(edit));
}

TEST(MaterialRows, AnisotropyIsOfferedIfThereAreTangents) {
  const auto offers = [](const std::vector<std::string>& groups) {
    return std::ranges::find(groups, "Anisotropy") != groups.end();
  };
  MaterialDescription original;
  EXPECT_FALSE(offers(names(original)));
  MaterialEdit edit;  // the scene was opened with it
  edit.anisotropy = 0.5f;
  EXPECT_TRUE(offers(names(original, edit)));
  original.normal_texture.image = 0;
  EXPECT_TRUE(offers(names(original)));
}

}  // namespace
}  // namespace emberline
