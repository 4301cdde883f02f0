#include "ipm_mapping/detectors/word_length_study.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>
#include <utility>

namespace ipm_mapping {
namespace {

/// A noisy floor with dark blobs on it, seen twice without any relation: contacts everywhere.
struct Pair {
  Image<std::uint8_t> reference, current;
  fpga::ExplorerInput input;

  explicit Pair(unsigned seed) {
    paint(reference, 2 * seed);
    paint(current, 2 * seed + 1);
    input.view.camera = CameraModel({320, 240, 260, 260, 159.5, 119.5}, {0.1, -0.2, 0, 0, 0.05});
    input.view.T_base_camera = cameraPose(0.05, 0.0, 0.4, 0.42);
    input.view.T_odom_base = {0.1 * seed, 0.02 * seed, 0.05 * seed};
    input.view.motion = {0.1, 0.0, 0.02};
    input.reference = std::as_const(reference).view();
    input.current = std::as_const(current).view();
    input.threshold_in = 40;
  }

 private:
  static void paint(Image<std::uint8_t>& image, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> noise(120, 140), u0(0, 300), v0(0, 200), size(8, 50);
    image.resize(320, 240);
    for (int v = 0; v < 240; ++v)
      for (int u = 0; u < 320; ++u) image.at(u, v) = static_cast<std::uint8_t>(noise(random));
    for (int blob = 0; blob < 8; ++blob) {
      const int left = u0(random), top = v0(random), side = size(random);
      for (int v = top; v < std::min(240, top + side); ++v)
        for (int u = left; u < std::min(320, left + side); ++u) image.at(u, v) = 30;
    }
  }
};

TEST(WordLengthStudy, ASinglePairsRowIsItsOwnResult) {
  const Pair pair(1);
  WordLengthStudy study(Parameters{}, fpga::ExploredWire::HomographyLinear, 8, 11);
  const auto results = study.add(pair.input);
  const auto rows = study.rows();
  ASSERT_EQ(results.size(), 4U);
  ASSERT_EQ(rows.size(), 4U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].fraction_bits, results[i].fraction_bits);
    EXPECT_EQ(rows[i].pairs, results[i].usable ? 1 : 0);
    EXPECT_EQ(rows[i].median_error, results[i].median_error);
    EXPECT_EQ(rows[i].worst_error, results[i].worst_error);
    EXPECT_EQ(rows[i].changed_mask, results[i].changed_mask);
    EXPECT_EQ(rows[i].points, results[i].points);
    EXPECT_EQ(rows[i].lost_points, results[i].lost_points);
  }
}

TEST(WordLengthStudy, RowsGatherThePairs) {
  WordLengthStudy study(Parameters{}, fpga::ExploredWire::Normalized, 12, 12);
  int points = 0, masks = 0;
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Pair pair(seed);
    const auto results = study.add(pair.input);
    ASSERT_EQ(results.size(), 1U);
    points += results[0].points;
    masks += results[0].changed_mask;
    worst = std::max(worst, results[0].worst_error);
  }
  const auto rows = study.rows();
  EXPECT_EQ(rows[0].pairs, 3);
  EXPECT_EQ(rows[0].points, points);
  EXPECT_NEAR(rows[0].changed_mask, masks / 3.0, 1e-9);
  EXPECT_EQ(rows[0].worst_error, worst);
}

TEST(WordLengthStudy, TheMapHoldsThePointsOfLongWordsAndDiffersWhereShortWordsMoveThem) {
  Parameters parameters;
  parameters.map.resolution = 0.02;
  parameters.localization.max_range = 20.0;
  WordLengthStudy rough(parameters, fpga::ExploredWire::HomographyLinear, 6, 7);
  WordLengthStudy fine(parameters, fpga::ExploredWire::Intrinsic, 19, 20);
  int ideal_points = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Pair pair(seed);
    const auto results = rough.add(pair.input);
    ASSERT_FALSE(results.empty());
    ideal_points += results[0].ideal.size;
    fine.add(pair.input);
  }
  ASSERT_GT(ideal_points, 0);
  const auto rough_rows = rough.rows(), fine_rows = fine.rows();
  EXPECT_GT(rough_rows[0].map_cells, 0);
  EXPECT_LE(rough_rows[0].map_cells, ideal_points);
  EXPECT_EQ(rough_rows[0].map_cells, fine_rows[0].map_cells);
  EXPECT_GT(rough_rows[0].changed_cells, 0);
  EXPECT_LE(fine_rows[1].changed_cells, rough_rows[0].changed_cells);
}

TEST(WordLengthStudy, APairThatCannotBeSetUpIsLeftOut) {
  Pair pair(1);
  pair.input.view.motion = {0.0, 0.0, 3.0};  // looks the other way
  WordLengthStudy study(Parameters{}, fpga::ExploredWire::Lens, 10, 11);
  EXPECT_TRUE(study.add(pair.input).empty());
  for (const WordLengthRow& row : study.rows()) EXPECT_EQ(row.pairs, 0);
}

TEST(WordLengthStudy, TheTableHasOneLineARow) {
  WordLengthRow row;
  row.fraction_bits = 9;
  row.changed_cells = 3;
  const std::string text = wordLengthCsv(fpga::ExploredWire::Lens, {row, row});
  std::istringstream lines(text);
  std::string header, first;
  std::getline(lines, header);
  std::getline(lines, first);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','),
            std::count(first.begin(), first.end(), ','));
  EXPECT_EQ(first.rfind("lens,9,", 0), 0U);
  EXPECT_EQ(first.substr(first.rfind(',')), ",3");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
}

}  // namespace
}  // namespace ipm_mapping
