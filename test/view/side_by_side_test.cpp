#include "ipm_mapping/view/side_by_side.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace ipm_mapping {
namespace {

TEST(SideBySide, KeepsThePanelsPixelsInTheirOrder) {
  const cv::Mat red(120, 160, CV_8UC3, cv::Scalar(0, 0, 255));
  const cv::Mat grey(120, 160, CV_8UC1, cv::Scalar(77));
  const cv::Mat picture = sideBySide({{red, "first"}, {grey, "second"}});
  ASSERT_GE(picture.cols, 320);
  ASSERT_GT(picture.rows, 120);
  const int v = picture.rows - 60;
  EXPECT_EQ(picture.at<cv::Vec3b>(v, 80), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(picture.at<cv::Vec3b>(v, picture.cols - 80), cv::Vec3b(77, 77, 77));
}

TEST(SideBySide, WritesTheCaptionAboveItsOwnPanel) {
  const cv::Mat black(120, 160, CV_8UC3, cv::Scalar(0, 0, 0));
  const cv::Mat none = sideBySide({{black, " "}, {black, " "}});
  const cv::Mat second = sideBySide({{black, " "}, {black, "caption"}});
  cv::Mat changed;
  cv::absdiff(none, second, changed);
  cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
  const cv::Rect box = cv::boundingRect(changed);
  ASSERT_GT(box.area(), 0);
  EXPECT_GE(box.x, 160);
  EXPECT_LE(box.br().y, none.rows - 120);
}

TEST(SideBySide, ALongCaptionStaysInsideItsPanel) {
  const cv::Mat black(120, 160, CV_8UC3, cv::Scalar(0, 0, 0));
  const cv::Mat none = sideBySide({{black, " "}, {black, " "}});
  const cv::Mat first = sideBySide({{black, std::string(90, 'm')}, {black, " "}});
  cv::Mat changed;
  cv::absdiff(none, first, changed);
  cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
  const cv::Rect box = cv::boundingRect(changed);
  ASSERT_GT(box.area(), 0);
  EXPECT_LE(box.br().x, 163);
}

TEST(SideBySide, DifferenceTellsTheSidesApartAndSaturates) {
  Image<std::uint8_t> a(3, 1, 10), b(3, 1, 10);
  a.at(0, 0) = 13;
  b.at(1, 0) = 110;
  const cv::Mat picture = differenceOf(std::as_const(a).view(), std::as_const(b).view(), 8);
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 24, 0));
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 1), cv::Vec3b(255, 0, 255));
  EXPECT_EQ(picture.at<cv::Vec3b>(0, 2), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(amplified(std::as_const(a).view(), 20).at<std::uint8_t>(0, 0), 255);
}

TEST(SideBySide, MarksContactsWhereTheyAre) {
  Contact contact;
  contact.u = 30.0F;
  contact.v = 50.0F;
  const cv::Mat plain(80, 100, CV_8UC3, cv::Scalar(90, 90, 90));
  for (const ContactMark mark : {ContactMark::Ring, ContactMark::Disk}) {
    cv::Mat marked = plain.clone();
    markContacts({contact}, mark, 6.0, marked);
    cv::Mat changed;
    cv::absdiff(plain, marked, changed);
    cv::cvtColor(changed, changed, cv::COLOR_BGR2GRAY);
    const cv::Rect box = cv::boundingRect(changed);
    ASSERT_GT(box.area(), 0);
    EXPECT_NEAR(box.x + 0.5 * box.width, 30.5, 1.5);
    EXPECT_NEAR(box.y + 0.5 * box.height, 50.5, 1.5);
  }
}

}  // namespace
}  // namespace ipm_mapping
