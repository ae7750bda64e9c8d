// The groups that the material panel offers, and their order.
#include "renderer/window/panels/material_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "renderer/description/material_parameters.h"

namespace emberline {
namespace {

std::vector<std::string> names(const MaterialDescription& own, const MaterialEdit& edit = {}) {
  std::vector<std::string> result;
  for (const MaterialGroup* group : offered_groups(own, edit)) result.emplace_back(group->name);
  return result;
}

TEST(MaterialRows, EveryParameterHasOneWithinItsRange) {
  std::multiset<std::string_view> shown;
  for (const MaterialGroup& group : material_groups()) {
    for (const MaterialRow& row : group.rows) {
      shown.insert(row.parameter);
      const MaterialParameter& p = material_parameter(row.parameter);
      EXPECT_EQ(p.name, row.parameter);
      EXPECT_GE(double(row.least), p.least) << row.parameter;
      EXPECT_LE(double(row.most), p.most) << row.parameter;
    }
  }
  EXPECT_EQ(shown.size(), material_parameters().size());
  for (const MaterialParameter& p : material_parameters())
    EXPECT_EQ(shown.count(p.name), 1u) << p.name;
}

TEST(MaterialRows, UsedParametersComeFirst) {
  MaterialDescription own;
  EXPECT_EQ(names(own), (std::vector<std::string>{"", "Clear Coat", "Sheen", "Iridescence",
                                                  "Diffuse Transmission", "Reflection"}));
  own.sheen_color = Rgb(0.5f);
  own.ior = 1.4f;
  own.thin_walled = false;
  EXPECT_EQ(names(own),
            (std::vector<std::string>{"", "Sheen", "Interior", "Reflection", "Clear Coat",
                                      "Iridescence", "Diffuse Transmission"}));
  // An edit does not change the order.
  MaterialEdit edit;
  edit.clearcoat = 1.0f;
  EXPECT_EQ(names(own, edit), names(own));
  const auto groups = offered_groups(own, edit);
  EXPECT_TRUE(groups[4]->edited(edit));
  EXPECT_FALSE(groups[1]->edited(edit));
}

TEST(MaterialRows, AnisotropyIsOfferedIfThereAreTangents) {
  const auto offers = [](const std::vector<std::string>& groups) {
    return std::ranges::find(groups, "Anisotropy") != groups.end();
  };
  MaterialDescription own;
  EXPECT_FALSE(offers(names(own)));
  MaterialEdit edit;  // the scene was opened with it
  edit.anisotropy = 0.5f;
  EXPECT_TRUE(offers(names(own, edit)));
  own.normal_texture.image = 0;
  EXPECT_TRUE(offers(names(own)));
}

}  // namespace
}  // namespace emberline
