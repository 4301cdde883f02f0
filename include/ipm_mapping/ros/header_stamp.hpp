#pragma once

#include <std_msgs/Header.h>

#include <limits>

namespace ipm_mapping {

/// Seconds; NaN where whoever made the message left the stamp unset.
[[nodiscard]] inline double stampOf(const std_msgs::Header& header) {
  return header.stamp.isZero() ? std::numeric_limits<double>::quiet_NaN() : header.stamp.toSec();
}

}  // namespace ipm_mapping
