#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/sweep/vertical_sweep.hpp"

namespace ipm_mapping::sweep {

/// A highlight is the mirror image of a lamp: it stays where it was in the view while the floor
/// moves under it. The third explanation of a column beside floor and vertical: something at
/// infinity, azimuth turned by the robot's rotation, no parallax. Whatever that explains better is
/// taken off the floor's account:  F = min(F, static + specular_prior).
class SpecularCost {
 public:
  void configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                 const EvidenceParameters& parameters);

  /// Lowers `floor_cost` (sweepRows x beams) where a static view explains the rows in view.
  void apply(const CurrentView& current, const VerticalSweep& sweep,
             const SweepReference& reference, double turned, ImageView<std::uint16_t> floor_cost);

 private:
  PolarGrid grid_;
  std::vector<RowRange> reference_rows_;
  double parallax_ = 0.0;
  std::int32_t prior_ = 0;
  std::vector<std::uint16_t> cost_;
};

}  // namespace ipm_mapping::sweep
