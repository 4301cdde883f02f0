#pragma once

#include "ipm_mapping/calibration_report.hpp"
#include "ipm_mapping/ros/stage_monitor.hpp"

namespace ipm_mapping {

/// Estimates beside what is stated, in degrees, metres and percent; a lasting warning where the
/// stated pose is surely and usefully off.
void showCalibration(const CalibrationReport& report, StageMonitor& monitor);

}  // namespace ipm_mapping
