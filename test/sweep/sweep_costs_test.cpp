// Floor cost, specular cost and vertical sweep on a rendered pair of views, against slow versions
// that go through the camera model point by point.

#include <gtest/gtest.h>

#include <algorithm>

#include "ipm_mapping/sweep/specular_cost.hpp"
#include "sweep/sweep_fixture.hpp"

namespace ipm_mapping::sweep {
namespace {

class Costs : public ::testing::Test {
 protected:
  void SetUp() override {
    scene.boxes = {{0.95, 1.25, -0.12, 0.22, 0.4}};
    p.evidence.search_step = 1;
    p.evidence.least_vertical_cost = 0.0;
    p.evidence.rival_share = 0.0;
    const CameraModel& camera = scene.camera;
    grid = makePolarGrid(camera, scene.T_base_camera, p.grid, 2.0);
    rectification.configure(camera, scene.T_base_camera, grid);
    noise.configure(grid, rectification.ranges(), p.noise);
    sweep.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support,
                    p.evidence);
    floor_cost.configure(grid, rectification.ranges(), p.evidence);
    now.resize(grid.rows, grid.lines);
    before.resize(grid.rows, grid.lines);
    rectification.rectify(scene.render(motion).view(), now.view());
    rectification.rectify(scene.render(SE2{}).view(), before.view());
    for (Image<std::int16_t>* plane : {&grey, &unused, &even, &odd})
      plane->resize(grid.sweepRows(), grid.lines);
    weight.resize(grid.sweepRows(), grid.lines);
    cost.resize(grid.sweepRows(), sweep.beams());
    const Photometric same;
    for (int line = 0; line < grid.lines; ++line) {
      kernels::splitRows(now.row(line), same.fixedGain(), 0, grid.sweepRows(), grey.row(line),
                         unused.row(line));
      kernels::splitRows(before.row(line), same.fixedGain(), 0, grid.sweepRows(), even.row(line),
                         odd.row(line));
    }
    noise.evaluate(grey.view(), unused.view(), weight.view());
    current = {grey.view(), weight.view(), &noise.sweepRows()};
    floor_cost.evaluate(current, before.view(), foot_motion, same, cost.view());
    reference = {even.view(), odd.view(), cost.view(), foot_motion};
  }
  [[nodiscard]] double boxDistance(int beam) const {
    // the front face x = 0.95 in odom, seen from the foot
    const Eigen::Vector2d foot = scene.T_base_camera.translation().head<2>();
    return (0.95 - motion.x - foot.x()) / std::cos(sweep.azimuth(beam));
  }
  [[nodiscard]] bool facesBox(int beam) const {
    const double y = boxDistance(beam) * std::sin(sweep.azimuth(beam)) - 0.01;
    return y > -0.07 && y < 0.17;
  }
  /// The brightness of upright surfaces may change from here on.
  void allowForBrightness() {
    now_sums.configure(grid.sweepRows(), grid.lines, p.evidence.beam_step);
    before_sums.configure(grid.sweepRows(), grid.lines);
    now_sums.evaluate(grey.view());
    before_sums.evaluate(even.view());
    current.sums = now_sums.view();
    reference.sums = before_sums.view();
  }
  /// Grey level of the reference between pixels of the polar grid; false outside the view.
  [[nodiscard]] bool sample(const Eigen::Vector2d& p, double r_factor, double& value) const {
    const double row = grid.row(p.norm() * r_factor), line = grid.line(std::atan2(p.y(), p.x()));
    if (line < 0 || line >= grid.lines - 1 || row < 0 || row >= grid.rows - 1) return false;
    const int l = static_cast<int>(line), j = static_cast<int>(row);
    const RowRange seen = intersection(rectification.rows(l), rectification.rows(l + 1));
    if (j < seen.begin || j + 1 >= seen.end) return false;
    const double a = row - j, b = line - l;
    value = (1 - b) * ((1 - a) * before.at(j, l) + a * before.at(j + 1, l)) +
            b * ((1 - a) * before.at(j, l + 1) + a * before.at(j + 1, l + 1));
    return true;
  }
  [[nodiscard]] static double capped(double e, double weight) {
    // the datapath drops what is below a sixteenth of a standard deviation
    const double t = std::floor(16.0 * std::min(std::abs(e) * weight / 32768.0, 3.0)) / 16.0;
    return t * t;
  }

  SweepParameters p = test::smallParameters();
  test::GrainedScene scene{test::smallCamera(), test::smallCameraPose()};
  const SE2 motion{0.16, 0.01, 0.04};
  const FootMotion foot_motion{motion, Eigen::Vector2d(0.05, -0.01)};
  PolarGrid grid;
  CylindricalRectification rectification;
  NoiseModel noise;
  FloorCost floor_cost;
  VerticalSweep sweep;
  Image<std::uint8_t> now, before;
  Image<std::int16_t> grey, unused, even, odd;
  Image<std::uint16_t> weight, cost;
  BeamSums now_sums, before_sums;
  CurrentView current;
  SweepReference reference;
};

TEST_F(Costs, ResidualIsTheFloorWarpedPointByPoint) {
  int compared = 0;
  for (int line = 2; line < grid.lines - 2; line += 3) {
    for (int j = 3; j < grid.sweepRows() - 3; j += 5) {
      const std::int16_t got = floor_cost.residual().at(j, line);
      if (got == kernels::no_residual) continue;
      const double az = grid.azimuth(line), d = grid.distance(2 * j);
      double value = 0.0;
      ASSERT_TRUE(
          sample(foot_motion * (d * Eigen::Vector2d(std::cos(az), std::sin(az))), 1.0, value));
      EXPECT_NEAR(got / 32.0, now.at(2 * j, line) - value, 1.5) << line << ' ' << j;
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

/// Mean residual around a pixel, of those that are there.
int meanAround(const PolarGrid& grid, ImageView<const std::int16_t> residual,
               const EvidenceParameters& p, int row, int line) {
  const auto half_lines = static_cast<int>(std::lround(p.drift_width / 2 * grid.lines_per_radian));
  const auto half_rows = static_cast<int>(std::lround(p.drift_length / 4 * grid.rows_per_log));
  int sum = 0, number = 0;
  for (int l = std::max(0, line - half_lines); l <= std::min(grid.lines - 1, line + half_lines);
       ++l)
    for (int j = std::max(0, row - half_rows); j <= std::min(grid.sweepRows() - 1, row + half_rows);
         ++j)
      if (residual.at(j, l) != kernels::no_residual) sum += residual.at(j, l), ++number;
  return static_cast<int>(static_cast<float>(sum) / static_cast<float>(std::max(number, 1)));
}

/// A camera that looks down steeply and a robot that reverses: near floor lies behind the
/// reference.
TEST(FloorCostBackwards, OnlyWhatTheReferenceSeesIsCompared) {
  const SweepParameters p = test::smallParameters();
  const CameraModel camera(Intrinsics{160, 120, 131.0, 131.0, 79.5, 59.5}, {});
  const CameraPose T_base_camera = cameraPose(0.05, 0.0, 0.45, 0.9);
  const PolarGrid grid = makePolarGrid(camera, T_base_camera, p.grid, 2.0);
  CylindricalRectification rectification;
  rectification.configure(camera, T_base_camera, grid);
  const std::vector<RowRange>& seen = rectification.ranges();
  std::vector<RowRange> rows = seen;
  for (RowRange& range : rows) range = {(range.begin + 1) / 2, range.end / 2};
  VerticalSweep sweep;
  sweep.configure(grid, seen, rows, p.grid.max_support, p.evidence);
  FloorCost floor_cost;
  floor_cost.configure(grid, seen, p.evidence);
  const Image<std::int16_t> grey(grid.sweepRows(), grid.lines, std::int16_t{3200});
  const Image<std::uint16_t> weight(grid.sweepRows(), grid.lines, std::uint16_t{20000});
  const Image<std::uint8_t> before(grid.rows, grid.lines, std::uint8_t{100});
  Image<std::uint16_t> cost(grid.sweepRows(), sweep.beams());
  for (const SE2& motion : {SE2{-0.4, 0.0, 0.0}, SE2{-0.3, 0.02, 0.1}, SE2{-0.7, 0.0, -0.3}}) {
    const FootMotion foot_motion{motion, Eigen::Vector2d(0.05, 0.0)};
    floor_cost.evaluate({grey.view(), weight.view(), &rows}, before.view(), foot_motion, {},
                        cost.view());
    for (int line = 0; line < grid.lines; ++line) {
      for (int j = 0; j < grid.sweepRows(); ++j) {
        if (floor_cost.residual().at(j, line) == kernels::no_residual) continue;
        const double az = grid.azimuth(line), d = grid.distance(2 * j);
        const Eigen::Vector2d q = foot_motion * (d * Eigen::Vector2d(std::cos(az), std::sin(az)));
        const double there = grid.line(std::atan2(q.y(), q.x()));
        ASSERT_GE(there, -1.0) << j << ' ' << line;
        ASSERT_LE(there, grid.lines) << j << ' ' << line;
        const RowRange rows_there =
            seen[static_cast<std::size_t>(std::clamp(there, 0.0, grid.lines - 1.0))];
        ASSERT_GE(grid.row(q.norm()), rows_there.begin - 8.0) << j << ' ' << line;
        ASSERT_LE(grid.row(q.norm()), rows_there.end + 8.0) << j << ' ' << line;
      }
    }
  }
}

TEST_F(Costs, FloorCostIsTheSumOverTheLinesOfABeamOrNone) {
  const ImageView<const std::int16_t> residual = floor_cost.residual();
  int compared = 0, missing = 0;
  for (int beam = 0; beam < sweep.beams(); beam += 5) {
    for (int j = 0; j < grid.sweepRows(); j += 3) {
      int expected = 0;
      for (int line = sweep.firstLine(beam); line < sweep.firstLine(beam) + 8; ++line) {
        const int e = residual.at(j, line);
        if (e == kernels::no_residual) expected = kernels::no_cost;
        if (expected == kernels::no_cost) break;
        const int rest = e - meanAround(grid, residual, p.evidence, j, line);
        const int t = std::min(std::abs(e), std::abs(rest)) * weight.at(j, line) >> 16;
        expected += std::min(t, kernels::deviation_cap) * std::min(t, kernels::deviation_cap);
      }
      ASSERT_EQ(cost.at(j, beam), expected) << beam << ' ' << j;
      ++(expected == kernels::no_cost ? missing : compared);
    }
  }
  EXPECT_GT(compared, 200);
  EXPECT_GT(missing, 200);
}

/// A reference that sees less than the view, as one does without its sway.
TEST_F(Costs, NothingIsComparedThatTheReferenceDoesNotSee) {
  Image<std::int16_t> all(grid.sweepRows(), grid.lines);
  for (int line = 0; line < grid.lines; ++line)
    std::copy_n(floor_cost.residual().row(line), grid.sweepRows(), all.row(line));
  std::vector<RowRange> fewer = rectification.ranges();
  for (RowRange& rows : fewer) rows.begin = std::max(rows.begin, grid.rows / 3);
  floor_cost.evaluate(current, before.view(), foot_motion, {}, cost.view(), &fewer);
  int kept = 0, left_out = 0;
  for (int line = 0; line < grid.lines; ++line) {
    for (int j = 0; j < grid.sweepRows(); ++j) {
      if (all.at(j, line) == kernels::no_residual) continue;
      const double az = grid.azimuth(line), d = grid.distance(2 * j);
      const Eigen::Vector2d p = foot_motion * (d * Eigen::Vector2d(std::cos(az), std::sin(az)));
      const double below = grid.row(p.norm()) - grid.rows / 3;
      const bool compared = floor_cost.residual().at(j, line) != kernels::no_residual;
      (compared ? kept : left_out) += 1;
      if (std::abs(below) > 1.5) {
        EXPECT_EQ(compared, below > 0.0) << j << ' ' << line;
      }
    }
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(left_out, 1000);

  SweepScores scores;
  sweep.evaluate(current, &reference, 1, 0.0F, scores);
  const float most = *std::max_element(scores.score.row(0), scores.score.row(sweep.beams()));
  const std::vector<RowRange> none(static_cast<std::size_t>(grid.lines));
  reference.rows = &none;
  sweep.evaluate(current, &reference, 1, 0.0F, scores);
  EXPECT_GT(most, 10.0F);
  EXPECT_EQ(*std::max_element(scores.score.row(0), scores.score.row(sweep.beams())), 0.0F);
}

TEST_F(Costs, FloorIsCheapAndTheBoxIsNot) {
  double on_floor = 0, on_box = 0;
  int floor_rows = 0, box_rows = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    if (!facesBox(beam)) continue;
    const int contact = static_cast<int>(grid.row(boxDistance(beam))) / 2;
    for (int j = contact + 4; j < sweep.rows(beam).end; ++j)
      if (cost.at(j, beam) != kernels::no_cost) on_floor += cost.at(j, beam), ++floor_rows;
    for (int j = contact - 30; j < contact - 4; ++j)
      if (cost.at(j, beam) != kernels::no_cost) on_box += cost.at(j, beam), ++box_rows;
  }
  ASSERT_GT(floor_rows, 100);
  ASSERT_GT(box_rows, 100);
  EXPECT_LT(on_floor / floor_rows, 0.6 * kernels::cost_unit);
  EXPECT_GT(on_box / box_rows, 2.0 * on_floor / floor_rows);
}
/// The definition of the score, in floating point, one candidate at a time.
/// Score of a candidate by the definition: rows and lines through the polar grid, one by one.
class Definition : public Costs {
 protected:
  struct Row {
    int j;
    std::array<double, 8> difference;
  };
  /// What the rows of a support, from its contact upwards, differ by from the reference.
  [[nodiscard]] std::vector<Row> support(int beam, int c) const {
    const int contact = static_cast<int>(sweep.sweepRow(c));
    const double d = sweep.distance(c), az = sweep.azimuth(beam);
    const Eigen::Vector2d place = foot_motion * (d * Eigen::Vector2d(std::cos(az), std::sin(az)));
    const double first_line = grid.line(std::atan2(place.y(), place.x())) - 3.5;
    const int reach =
        static_cast<int>(std::lround(-std::log(1 - p.grid.max_support) * p.grid.rows_per_log / 2));
    std::vector<Row> rows;
    for (int j = std::min(contact, sweep.rows(beam).end - 1);
         j >= std::max(contact - reach, sweep.rows(beam).begin); --j) {
      Row row{j, {}};
      bool seen = true;
      for (int k = 0; k < 8; ++k) {
        // the same height on the line, seen from the reference
        const double az_ref = grid.azimuth(first_line + k);
        const double r_ref = grid.r(2 * j) * d / place.norm();
        double value = 0.0;
        seen &= sample((grid.height / r_ref) * Eigen::Vector2d(std::cos(az_ref), std::sin(az_ref)),
                       1.0, value);
        row.difference[static_cast<std::size_t>(k)] =
            now.at(2 * j, sweep.firstLine(beam) + k) - value;
      }
      if (seen) rows.push_back(row);
    }
    return rows;
  }
  /// Mean difference of the lower part of a support.
  [[nodiscard]] double brighter(const std::vector<Row>& rows, int contact) const {
    const int reach = static_cast<int>(
        std::lround(-std::log(1 - p.evidence.brightness_support) * p.grid.rows_per_log / 2));
    double sum = 0.0;
    int number = 0;
    for (const Row& row : rows) {
      if (row.j >= contact || row.j < contact - reach) continue;
      for (const double difference : row.difference) sum += difference, ++number;
    }
    const double most = p.evidence.vertical_brightness;
    return number > 32 ? std::clamp(sum / number, -most, most) : 0.0;
  }
  [[nodiscard]] double score(int beam, int c, bool brightness) const {
    const std::vector<Row> rows = support(beam, c);
    const double change = brightness ? brighter(rows, static_cast<int>(sweep.sweepRow(c))) : 0.0;
    double sum = 0.0, best = 0.0;
    for (const Row& row : rows) {
      if (cost.at(row.j, beam) == kernels::no_cost) continue;
      double vertical = 0.0;
      for (int k = 0; k < 8; ++k)
        vertical += capped(row.difference[static_cast<std::size_t>(k)] - change,
                           weight.at(row.j, sweep.firstLine(beam) + k)) /
                    8;
      const double floor =
          std::min(cost.at(row.j, beam) / double{kernels::cost_unit}, p.evidence.floor_cap);
      sum += (floor - vertical - p.evidence.vertical_prior) * p.evidence.evidence_rows *
             grid.r(2 * row.j) * 2 / p.grid.rows_per_log;
      best = std::max(best, sum);
    }
    return best;
  }
  /// Score of a level surface that begins at a row above a candidate: at height z on row j it is
  /// (h - z) / r away. Sums end at the best row.
  [[nodiscard]] double levelScore(int beam, int c, int begin) const {
    const double az = sweep.azimuth(beam), below_camera = grid.r(2 * begin) * sweep.distance(c);
    const int reach =
        static_cast<int>(std::lround(-std::log(1 - p.grid.max_support) * p.grid.rows_per_log / 2));
    const int highest =
        std::max({static_cast<int>(sweep.sweepRow(c)) - reach, sweep.rows(beam).begin, begin - c});
    double sum = 0.0, best = 0.0;
    for (int j = begin - 1; j >= highest; --j) {
      const double d = below_camera / grid.r(2 * j);
      const Eigen::Vector2d place = foot_motion * (d * Eigen::Vector2d(std::cos(az), std::sin(az)));
      const double first_line = grid.line(std::atan2(place.y(), place.x())) - 3.5;
      double vertical = 0.0;
      bool seen = cost.at(j, beam) != kernels::no_cost;
      for (int k = 0; k < 8; ++k) {
        const double az_ref = grid.azimuth(first_line + k), r_ref = below_camera / place.norm();
        double value = 0.0;
        seen &= sample((grid.height / r_ref) * Eigen::Vector2d(std::cos(az_ref), std::sin(az_ref)),
                       1.0, value);
        const int line = sweep.firstLine(beam) + k;
        vertical += capped(now.at(2 * j, line) - value, weight.at(j, line)) / 8;
      }
      if (!seen) continue;
      const double floor =
          std::min(cost.at(j, beam) / double{kernels::cost_unit}, p.evidence.floor_cap);
      sum += (floor - vertical - p.evidence.vertical_prior) * p.evidence.evidence_rows *
             grid.r(2 * j) * 2 / p.grid.rows_per_log;
      best = std::max(best, sum);
    }
    return best;
  }
  void compare(bool brightness) {
    SweepScores scores;
    sweep.evaluate(current, &reference, 1, 0.0F, scores);
    int compared = 0;
    for (int beam = 3; beam < sweep.beams(); beam += 4) {
      for (int c = 10; c < sweep.candidates(); c += 9) {
        const double best = score(beam, c, brightness);
        EXPECT_NEAR(scores.score.at(c, beam), best, 1.5 + 0.04 * best) << beam << ' ' << c;
        ++compared;
      }
    }
    EXPECT_GT(compared, 100);
  }
};

TEST_F(Definition, GivesTheScores) { compare(false); }

TEST_F(Definition, GivesTheScoresOfLevelTops) {
  int compared = 0;
  double most = 0.0;
  for (int beam = 3; beam < sweep.beams(); beam += 4) {
    for (int c = 10; c < sweep.candidates(); c += 9) {
      for (const int up : {4, 9, 30}) {
        const int begin = static_cast<int>(sweep.sweepRow(c)) - up;
        const double expected = levelScore(beam, c, begin);
        std::int16_t top = 0;
        sweep.offered(&reference, 1, beam, c);
        sweep.aimBeam(current, &reference, 1, beam);
        const float score = sweep.levelScore(&reference, 1, beam, c, begin, 0.0F, top);
        EXPECT_NEAR(score, expected, 1.5 + 0.04 * expected) << beam << ' ' << c << ' ' << up;
        EXPECT_LE(top, begin);
        most = std::max(most, expected);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(most, 10.0);
}

TEST_F(Definition, GivesThoseOfSurfacesThatMayHaveBecomeBrighter) {
  allowForBrightness();
  compare(true);
}

TEST_F(Costs, OnlyASmallChangeOfBrightnessIsTheSameSurface) {
  const auto best = [&](double levels) {
    const auto change = static_cast<std::int16_t>(std::lround(levels * kernels::grey_unit));
    for (int line = 0; line < grid.lines; ++line)
      for (int row = 0; row < grid.sweepRows(); ++row) {
        even.at(row, line) = static_cast<std::int16_t>(even.at(row, line) - change);
        odd.at(row, line) = static_cast<std::int16_t>(odd.at(row, line) - change);
      }
    if (!reference.sums.empty()) allowForBrightness();
    SweepScores scores;
    sweep.evaluate(current, &reference, 1, 0.0F, scores);
    float sum = 0.0F;
    for (int beam = 0; beam < sweep.beams(); ++beam)
      if (facesBox(beam))
        sum +=
            *std::max_element(scores.score.row(beam), scores.score.row(beam) + sweep.candidates());
    return sum;
  };
  const float same = best(0.0), taken_as_it_is = best(1.0);
  allowForBrightness();
  const float allowed = best(0.0), too_much = best(3.0);
  EXPECT_LT(taken_as_it_is, 0.97F * same);
  EXPECT_GT(allowed, 1.01F * taken_as_it_is);
  EXPECT_LT(too_much, 0.8F * allowed);
}

TEST_F(Costs, StoppingEarlyLosesNothing) {
  SweepScores all, most;
  sweep.evaluate(current, &reference, 1, 0.0F, all);
  sweep.evaluate(current, &reference, 1, 8.0F, most);
  int strong = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    for (int c = 0; c < sweep.candidates(); ++c) {
      if (all.score.at(c, beam) < 8.0F) {
        EXPECT_LT(most.score.at(c, beam), 8.0F);
        continue;
      }
      EXPECT_EQ(most.score.at(c, beam), all.score.at(c, beam)) << beam << ' ' << c;
      EXPECT_EQ(most.top.at(c, beam), all.top.at(c, beam));
      ++strong;
    }
  }
  EXPECT_GT(strong, 50);
}

TEST_F(Costs, OnlyWhatFallsFarBehindANearerCandidateIsLeftOut) {
  SweepScores all, some;
  sweep.evaluate(current, &reference, 1, 4.0F, all);
  p.evidence.rival_share = 0.6;
  VerticalSweep hurried;
  hurried.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support,
                    p.evidence);
  hurried.evaluate(current, &reference, 1, 4.0F, some);
  int left_out = 0, strong = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    float nearer = 0.0F;
    for (int c = sweep.candidates() - 1; c >= 0; --c) {
      const float whole = all.score.at(c, beam), got = some.score.at(c, beam);
      if (whole >= 0.6F * nearer) {
        ASSERT_EQ(got, whole) << beam << ' ' << c;
        strong += whole > 8.0F;
      } else {
        ASSERT_TRUE(got == whole || got == 0.0F);
        left_out += got != whole;
      }
      nearer = std::max(nearer, whole);
    }
  }
  EXPECT_GT(strong, 50);
  EXPECT_GT(left_out, 20);
}

TEST_F(Costs, ExpectingEveryVerticalLineToCostSomethingKeepsTheBestCandidates) {
  const auto scoresExpecting = [&](double least_vertical_cost) {
    p.evidence.least_vertical_cost = least_vertical_cost;
    VerticalSweep expecting;
    expecting.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support,
                        p.evidence);
    SweepScores scores;
    expecting.evaluate(current, &reference, 1, 4.0F, scores);
    return scores;
  };
  const SweepScores all = scoresExpecting(0.0);
  const SweepScores some = scoresExpecting(SweepParameters{}.evidence.least_vertical_cost);
  const SweepScores too_much = scoresExpecting(p.evidence.floor_cap);
  int beams_with_contact = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const float* a = all.score.row(beam);
    const auto best = std::max_element(a, a + sweep.candidates()) - a;
    if (a[best] < 8.0F) continue;
    EXPECT_EQ(some.score.row(beam)[best], a[best]) << beam;
    EXPECT_EQ(too_much.score.row(beam)[best], 0.0F) << beam;
    ++beams_with_contact;
  }
  EXPECT_GT(beams_with_contact, 4);
}

TEST_F(Costs, SearchingInStepsFindsTheSameMaxima) {
  SweepScores every, stepped;
  sweep.evaluate(current, &reference, 1, 4.0F, every);
  p.evidence.search_step = 2;
  VerticalSweep coarse;
  coarse.configure(grid, rectification.ranges(), noise.sweepRows(), p.grid.max_support, p.evidence);
  coarse.evaluate(current, &reference, 1, 4.0F, stepped);
  int strong = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    const float* a = every.score.row(beam);
    const float* b = stepped.score.row(beam);
    const auto best = std::max_element(a, a + sweep.candidates()) - a;
    if (a[best] < 8.0F) continue;
    EXPECT_EQ(std::max_element(b, b + sweep.candidates()) - b, best) << beam;
    EXPECT_EQ(b[best], a[best]);
    EXPECT_EQ(stepped.top.at(static_cast<int>(best), beam),
              every.top.at(static_cast<int>(best), beam));
    ++strong;
  }
  EXPECT_GT(strong, 4);
}

TEST_F(Costs, TheBestCandidateOfABeamThatFacesTheBoxIsItsContact) {
  SweepScores scores;
  sweep.evaluate(current, &reference, 1, 0.0F, scores);
  int facing = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam) {
    if (!facesBox(beam)) continue;
    const float* s = scores.score.row(beam);
    const auto best = std::max_element(s, s + sweep.candidates()) - s;
    EXPECT_NEAR(sweep.distance(static_cast<double>(best)), boxDistance(beam), 0.025) << beam;
    ++facing;
  }
  EXPECT_GT(facing, 4);
}

TEST_F(Costs, AStaticViewIsExplainedAndAMovingFloorIsNot) {
  SpecularCost specular;
  p.evidence.specular_parallax = 0.0;
  specular.configure(grid, rectification.ranges(), p.evidence);
  Image<std::uint16_t> lowered = cost;
  SweepReference still = reference;
  Image<std::int16_t> still_odd = unused;
  still.even = grey.view();  // the reference shows exactly what is seen now
  still.odd = still_odd.view();
  specular.apply(current, sweep, still, 0.0, lowered.view());
  const auto prior = static_cast<int>(std::lround(p.evidence.specular_prior * kernels::cost_unit));
  int lower = 0;
  for (int beam = 0; beam < sweep.beams(); ++beam)
    for (int j = sweep.rows(beam).begin; j < sweep.rows(beam).end; ++j) {
      if (lowered.at(j, beam) == kernels::no_cost) continue;
      EXPECT_LE(lowered.at(j, beam), std::max<int>(prior, 0));
      lower += lowered.at(j, beam) < cost.at(j, beam);
    }
  EXPECT_GT(lower, 100);
}

}  // namespace
}  // namespace ipm_mapping::sweep
