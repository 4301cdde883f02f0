#include "ipm_mapping/ros/images.hpp"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>

#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

namespace encodings = sensor_msgs::image_encodings;

bool isGray(const std::string& encoding) {
  return encoding == encodings::MONO8 || encoding == encodings::TYPE_8UC1;
}

/// Bytes that a pixel of a supported encoding takes; 0 for the others.
std::uint64_t bytesPerPixel(const std::string& encoding) {
  if (isGray(encoding)) return 1;
  if (encoding == encodings::MONO16 || encoding == encodings::YUV422) return 2;
  if (encoding == encodings::RGB8 || encoding == encodings::BGR8) return 3;
  if (encoding == encodings::RGBA8 || encoding == encodings::BGRA8) return 4;
  if (encodings::isBayer(encoding)) return encodings::bitDepth(encoding) == 16 ? 2 : 1;
  return 0;
}

Refusal checkLayout(const sensor_msgs::Image& image) {
  const std::uint64_t pixel = bytesPerPixel(image.encoding);
  if (pixel == 0)
    return sentence("image encoding '", image.encoding,
                    "' is not supported, only mono8, mono16, rgb8, bgr8, rgba8, bgra8, bayer_* and "
                    "yuv422");
  if (image.width == 0 || image.height == 0 || image.width > 65535 || image.height > 65535)
    return sentence("image of ", image.width, "x", image.height, " pixels has no usable size");
  if (image.step < pixel * image.width)
    return sentence("image step ", image.step, " is too short for ", image.width, " pixels of ",
                    image.encoding);
  const std::uint64_t needed = std::uint64_t{image.step} * image.height;
  if (image.data.size() < needed)
    return sentence("image data has ", image.data.size(), " bytes, step * height asks for ",
                    needed);
  return std::nullopt;
}

GrayView viewOf(const sensor_msgs::Image& image) {
  return {image.data.data(), static_cast<int>(image.width), static_cast<int>(image.height),
          static_cast<std::ptrdiff_t>(image.step)};
}

GrayView viewOf(const cv::Mat& grey) {
  return {grey.ptr<std::uint8_t>(), grey.cols, grey.rows, static_cast<std::ptrdiff_t>(grey.step)};
}

}  // namespace

Refusal wrapMono8(const sensor_msgs::Image& message, GrayView& view) {
  if (!isGray(message.encoding))
    return sentence("image encoding '", message.encoding, "' where mono8 is expected");
  if (Refusal refusal = checkLayout(message)) return refusal;
  view = viewOf(message);
  return std::nullopt;
}

Refusal toGray(const sensor_msgs::ImageConstPtr& message, GrayPicture& picture) {
  if (Refusal refusal = checkLayout(*message)) return refusal;
  if (isGray(message->encoding)) {
    picture = {viewOf(*message), message};
    return std::nullopt;
  }
  try {
    const cv_bridge::CvImageConstPtr grey = cv_bridge::toCvShare(message, encodings::MONO8);
    picture = {viewOf(grey->image), grey};
  } catch (const std::exception& error) {
    return sentence("image encoding '", message->encoding, "': ", error.what());
  }
  return std::nullopt;
}

Refusal toGray(const sensor_msgs::CompressedImage& message, GrayPicture& picture) {
  if (message.data.empty()) return sentence("compressed image without data");
  if (message.format.find("compressedDepth") != std::string::npos)
    return sentence("compressed image format '", message.format, "' is a depth image");
  try {
    const auto grey = boost::make_shared<cv::Mat>(cv::imdecode(message.data, cv::IMREAD_GRAYSCALE));
    if (grey->empty())
      return sentence("compressed image format '", message.format, "' cannot be decoded");
    picture = {viewOf(*grey), grey};
  } catch (const std::exception& error) {
    return sentence("compressed image format '", message.format, "': ", error.what());
  }
  return std::nullopt;
}

GrayBuffer allocateMono8(int width, int height, sensor_msgs::Image& message) {
  message.width = static_cast<std::uint32_t>(width);
  message.height = static_cast<std::uint32_t>(height);
  message.encoding = encodings::MONO8;
  message.is_bigendian = 0;
  message.step = message.width;
  message.data.resize(std::size_t{message.step} * message.height);
  return {message.data.data(), width, height};
}

void copyMono8(GrayView picture, sensor_msgs::Image& message) {
  const GrayBuffer copy = allocateMono8(picture.width, picture.height, message);
  for (int v = 0; v < picture.height; ++v) std::copy_n(picture.row(v), picture.width, copy.row(v));
}

}  // namespace ipm_mapping
