#pragma once

#include <string>

namespace ipm_mapping {

/// What self-calibration has to say, in radians, metres, seconds and ratios.
struct CalibrationReport {
  struct Value {
    double stated = 0.0, estimate = 0.0, sigma = 0.0;
    [[nodiscard]] double off() const { return estimate - stated; }
  };
  Value pitch;               ///< of the camera, down is positive
  Value roll;                ///< of the camera about its heading, over the stated one
  Value yaw;                 ///< of the camera's heading, over the stated one
  Value height;              ///< of the camera over the floor
  Value scale;               ///< true way over odometry's
  Value turn_scale;          ///< true turn over odometry's, without the drift
  Value yaw_rate;            ///< true heading change over odometry's, per second
  Value readout;             ///< of an image, first row to last: a rolling shutter
  Value time_offset;         ///< that an image was taken after its stamp, over the stated one
  Value shading;             ///< of the image's corners, by the lens: share of the grey level
  double ratio_sigma = 0.0;  ///< of height over odometry's way, relative: all that the floor shows
  int pairs = 0;             ///< of frames that were compared
  bool believable = false;   ///< within the stated bounds, and enough pairs
  bool confident = false;    ///< sure enough to be applied
  bool applied = false;      ///< the detector works with an estimate
  /// surely and usefully
  bool pitch_off = false, roll_off = false, height_off = false, time_off = false;
};

/// What to change, as sentences for people; says so when all is well or little is known.
[[nodiscard]] std::string advice(const CalibrationReport& report);

/// What has to be told unasked: the pose in force is surely wrong, and what to do. Empty otherwise.
[[nodiscard]] std::string concern(const CalibrationReport& report);

}  // namespace ipm_mapping
