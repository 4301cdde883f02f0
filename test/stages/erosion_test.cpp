#include "ipm_mapping/stages/erosion.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

TEST(Erosion, EqualsOpenCvWithABackgroundBorderAtEverySize) {
  std::mt19937 random(9);
  Erosion erosion;
  for (const cv::Size size : awkwardSizes()) {
    for (const double density : {0.0, 0.7, 0.95, 1.0}) {
      Picture binary = speckle(size.width, size.height, random, density);
      Picture eroded(size.width, size.height, 3), expected(size.width, size.height);
      erosion(binary.view(), eroded.view());
      cv::erode(binary.mat().clone(), expected.mat(), cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1,
                cv::BORDER_CONSTANT, cv::Scalar(0));
      EXPECT_TRUE(equal(eroded, expected)) << size << " density " << density;
    }
  }
}

TEST(ObstacleMask, SaysObstacleThenFloorThenUnseen) {
  Picture eroded(4, 1), valid(4, 1), out(4, 1, 7), expected(4, 1);
  eroded(0, 0) = eroded(1, 0) = 255;
  valid(0, 0) = valid(2, 0) = 255;
  expected(0, 0) = expected(1, 0) = mask::obstacle;
  expected(2, 0) = mask::floor;
  expected(3, 0) = mask::unseen;
  mask::compose(eroded.view(), valid.view(), out.view());
  EXPECT_TRUE(equal(out, expected));
}

}  // namespace
}  // namespace ipm_mapping::test
