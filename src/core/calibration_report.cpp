#include "ipm_mapping/calibration_report.hpp"

#include <cmath>
#include <cstdio>

namespace ipm_mapping {
namespace {

constexpr double degrees = 180.0 / M_PI;

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

void add(const std::string& sentence, std::string& words) {
  words += (words.empty() ? "" : "; ") + sentence;
}

std::string poseAdvice(const CalibrationReport& r) {
  std::string words;
  if (r.pitch_off)
    add(formatted(
            "the camera looks %.2f deg %s than stated: change the pitch from %.4f to %.4f rad",
            degrees * std::abs(r.pitch.off()), r.pitch.off() > 0 ? "lower" : "higher",
            r.pitch.stated, r.pitch.estimate),
        words);
  if (r.roll_off)
    add(formatted("the camera is rolled by %.2f deg about its heading: level it or state the roll",
                  degrees * r.roll.off()),
        words);
  if (r.height_off)
    add(formatted("the camera is %.1f cm %s than stated: change the height from %.3f to %.3f m "
                  "(if odometry's way is right)",
                  100.0 * std::abs(r.height.off()), r.height.off() > 0 ? "higher" : "lower",
                  r.height.stated, r.height.estimate),
        words);
  return words;
}

}  // namespace

std::string advice(const CalibrationReport& r) {
  if (!r.believable) return "not enough floor motion seen yet to judge the camera's pose";
  std::string words = poseAdvice(r);
  if (r.time_off)
    add(formatted(
            "images are stamped %.0f ms too %s: add %.3f to camera/image_time_offset, or leave "
            "that to the detector, which finds it out as it drives",
            1000.0 * std::abs(r.time_offset.off()), r.time_offset.off() < 0 ? "late" : "early",
            r.time_offset.off()),
        words);
  return words.empty() ? "the stated pose fits what the floor shows" : words;
}

std::string concern(const CalibrationReport& r) {
  if (r.applied || !(r.pitch_off || r.roll_off || r.height_off)) return {};
  return poseAdvice(r) + "; or let calibration/mode apply the estimate";
}

}  // namespace ipm_mapping
