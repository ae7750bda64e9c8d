// Tests the display of an unfinished frame. The tests fill the frame by hand, and compare the
// display with a slow search for the nearest pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "renderer/drivers/bisection_driver.h"
#include "renderer/drivers/bisection_picture.h"
#include "renderer/film/channels.h"
#include "renderer/film/film.h"

namespace emberline {
namespace {

PartShape shape_of(BisectionAxis axis) {
  return axis == BisectionAxis::kRows      ? PartShape::kRow
         : axis == BisectionAxis::kColumns ? PartShape::kColumn
                                           : PartShape::kSquare;
}

// A frame whose first pass is partly done. `value` gives each sampled pixel its value.
class Unfinished {
 public:
  using Value = float (*)(int x, int y);

  Unfinished(const Rect& crop, BisectionAxis axis, Reconstruction reconstruction, Value value)
      : crop_(crop),
        steps_(bisection_steps(crop.width(), crop.height(), axis)),
        pass_(steps_, crop, {0, 1}, shape_of(axis), 4),
        film_(AovSet{}),
        reconstruction_(reconstruction),
        value_(value) {
    film_.reset(crop);
  }

  // Samples the first `parts` parts. Of the last `partial` parts among them, samples only every
  // other pixel.
  void sample(size_t parts, size_t partial = 0) {
    std::vector<PixelWork> list;
    for (size_t part = 0; part < parts; ++part) {
      list.clear();
      pass_.expand(part, list);
      for (size_t i = 0; i < list.size(); ++i) {
        if (part + partial >= parts && i % 2 == 1) continue;
        const PixelWork& w = list[i];
        film_.add(w.x, w.y, {{Rgb(value_(w.x, w.y)), 1.0f, {}, {}}, 1.0f, 0});
      }
    }
    size_t step = parts - partial == pass_.parts() ? steps_.size() : pass_.step_of(parts - partial);
    const size_t first = pass_.first_part(step);
    coverage_ = {step, parts - partial - first, parts - first};
  }

  std::vector<float> resolve() const {
    std::vector<float> rgba(4 * size_t(crop_.area()), std::numeric_limits<float>::quiet_NaN());
    BisectionPicture{steps_, pass_, film_, reconstruction_, coverage_}.resolve(rgba);
    return rgba;
  }
  float shown(const std::vector<float>& rgba, int x, int y) const {
    return rgba[4 * (size_t(y - crop_.y0) * size_t(crop_.width()) + size_t(x - crop_.x0))];
  }
  bool sampled(int x, int y) const { return film_.sample_count(x, y) > 0; }

  const Rect crop_;
  const std::vector<BisectionStep> steps_;
  const BisectionPass pass_;
  FilmTile film_;
  const Reconstruction reconstruction_;
  BisectionCoverage coverage_;
  Value value_;
};

float number(int x, int y) { return float(1 + x + 1000 * y); }

const Rect kPictureWindows[] = {{0, 0, 37, 29}, {5, 9, 118, 40}, {0, 0, 1, 97},
                                {3, 5, 98, 6},  {0, 0, 1, 1},    {2, 2, 130, 66}};

// Along one axis, a pixel shows the nearest sampled pixel of its column (or row). If two are
// equally near, it shows the lower one.
TEST(BisectionPicture, LinesShowTheNearest) {
  for (const bool rows : {true, false}) {
    for (const Rect& crop : kPictureWindows) {
      const BisectionAxis axis = rows ? BisectionAxis::kRows : BisectionAxis::kColumns;
      const size_t parts = Unfinished(crop, axis, Reconstruction::kDuplicate, number).pass_.parts();
      for (size_t done = 1; done <= parts; done += 1 + done / 3) {
        Unfinished frame(crop, axis, Reconstruction::kDuplicate, number);
        frame.sample(done);
        // Within the first line no complete line exists yet.
        if (done < frame.pass_.first_part(1)) continue;
        const std::vector<float> rgba = frame.resolve();
        const int size = rows ? crop.height() : crop.width();
        for (int y = crop.y0; y < crop.y1; ++y) {
          for (int x = crop.x0; x < crop.x1; ++x) {
            float nearest = -1;
            for (int d = 0; d < size && nearest < 0; ++d) {
              for (const int line : {-d, d}) {
                const int sx = rows ? x : x + line, sy = rows ? y + line : y;
                if (!crop.contains(sx, sy) || !frame.sampled(sx, sy)) continue;
                nearest = number(sx, sy);
                break;
              }
            }
            ASSERT_EQ(frame.shown(rgba, x, y), nearest)
                << x << "," << y << " after " << done << " of " << parts << " parts";
          }
        }
      }
    }
  }
}

// After a complete step, a pixel shows the pixel where the nearest sampled column and the nearest
// sampled row cross.
TEST(BisectionPicture, ALatticeShowsTheNearestColumnAndRow) {
  const auto nearest = [](const std::vector<int>& lines, int at) {
    int best = lines.front();
    for (const int line : lines) {
      if (std::abs(line - at) < std::abs(best - at)) best = line;
    }
    return best;
  };
  for (const Rect& crop : kPictureWindows) {
    const auto steps = bisection_steps(crop.width(), crop.height(), BisectionAxis::kBoth);
    for (size_t step = 0; step < steps.size(); ++step) {
      Unfinished frame(crop, BisectionAxis::kBoth, Reconstruction::kDuplicate, number);
      frame.sample(frame.pass_.first_part(step + 1));
      const std::vector<float> rgba = frame.resolve();
      for (int y = crop.y0; y < crop.y1; ++y) {
        for (int x = crop.x0; x < crop.x1; ++x) {
          const int sx = crop.x0 + nearest(steps[step].complete.columns, x - crop.x0);
          const int sy = crop.y0 + nearest(steps[step].complete.rows, y - crop.y0);
          ASSERT_EQ(frame.shown(rgba, x, y), number(sx, sy)) << x << "," << y << " step " << step;
        }
      }
    }
  }
}

// At whatever moment the frame is stopped, each pixel shows the value of a sampled pixel. A pixel
// that has samples shows its own value.
TEST(BisectionPicture, IsCompleteAtEveryMoment) {
  for (const NamedValue<BisectionAxis>& axis : bisection_axis_table()) {
    for (const Rect& crop : kPictureWindows) {
      const size_t parts =
          Unfinished(crop, axis.value, Reconstruction::kDuplicate, number).pass_.parts();
      for (size_t done = 1; done <= parts; done += 1 + done / 4) {
        for (const size_t partial : {size_t(0), size_t(1), done / 2, done}) {
          Unfinished frame(crop, axis.value, Reconstruction::kDuplicate, number);
          // A round lies within one step, and so do its partial parts.
          if (frame.pass_.step_of(done - 1) !=
              frame.pass_.step_of(std::min(done - partial, done - 1))) {
            continue;
          }
          frame.sample(done, partial);
          const std::vector<float> rgba = frame.resolve();
          for (int y = crop.y0; y < crop.y1; ++y) {
            for (int x = crop.x0; x < crop.x1; ++x) {
              const int shown = int(frame.shown(rgba, x, y)) - 1;
              const int sx = shown % 1000, sy = shown / 1000;
              ASSERT_TRUE(crop.contains(sx, sy) && frame.sampled(sx, sy))
                  << axis.name << ": " << x << "," << y << " shows " << sx << "," << sy;
              if (frame.sampled(x, y)) {
                ASSERT_TRUE(sx == x && sy == y);
              }
            }
          }
        }
      }
    }
  }
}

// The display reproduces a ramp between the outermost sampled lines, and continues it flat beyond
// them.
TEST(BisectionPicture, LinearBlendsAreExactForARamp) {
  const auto ramp = [](int x, int y) { return 1.0f + 0.25f * float(x) + 2.0f * float(y); };
  for (const NamedValue<BisectionAxis>& axis : bisection_axis_table()) {
    for (const Rect& crop : kPictureWindows) {
      const auto steps = bisection_steps(crop.width(), crop.height(), axis.value);
      for (size_t step = 0; step < steps.size(); ++step) {
        Unfinished frame(crop, axis.value, Reconstruction::kLinear, ramp);
        frame.sample(frame.pass_.first_part(step + 1));
        const std::vector<float> rgba = frame.resolve();
        const PixelLattice& lattice = steps[step].complete;
        for (int y = crop.y0; y < crop.y1; ++y) {
          for (int x = crop.x0; x < crop.x1; ++x) {
            const int cx =
                crop.x0 + std::clamp(x - crop.x0, lattice.columns.front(), lattice.columns.back());
            const int cy =
                crop.y0 + std::clamp(y - crop.y0, lattice.rows.front(), lattice.rows.back());
            ASSERT_NEAR(frame.shown(rgba, x, y), ramp(cx, cy), 1e-4f * ramp(cx, cy))
                << axis.name << ": " << x << "," << y << " step " << step;
          }
        }
      }
    }
  }
}

// In the middle of a step, a sampled pixel shows its own value. The other pixels stay within the
// range of the samples.
TEST(BisectionPicture, LinearIsCompleteAtEveryMoment) {
  for (const NamedValue<BisectionAxis>& axis : bisection_axis_table()) {
    const Rect crop{5, 9, 118, 40};
    const size_t parts =
        Unfinished(crop, axis.value, Reconstruction::kLinear, number).pass_.parts();
    for (size_t done = 1; done <= parts; done += 1 + done / 4) {
      Unfinished frame(crop, axis.value, Reconstruction::kLinear, number);
      frame.sample(done, 1);
      const std::vector<float> rgba = frame.resolve();
      for (int y = crop.y0; y < crop.y1; ++y) {
        for (int x = crop.x0; x < crop.x1; ++x) {
          const float shown = frame.shown(rgba, x, y);
          if (frame.sampled(x, y)) {
            ASSERT_EQ(shown, number(x, y));
          }
          ASSERT_GE(shown, number(5, 9));
          ASSERT_LE(shown, number(117, 39));
        }
      }
    }
  }
}

TEST(BisectionPicture, IsBlackWithoutSamples) {
  const Unfinished frame({0, 0, 9, 5}, BisectionAxis::kBoth, Reconstruction::kDuplicate, number);
  for (const float v : frame.resolve()) EXPECT_EQ(v, 0.0f);
}

TEST(BlendLines, TiesGoToTheLowerLine) {
  const auto nearest = blend_lines(std::vector<int>{1, 5}, 8, Reconstruction::kDuplicate);
  const int expected[] = {1, 1, 1, 1, 5, 5, 5, 5};  // 3 is as near to 1 as to 5
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(nearest[size_t(i)].lower, expected[i]) << i;
    EXPECT_EQ(nearest[size_t(i)].upper, expected[i]) << i;
  }
  const auto linear = blend_lines(std::vector<int>{1, 5}, 8, Reconstruction::kLinear);
  EXPECT_EQ(linear[2].lower, 1);
  EXPECT_EQ(linear[2].upper, 5);
  EXPECT_FLOAT_EQ(linear[2].weight, 0.25f);
  EXPECT_EQ(linear[0].upper, 1);
  EXPECT_EQ(linear[5].lower, 5);
  EXPECT_EQ(linear[5].upper, 5);
  EXPECT_EQ(linear[7].lower, 5);
}

}  // namespace
}  // namespace emberline
