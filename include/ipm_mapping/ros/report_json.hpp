#pragma once

#include <string>

#include "ipm_mapping/detectors/fpga_statistics.hpp"
#include "ipm_mapping/ros/offline_run.hpp"

namespace ipm_mapping {

/// `report.json` of a run: what was read, used and skipped by reason, time by stage, calibration,
/// and every parameter that was in force. `fpga`: what the FPGA model, if it ran, leaves to report.
[[nodiscard]] std::string reportJson(const OfflineRun& run, const BagSource& bag,
                                     const RunCamera& camera, const OfflineOptions& options,
                                     const std::string& profile,
                                     const FpgaStatistics* fpga = nullptr);

}  // namespace ipm_mapping
