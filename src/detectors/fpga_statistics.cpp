#include "ipm_mapping/detectors/fpga_statistics.hpp"

#include <algorithm>

namespace ipm_mapping {
namespace {

void lower(double value, bool first, double& least) {
  least = first ? value : std::min(least, value);
}

}  // namespace

void FpgaStatistics::add(const FpgaDetector& detector) {
  const fpga::FrameSetup& setup = detector.frameSetup();
  const fpga::FrameParameters& p = setup.parameters;
  const fpga::Results& results = detector.results();
  const auto timing =
      fpga::frameTiming(clock_, static_cast<int>(p.width), static_cast<int>(p.height),
                        fpga::activityOf(results, static_cast<int>(p.min_height)));
  const bool first = summary_.frames++ == 0;
  summary_.points += static_cast<std::uint64_t>(results.selected.size);
  summary_.focus_clamped += setup.focus_clamped;
  homography_errors_.push_back(setup.homography_error);
  for (std::size_t i = 0; i < fpga::wire_count; ++i)
    summary_.overflow[i] += results.overflow.counts()[i];
  const fpga::StreamShape shape{static_cast<int>(p.width), static_cast<int>(p.height),
                                clock_.line_blanking, clock_.frame_blanking};
  summary_.first_contact = timing.first_contact;
  summary_.frame = shape.frame();
  summary_.after_last_pixel = std::max(summary_.after_last_pixel, timing.after_last_pixel);
  summary_.frame_rate = timing.frame_rate;
  summary_.slowest_to_map = std::max(summary_.slowest_to_map, timing.to_map);
  lower(timing.map_rate_in_series, first, summary_.slowest_map_rate_in_series);
  lower(timing.map_rate_pipelined, first, summary_.slowest_map_rate_pipelined);
}

FpgaStatistics::Summary FpgaStatistics::summary() const {
  Summary summary = summary_;
  if (homography_errors_.empty()) return summary;
  std::vector<double> errors = homography_errors_;
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  summary.median_homography_error = *middle;
  summary.worst_homography_error = *std::max_element(errors.begin(), errors.end());
  return summary;
}

}  // namespace ipm_mapping
