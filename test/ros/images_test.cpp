#include "ipm_mapping/ros/images.hpp"

#include <cv_bridge/cv_bridge.h>
#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace ipm_mapping {
namespace {

sensor_msgs::ImagePtr image(const std::string& encoding, std::uint32_t width, std::uint32_t height,
                            std::uint32_t bytes_per_pixel, std::uint32_t extra = 0) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->encoding = encoding;
  message->width = width;
  message->height = height;
  message->step = width * bytes_per_pixel + extra;
  message->data.resize(std::size_t{message->step} * height);
  for (std::size_t i = 0; i < message->data.size(); ++i)
    message->data[i] = static_cast<std::uint8_t>(i * 37 % 251);
  return message;
}

TEST(Images, GreyMessagesAreWrappedWithoutACopyAndRespectTheStep) {
  for (const char* encoding : {"mono8", "8UC1"}) {
    const auto message = image(encoding, 6, 4, 1, 3);
    GrayPicture picture;
    ASSERT_EQ(toGray(message, picture), std::nullopt) << encoding;
    EXPECT_EQ(picture.view.data, message->data.data());
    EXPECT_EQ(picture.view.width, 6);
    EXPECT_EQ(picture.view.height, 4);
    EXPECT_EQ(&picture.view.at(2, 3), &message->data[3 * 9 + 2]);
    EXPECT_EQ(picture.owner, message);
  }
}

TEST(Images, ColourIsConvertedToTheGreyThatOpenCVComputes) {
  struct Case {
    const char* encoding;
    std::uint32_t channels;
    int code;
  };
  for (const Case& c :
       {Case{"rgb8", 3, cv::COLOR_RGB2GRAY}, Case{"bgr8", 3, cv::COLOR_BGR2GRAY},
        Case{"rgba8", 4, cv::COLOR_RGBA2GRAY}, Case{"bgra8", 4, cv::COLOR_BGRA2GRAY}}) {
    const auto message = image(c.encoding, 8, 6, c.channels, 4);
    const cv::Mat wrapped(6, 8, CV_8UC(static_cast<int>(c.channels)), message->data.data(),
                          message->step);
    cv::Mat expected;
    cv::cvtColor(wrapped, expected, c.code);
    GrayPicture picture;
    ASSERT_EQ(toGray(message, picture), std::nullopt) << c.encoding;
    for (int v = 0; v < 6; ++v)
      for (int u = 0; u < 8; ++u)
        ASSERT_EQ(picture.view.at(u, v), expected.at<std::uint8_t>(v, u)) << c.encoding;
  }
}

TEST(Images, SixteenBitsAreScaledToEight) {
  const auto message = image("mono16", 2, 1, 2);
  message->data = {0xFF, 0xFF, 0x00, 0x80};
  GrayPicture picture;
  ASSERT_EQ(toGray(message, picture), std::nullopt);
  EXPECT_EQ(picture.view.at(0, 0), 255);
  EXPECT_NEAR(picture.view.at(1, 0), 128, 1);
}

TEST(Images, EveryEncodingOfTheListGivesAPictureOfTheSameSize) {
  for (const auto& [encoding, bytes] :
       std::vector<std::pair<std::string, std::uint32_t>>{{"bayer_rggb8", 1},
                                                          {"bayer_bggr8", 1},
                                                          {"bayer_gbrg8", 1},
                                                          {"bayer_grbg8", 1},
                                                          {"bayer_rggb16", 2},
                                                          {"bayer_bggr16", 2},
                                                          {"bayer_gbrg16", 2},
                                                          {"bayer_grbg16", 2},
                                                          {"yuv422", 2}}) {
    auto message = image(encoding, 8, 6, bytes);
    std::fill(message->data.begin(), message->data.end(), std::uint8_t{128});
    GrayPicture picture;
    ASSERT_EQ(toGray(message, picture), std::nullopt) << encoding;
    EXPECT_EQ(picture.view.width, 8);
    EXPECT_EQ(picture.view.height, 6);
    EXPECT_NEAR(picture.view.at(4, 3), 128, 1) << encoding;
  }
}

TEST(Images, UnknownEncodingsAreRefusedByName) {
  for (const char* encoding : {"32FC1", "16UC1", "yuv420", "", "bayer"}) {
    GrayPicture picture;
    const Refusal refusal = toGray(image(encoding, 8, 6, 4), picture);
    ASSERT_TRUE(refusal) << encoding;
    EXPECT_NE(refusal->find(std::string("'") + encoding + "'"), std::string::npos) << *refusal;
    EXPECT_TRUE(picture.view.empty());
  }
}

TEST(Images, ContradictingSizesAreRefusedByTheFieldsName) {
  const auto refusalOf = [](auto&& change) {
    auto message = image("mono8", 8, 6, 1);
    change(*message);
    GrayPicture picture;
    return toGray(message, picture).value_or("accepted");
  };
  using Image = sensor_msgs::Image;
  EXPECT_NE(refusalOf([](Image& m) { m.width = 0; }).find("0x6"), std::string::npos);
  EXPECT_NE(refusalOf([](Image& m) { m.height = 0; }).find("8x0"), std::string::npos);
  EXPECT_NE(refusalOf([](Image& m) { m.step = 7; }).find("step 7"), std::string::npos);
  EXPECT_NE(refusalOf([](Image& m) { m.data.resize(47); }).find("47 bytes"), std::string::npos);
  EXPECT_NE(refusalOf([](Image& m) { m.step = 0x80000000U; }).find("data"), std::string::npos);
  EXPECT_NE(refusalOf([](Image& m) { m.width = m.step = 0xFFFFFFFFU; }).find("size"),
            std::string::npos);
}

TEST(Images, CompressedPicturesAreDecoded) {
  cv::Mat grey(16, 24, CV_8UC1);
  for (int i = 0; i < grey.rows * grey.cols; ++i) grey.data[i] = static_cast<std::uint8_t>(i % 256);
  sensor_msgs::CompressedImage message;
  message.format = "mono8; png compressed";
  cv::imencode(".png", grey, message.data);
  GrayPicture picture;
  ASSERT_EQ(toGray(message, picture), std::nullopt);
  for (int v = 0; v < grey.rows; ++v)
    for (int u = 0; u < grey.cols; ++u)
      ASSERT_EQ(picture.view.at(u, v), grey.at<std::uint8_t>(v, u));
}

TEST(Images, BrokenCompressedPicturesAreRefused) {
  sensor_msgs::CompressedImage message;
  message.format = "jpeg";
  GrayPicture picture;
  EXPECT_TRUE(toGray(message, picture));
  message.data = {1, 2, 3, 4, 5};
  const Refusal refusal = toGray(message, picture);
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("'jpeg'"), std::string::npos);
  message.format = "16UC1; compressedDepth";
  EXPECT_TRUE(toGray(message, picture));
}

TEST(Images, AnOutgoingPictureIsWrittenThroughItsView) {
  sensor_msgs::Image message;
  const GrayBuffer buffer = allocateMono8(5, 3, message);
  buffer.at(4, 2) = 77;
  EXPECT_EQ(message.encoding, "mono8");
  EXPECT_EQ(message.step, 5U);
  EXPECT_EQ(message.data.size(), 15U);
  EXPECT_EQ(message.data.back(), 77);
  GrayView view;
  ASSERT_EQ(wrapMono8(message, view), std::nullopt);
  EXPECT_EQ(view.data, message.data.data());
  message.encoding = "rgb8";
  EXPECT_TRUE(wrapMono8(message, view));
}

}  // namespace
}  // namespace ipm_mapping
