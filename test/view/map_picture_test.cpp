#include "ipm_mapping/view/map_picture.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgproc.hpp>

namespace ipm_mapping {
namespace {

/// Colours of the legend, as hue tests that survive antialiasing.
bool isOccupied(const cv::Vec3b& p) { return p == cv::Vec3b(0x45, 0x36, 0x26); }
bool isTruth(const cv::Vec3b& p) { return p[2] > 200 && p[1] < 90 && p[0] < 90; }
bool isPath(const cv::Vec3b& p) { return p[0] > 190 && p[2] < 90; }
bool isStart(const cv::Vec3b& p) { return p == cv::Vec3b(0x5B, 0x9E, 0x2E); }

struct Found {
  int count = 0;
  double u = 0.0, v = 0.0;  ///< centre
};
/// Pixels of the picture above the legend that satisfy `is`.
Found find(const cv::Mat& image, bool (*is)(const cv::Vec3b&)) {
  Found found;
  for (int v = 56; v < image.rows - 112; ++v)
    for (int u = 0; u < image.cols; ++u)
      if (is(image.at<cv::Vec3b>(v, u))) ++found.count, found.u += u, found.v += v;
  if (found.count > 0) found.u /= found.count, found.v /= found.count;
  return found;
}

TrinaryMap freeMap(int width, int height) {
  TrinaryMap map;
  map.origin_x = -1.0;
  map.origin_y = -0.5;
  map.width = width;
  map.height = height;
  map.cells.assign(static_cast<std::size_t>(width * height), 0);
  return map;
}
std::int8_t& cell(TrinaryMap& map, int x, int y) {
  return map.cells[static_cast<std::size_t>(y * map.width + x)];
}

TEST(MapPicture, AnOccupiedCellIsADarkSquareAtItsPlace) {
  TrinaryMap low = freeMap(40, 20), high = low, right = low;
  cell(low, 10, 5) = 100;
  cell(high, 10, 15) = 100;
  cell(right, 30, 5) = 100;
  const Found a = find(drawMap(low, {}), isOccupied), b = find(drawMap(high, {}), isOccupied),
              c = find(drawMap(right, {}), isOccupied);
  const double side = std::sqrt(a.count);
  EXPECT_GT(side, 8.0);
  EXPECT_EQ(a.count, b.count);
  EXPECT_NEAR(a.v - b.v, 10.0 * side, 15.0) << "y points up";
  EXPECT_NEAR(a.u, b.u, 0.01);
  EXPECT_NEAR(c.u - a.u, 20.0 * side, 30.0) << "x points right";
}

TEST(MapPicture, IsCroppedToWhatIsKnown) {
  TrinaryMap map = freeMap(30, 20);
  cell(map, 3, 4) = 100;
  TrinaryMap padded = map;
  padded.width = 230;
  padded.height = 320;
  padded.origin_x = map.origin_x - 100 * 0.05;
  padded.origin_y = map.origin_y - 200 * 0.05;
  padded.cells.assign(230U * 320U, -1);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) cell(padded, x + 100, y + 200) = cell(map, x, y);
  const cv::Mat one = drawMap(map, {}), other = drawMap(padded, {});
  ASSERT_EQ(one.size(), other.size());
  EXPECT_LT(cv::norm(one, other, cv::NORM_INF), 2.0);
}

TEST(MapPicture, TruthAndTrajectoryAreDrawnWhereTheyAre) {
  TrinaryMap map = freeMap(60, 40);
  cell(map, 20, 10) = 100;  // at 0.025, 0.025
  MapAnnotations annotations;
  EXPECT_EQ(find(drawMap(map, annotations), isTruth).count, 0);
  EXPECT_EQ(find(drawMap(map, annotations), isPath).count, 0);
  Outline square;
  square.closed = true;
  for (const auto& [x, y] :
       {std::pair{-0.2, -0.2}, std::pair{0.25, -0.2}, std::pair{0.25, 0.25}, std::pair{-0.2, 0.25}})
    square.points.emplace_back(x, y);
  annotations.truth = {square};
  const cv::Mat with_truth = drawMap(map, annotations);
  const Found truth = find(with_truth, isTruth), occupied = find(with_truth, isOccupied);
  EXPECT_GT(truth.count, 100);
  EXPECT_NEAR(truth.u, occupied.u, 2.0);
  EXPECT_NEAR(truth.v, occupied.v, 2.0);
  square.closed = false;
  annotations.truth = {square};
  EXPECT_NEAR(find(drawMap(map, annotations), isTruth).count, 0.75 * truth.count,
              0.05 * truth.count);

  annotations.truth.clear();
  annotations.trajectory = {{0.025, 0.025, 0.0}, {0.5, 0.025, 0.0}, {1.0, 0.025, 0.0}};
  const cv::Mat with_path = drawMap(map, annotations);
  EXPECT_GT(find(with_path, isPath).count, 200);
  EXPECT_NEAR(find(with_path, isPath).v, occupied.v, 2.0);
  EXPECT_GT(find(with_path, isStart).u, occupied.u) << "the start's arrow points along x";
  EXPECT_NEAR(find(with_path, isStart).v, occupied.v, 2.0);
}

TEST(MapPicture, SurvivesNothingAndWhatIsNotFinite) {
  MapAnnotations annotations;
  annotations.trajectory = {{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}};
  EXPECT_FALSE(drawMap(TrinaryMap{}, annotations).empty());
  EXPECT_EQ(find(drawMap(TrinaryMap{}, annotations), isPath).count, 0);
}

TEST(MapPicture, LeavesOutPosesThatAreNotFinite) {
  const TrinaryMap map = freeMap(60, 40);
  MapAnnotations good, bad;
  good.trajectory = {{0.0, 0.0, 0.0}, {0.5, 0.2, 0.0}, {1.0, 0.0, 0.5}};
  bad.trajectory = good.trajectory;
  const SE2 broken{std::numeric_limits<double>::quiet_NaN(), 0.1, 0.0};
  for (const int at : {3, 1, 0}) bad.trajectory.insert(bad.trajectory.begin() + at, broken);
  EXPECT_EQ(cv::norm(drawMap(map, good), drawMap(map, bad), cv::NORM_INF), 0.0);
}

TEST(MapPicture, StaysPrintableForLargeAndSmallMaps) {
  for (const int side : {1, 20, 1000, 3000}) {
    const cv::Mat picture = drawMap(freeMap(side, side), {});
    EXPECT_GE(picture.cols, 640);
    EXPECT_LE(picture.cols, std::max(1300, side + 200));
  }
}

}  // namespace
}  // namespace ipm_mapping
