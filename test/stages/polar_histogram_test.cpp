#include "ipm_mapping/stages/polar_histogram.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "support/pictures.hpp"
#include "support/views.hpp"

namespace ipm_mapping::test {
namespace {

Focus focusAt(double u, double v) { return {Eigen::Vector3d(u, v, 1.0)}; }
/// A focus behind the camera that shows at this pixel: the beam runs away from it.
Focus focusBehind(double u, double v) { return {Eigen::Vector3d(-u, -v, -1.0)}; }

/// Algorithm 2, in the octant for which it is printed (u0 < 0, v0 > 0; the focus is the origin),
/// mirrored for lines from the right. Answers image columns, row by row, without limits.
std::vector<long> algorithm2(long start_u, long focus_u, long focus_v, int rows) {
  long u0 = start_u - focus_u;
  const long v0 = std::labs(focus_v);
  const bool mirrored = u0 > 0;
  if (mirrored) u0 = -u0;
  long u = u0;
  const long dv = v0, du = -u0;
  long D = 2 * du - dv;
  std::vector<long> columns;
  for (int row = 0; row < rows; ++row) {
    if (D > 0) {
      u = u + 1;
      D = D + 2 * du - 2 * dv;
    } else {
      D = D + 2 * du;
    }
    const long moved = u - u0;
    // Towards the focus, or away from one that lies behind.
    const long step = (mirrored ? -moved : moved) * (focus_v < 0 ? -1 : 1);
    columns.push_back(start_u + step);
  }
  return columns;
}

void expectSourceLine(const PolarBeam& beam, int line, const std::vector<long>& columns,
                      int width) {
  for (int v = 0; v < beam.height(); ++v) {
    const bool drawn = v < static_cast<int>(columns.size());
    const long u = drawn ? columns[static_cast<std::size_t>(v)] : -1;
    const int expected = u >= 0 && u < width ? static_cast<int>(u) : PolarBeam::outside;
    ASSERT_EQ(beam.columns(line)[v], expected) << "line " << line << " row " << v;
  }
}

TEST(SourceBeam, FollowsAlgorithm2) {
  std::mt19937 random(20);
  for (int round = 0; round < 60; ++round) {
    const int focus_u = draw(random, -3000, 3000), focus_v = draw(random, 2, 6000);
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focusAt(focus_u, focus_v), 640, 480, 80, Beam::Source));
    ASSERT_EQ(beam.lines(), 80);
    for (int i = 0; i < 80; ++i)
      expectSourceLine(beam, i, algorithm2(8 * i + 4, focus_u, focus_v, std::min(480, focus_v)),
                       640);
  }
}

TEST(SourceBeam, RunsAwayFromAFocusBehindTheCamera) {
  PolarBeam beam;
  ASSERT_TRUE(beam.aim(focusBehind(300, -900), 640, 480, 80, Beam::Source));
  for (int i = 0; i < 80; ++i)
    expectSourceLine(beam, i, algorithm2(8 * i + 4, 300, -900, 480), 640);
  EXPECT_LT(beam.columns(15)[200], beam.columns(15)[0]);
  EXPECT_GT(beam.columns(65)[200], beam.columns(65)[0]);
}

TEST(SourceBeam, StandsUprightUnderALevelCamera) {
  // f_w of a level camera is zero but for rounding: no overflow, whatever the sign that is left.
  for (const double w : {0.0, 1e-17, -1e-17, 1e-300}) {
    PolarBeam beam;
    ASSERT_TRUE(beam.aim({Eigen::Vector3d(0, 500, w)}, 640, 480, 80, Beam::Source));
    for (int i = 0; i < 80; ++i) {
      EXPECT_EQ(beam.columns(i)[0], 8 * i + 4) << w;
      EXPECT_EQ(beam.columns(i)[479], 8 * i + 4) << w;
    }
  }
}

TEST(SourceBeam, ScalesItsStartsWithTheWidth) {
  PolarBeam beam;
  ASSERT_TRUE(beam.aim(focusAt(160, 1e6), 320, 240, 80, Beam::Source));
  EXPECT_EQ(beam.columns(0)[0], 2);
  EXPECT_EQ(beam.columns(79)[0], 79 * 4 + 2);
}

TEST(Beam, IsRefusedWhereTheFocusLeavesNoRow) {
  PolarBeam beam;
  for (const Beam kind : {Beam::FullView, Beam::Source}) {
    EXPECT_FALSE(beam.aim(focusAt(320, -5), 640, 480, 80, kind));
    EXPECT_FALSE(beam.aim(focusBehind(320, 700), 640, 480, 80, kind));
    EXPECT_FALSE(beam.aim({Eigen::Vector3d(1, 0, 0)}, 640, 480, 80, kind));
    EXPECT_FALSE(beam.aim({Eigen::Vector3d(0, NAN, 1)}, 640, 480, 80, kind));
  }
}

/// Focuses in front, far, at infinity and behind, below the picture.
std::vector<Focus> focuses() {
  return {focusAt(320, 700),      focusAt(310, 1400),         focusAt(-900, 2500),
          focusAt(320, 1e7),      {Eigen::Vector3d(0, 1, 0)}, {Eigen::Vector3d(0.2, 1, 0)},
          focusBehind(320, -800), focusBehind(500, -3000)};
}

TEST(FullViewBeam, HoldsOnePixelARowThatLiesOnTheLineToTheFocus) {
  for (const Focus& focus : focuses()) {
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focus, 640, 480, 80, Beam::FullView));
    for (int i = 0; i < 80; ++i) {
      // Any two pixels of a line lie within half a pixel of one line through the focus: the
      // interval of starting columns that explains all of them is not empty.
      double low = -1e9, high = 1e9;
      for (int v = 0; v < 480; ++v) {
        const int u = beam.columns(i)[v];
        if (u == PolarBeam::outside) continue;
        // Column on row 0 of the line through (u -+ 0.5, v) and the focus.
        const auto start = [&](double column) {
          const Eigen::Vector2d d = focus.direction(column, v);
          return column - v * d.x() / d.y();
        };
        low = std::max(low, start(u - 0.5));
        high = std::min(high, start(u + 0.5));
      }
      EXPECT_LE(low, high + 1e-6) << "line " << i;
    }
  }
}

TEST(FullViewBeam, ReachesTheUpperAndLowerCorners) {
  for (const Focus& focus : focuses()) {
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focus, 640, 480, 200, Beam::FullView));
    for (const int v : {0, 479}) {
      int leftmost = 640, rightmost = -1;
      for (int i = 0; i < 200; ++i) {
        const int u = beam.columns(i)[v];
        if (u == PolarBeam::outside) continue;
        leftmost = std::min(leftmost, u);
        rightmost = std::max(rightmost, u);
      }
      // Within one spacing of the lines of the corner.
      EXPECT_LE(leftmost, 12) << v;
      EXPECT_GE(rightmost, 639 - 12) << v;
    }
  }
}

TEST(FullViewBeam, IsOrderedFromTheLeftAndEvenlySpaced) {
  for (const Focus& focus : focuses()) {
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focus, 640, 480, 80, Beam::FullView));
    for (const int v : {0, 240, 479}) {
      std::vector<int> columns;
      for (int i = 0; i < 80; ++i)
        if (beam.columns(i)[v] != PolarBeam::outside) columns.push_back(beam.columns(i)[v]);
      ASSERT_GT(columns.size(), 20U);
      const int spacing = columns[1] - columns[0];
      EXPECT_GT(spacing, 0);
      for (std::size_t k = 1; k < columns.size(); ++k)
        EXPECT_NEAR(columns[k] - columns[k - 1], spacing, 1) << "row " << v;
    }
  }
}

TEST(FullViewBeam, IsParallelAtInfinityAndDivergesFromAFocusBehind) {
  const auto spread = [](const Focus& focus, int v) {
    PolarBeam beam;
    EXPECT_TRUE(beam.aim(focus, 640, 480, 80, Beam::FullView));
    return beam.columns(45)[v] - beam.columns(35)[v];
  };
  const Focus infinity{Eigen::Vector3d(0, 1, 0)};
  EXPECT_EQ(spread(infinity, 0), spread(infinity, 479));
  EXPECT_GT(spread(focusBehind(320, -800), 479), spread(focusBehind(320, -800), 0));
  EXPECT_LT(spread(focusAt(320, 800), 479), spread(focusAt(320, 800), 0));
}

TEST(FullViewBeam, EndsAtAFocusInsideThePicture) {
  // A camera that looks steeply down: the focus may fall between two rows or on one.
  for (const double v_focus : {300.0, 300.0001, 300.5}) {
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focusAt(320, v_focus), 640, 480, 80, Beam::FullView));
    int lines_in_view = 0;
    for (int i = 0; i < 80; ++i) {
      int rows = 0;
      for (int v = 0; v < 480; ++v) rows += beam.columns(i)[v] != PolarBeam::outside;
      lines_in_view += rows > 0;
      EXPECT_EQ(beam.columns(i)[301], PolarBeam::outside);
    }
    EXPECT_GT(lines_in_view, 60) << v_focus;
  }
}

TEST(PolarHistogram, CountsWhatTheLinesMeet) {
  std::mt19937 random(21);
  for (const Beam kind : {Beam::FullView, Beam::Source}) {
    for (const Focus& focus : focuses()) {
      PolarBeam beam;
      ASSERT_TRUE(beam.aim(focus, 200, 150, 80, kind));
      Picture picture(200, 150);
      constexpr std::array<std::uint8_t, 3> values{mask::floor, mask::unseen, mask::obstacle};
      for (int v = 0; v < 150; ++v)
        for (int u = 0; u < 200; ++u)
          picture(u, v) = values[static_cast<std::size_t>(draw(random, 0, 2))];
      PolarHistogram histogram;
      beam.sample(picture.view());
      histogram.count(beam);
      for (int i = 0; i < 80; ++i) {
        int obstacle = 0, seen = 0;
        for (int v = 0; v < 150; ++v) {
          const int u = beam.columns(i)[v];
          if (u < 0) continue;
          obstacle += picture(u, v) == mask::obstacle;
          seen += picture(u, v) != mask::unseen;
        }
        ASSERT_EQ(histogram.obstacle[static_cast<std::size_t>(i)], obstacle);
        ASSERT_EQ(histogram.seen[static_cast<std::size_t>(i)], seen);
      }
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::test
