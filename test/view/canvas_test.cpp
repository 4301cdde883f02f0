#include "ipm_mapping/view/canvas.hpp"

#include <gtest/gtest.h>

namespace ipm_mapping {
namespace {

using Pixel = cv::Vec3b;

int countOf(const cv::Mat& image, const Pixel& color) {
  int n = 0;
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) n += image.at<Pixel>(v, u) == color;
  return n;
}

TEST(Canvas, ARectangleCoversItsPixelsAndNoOthers) {
  for (const int finer : {1, 2}) {
    Canvas canvas(40, 30, {0xFFFFFF}, finer);
    canvas.rectangle(10, 5, 8, 6, {0x102030});
    const cv::Mat image = canvas.finish();
    ASSERT_EQ(image.size(), cv::Size(40, 30));
    EXPECT_EQ(image.at<Pixel>(7, 13), Pixel(0x30, 0x20, 0x10)) << "RGB in, BGR out";
    EXPECT_EQ(image.at<Pixel>(5, 8), Pixel(255, 255, 255));
    EXPECT_EQ(image.at<Pixel>(13, 13), Pixel(255, 255, 255));
    EXPECT_EQ(countOf(image, {0x30, 0x20, 0x10}), 48);
  }
}

TEST(Canvas, OverlappingTranslucentPolygonsAreOneShape) {
  Canvas canvas(40, 40, {0x000000});
  const Polyline left{{5, 5}, {25, 5}, {25, 35}, {5, 35}},
      right{{15, 5}, {35, 5}, {35, 35}, {15, 35}};
  canvas.fill({left, right}, {0xFFFFFF}, 0.5);
  const cv::Mat image = canvas.finish();
  EXPECT_EQ(image.at<Pixel>(20, 10), image.at<Pixel>(20, 20));
  EXPECT_NEAR(image.at<Pixel>(20, 20)[0], 128, 1);
  EXPECT_EQ(image.at<Pixel>(20, 2), Pixel(0, 0, 0));
}

TEST(Canvas, ADashedLineHasGapsOfTheLengthOfItsDashes) {
  Canvas canvas(100, 9, {0x000000});
  canvas.dashedLine({{0, 4}, {99, 4}}, {0xFFFFFF}, 1.0, 10.0);
  const cv::Mat image = canvas.finish();
  EXPECT_GT(image.at<Pixel>(4, 5)[0], 200);
  EXPECT_EQ(image.at<Pixel>(4, 15)[0], 0);
  EXPECT_GT(image.at<Pixel>(4, 25)[0], 200);
  EXPECT_EQ(image.at<Pixel>(4, 95)[0], 0);
}

TEST(Canvas, ATextStandsWhereItsAnchorSays) {
  const double width = Canvas::textWidth("some words", 10.0);
  for (const auto& [anchor, left] : {std::pair{Canvas::Anchor::Left, 100.0},
                                     std::pair{Canvas::Anchor::Center, 100.0 - width / 2},
                                     std::pair{Canvas::Anchor::Right, 100.0 - width}}) {
    Canvas canvas(220, 30, {0x000000}, 2);
    canvas.text("some words", {100, 20}, 10.0, {0xFFFFFF}, anchor);
    cv::Mat gray;
    cv::extractChannel(canvas.finish(), gray, 0);
    std::vector<cv::Point> lit;
    cv::findNonZero(gray, lit);
    int first = 1000, last = 0;
    for (const cv::Point& p : lit) first = std::min(first, p.x), last = std::max(last, p.x);
    EXPECT_NEAR(first, left, 4);
    EXPECT_NEAR(last, left + width, 4);
  }
}

TEST(Canvas, PicturesAndShapesMayHangOverTheEdge) {
  Canvas canvas(20, 20, {0x000000});
  canvas.picture(cv::Mat(10, 10, CV_8UC1, cv::Scalar(200)), 15, -5, 10, 10, false);
  canvas.disk({-3, 10}, 6, {0xFFFFFF});
  canvas.line({{-1e12, 19}, {1e12, 19}}, {0x0000FF}, 1.0);
  const cv::Mat image = canvas.finish();
  EXPECT_EQ(image.at<Pixel>(2, 17), Pixel(200, 200, 200));
  EXPECT_EQ(image.at<Pixel>(2, 13), Pixel(0, 0, 0));
  EXPECT_EQ(image.at<Pixel>(10, 1), Pixel(255, 255, 255));
  EXPECT_GT(image.at<Pixel>(19, 10)[0], 200);
}

}  // namespace
}  // namespace ipm_mapping
