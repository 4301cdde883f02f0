#include "ipm_mapping/ros/calibration_diagnostics.hpp"

#include <cmath>

namespace ipm_mapping {
namespace {

constexpr double degrees = 180.0 / M_PI;

void show(StageMonitor& monitor, const std::string& name, const CalibrationReport::Value& value,
          double unit, double zero = 0.0) {
  monitor.set("calibration_" + name, unit * (value.estimate - zero));
  monitor.set("calibration_" + name + "_sigma", unit * value.sigma);
}

}  // namespace

void showCalibration(const CalibrationReport& r, StageMonitor& monitor) {
  monitor.set("calibration_pairs", r.pairs);
  monitor.set("calibration_applied", r.applied ? 1.0 : 0.0);
  monitor.set("calibration_pitch_deg_stated", degrees * r.pitch.stated);
  monitor.set("calibration_height_m_stated", r.height.stated);
  show(monitor, "pitch_deg", r.pitch, degrees);
  show(monitor, "roll_deg", r.roll, degrees);
  show(monitor, "yaw_deg", r.yaw, degrees);
  show(monitor, "height_m", r.height, 1.0);
  show(monitor, "odometry_scale_percent", r.scale, 100.0, 1.0);
  show(monitor, "odometry_turn_percent", r.turn_scale, 100.0, 1.0);
  show(monitor, "odometry_yaw_rate_deg_s", r.yaw_rate, degrees);
  show(monitor, "readout_ms", r.readout, 1000.0);
  show(monitor, "time_offset_ms", r.time_offset, 1000.0);
  show(monitor, "lens_shading_percent", r.shading, 100.0);
  monitor.setConcern(concern(r));
}

}  // namespace ipm_mapping
