#pragma once
// What the FPGA model's registers and counters held over a whole drive.

#include <cstdint>
#include <vector>

#include "ipm_mapping/detectors/fpga_detector.hpp"
#include "ipm_mapping/fpga/cycles.hpp"

namespace ipm_mapping {

/// Sums and extremes over the used frames of a run.
class FpgaStatistics {
 public:
  explicit FpgaStatistics(const FpgaClockParameters& clock) : clock_(clock) {}

  /// After every used frame.
  void add(const FpgaDetector& detector);

  struct Summary {
    std::uint64_t frames = 0, points = 0, focus_clamped = 0;
    double median_homography_error = 0.0, worst_homography_error = 0.0;  ///< px
    fpga::OverflowCounters::Counts overflow{};
    fpga::Cycles first_contact = 0;     ///< from the first pixel
    fpga::Cycles frame = 0;             ///< pixels and blanking
    fpga::Cycles after_last_pixel = 0;  ///< to the last point, in the slowest frame
    double frame_rate = 0.0;            ///< Hz, hardware alone
    double slowest_map_rate_in_series = 0.0, slowest_map_rate_pipelined = 0.0;  ///< Hz
    double slowest_to_map = 0.0;                                                ///< s
  };
  [[nodiscard]] Summary summary() const;

 private:
  FpgaClockParameters clock_;
  Summary summary_;
  std::vector<double> homography_errors_;
};

}  // namespace ipm_mapping
