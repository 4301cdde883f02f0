#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <boost/shared_ptr.hpp>
#include <optional>
#include <string>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping {

/// One sentence that says what is wrong with a message; nothing when it can be used.
using Refusal = std::optional<std::string>;

/// A grey picture together with what keeps its pixels alive: the message itself where they are
/// already grey, a converted copy elsewhere.
struct GrayPicture {
  GrayView view;
  boost::shared_ptr<const void> owner;
};

/// mono8 and 8UC1 are wrapped without a copy; mono16, rgb8, bgr8, rgba8, bgra8, bayer_* and yuv422
/// are converted to 8 bit grey. Any other encoding, and a message whose size, step and data
/// contradict each other, is refused.
[[nodiscard]] Refusal toGray(const sensor_msgs::ImageConstPtr& message, GrayPicture& picture);

/// JPEG, PNG and whatever else OpenCV decodes, to 8 bit grey.
[[nodiscard]] Refusal toGray(const sensor_msgs::CompressedImage& message, GrayPicture& picture);

/// A window onto a mono8 or 8UC1 message that outlives it.
[[nodiscard]] Refusal wrapMono8(const sensor_msgs::Image& message, GrayView& view);

/// Makes `message` a mono8 image of that size (header untouched) and returns the window through
/// which a stage writes its pixels.
GrayBuffer allocateMono8(int width, int height, sensor_msgs::Image& message);

/// Makes `message` a copy of a picture that a stage keeps for itself (header untouched).
void copyMono8(GrayView picture, sensor_msgs::Image& message);

}  // namespace ipm_mapping
