// Case E13: ambient occlusion beside a wall. Cosine-weighted directions, projected onto the floor,
// fill the unit disc uniformly. A wall at distance d blocks the segment of the disc beyond d / r,
// where r is the occlusion distance.
#include "receiver.h"

namespace emberline {
namespace {

using namespace test;

TEST(AmbientOcclusion, BesideAWall) {
  SceneBuilderForTests b;
  const int grey = b.add_material(lambert(Rgb(.5f)));
  b.add_floor(5, 0, grey);
  b.add_quad({0, 0, 5}, {0, 0, -5}, {0, 5, -5}, {0, 5, 5}, grey);  // faces +X
  b.set_environment(Rgb(1.0f));
  const auto scene = b.build();
  const double reach = .2 * double(scene->radius()) / scene->scale();
  EXPECT_GT(reach, 1.2);
  EXPECT_LT(reach, 4.9);
  for (const double d : {1e-3, .3, .75, 1.2, 2 * reach}) {
    const CaseName name = {"E13", "ambient occlusion " + format_value(d) + " from a wall, reach " +
                                      format_value(reach)};
    RenderSettings s = direct_light_settings(1024);
    s.integrator = "ambient_occlusion";
    s.seed = seed_of(name);
    const double k = std::min(1.0, d / reach);
    const double blocked = (std::acos(k) - k * std::sqrt(1 - k * k)) / kPiD;
    // The view's centre lies off the diagonal between the floor's two triangles.
    const RenderedImage image = render(*scene, orthographic({d, .1, .7}, {d, 0, .7}, 1e-5), s);
    // The tolerance is needed since the view extends 1e-5 to either side of d, where the segment's
    // chord is at most 2.
    expect_case(name, compared(image, 1 - blocked, 1e-6 + 1e-5 * (d < .01)), replay(s));
  }
}

}  // namespace
}  // namespace emberline
