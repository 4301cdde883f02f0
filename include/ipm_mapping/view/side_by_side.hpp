#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/obstacles.hpp"

namespace ipm_mapping {

/// A picture and what is written over it.
struct Panel {
  cv::Mat picture;  ///< BGR or grey
  std::string caption;
};

/// Panels of the first one's height, from left to right, each under its caption. BGR.
[[nodiscard]] cv::Mat sideBySide(const std::vector<Panel>& panels);

/// Grey levels of one picture times `gain`.
[[nodiscard]] cv::Mat amplified(GrayView picture, int gain);
/// How far two pictures of one size are apart, times `gain`: what is only in `a` is green, what is
/// only in `b` magenta, what agrees black. BGR.
[[nodiscard]] cv::Mat differenceOf(GrayView a, GrayView b, int gain);

enum class ContactMark { Ring, Disk };
/// Marks contacts at their undistorted pixels on a picture of that view (BGR).
void markContacts(const std::vector<Contact>& contacts, ContactMark mark, double radius,
                  cv::Mat& picture);

}  // namespace ipm_mapping
