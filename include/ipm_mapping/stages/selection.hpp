#pragma once

#include <vector>

#include "ipm_mapping/stages/free_space.hpp"

namespace ipm_mapping {

/// A contact as the selection sees it.
struct SelectionCandidate {
  int bearing = 0;
  double range = 0.0;  ///< metres to the robot
};

/// One contact for every obstacle (the source, §5.4.1, §6.10.1; algorithm 3 done right: the last
/// obstacle is not lost and every obstacle starts with an empty list).
///
/// A contact serves only the nearest peak (equally near: the lower bearing) and only within
/// `bearing_tolerance` lines of it. Of an obstacle's contacts the nearest to the robot wins, then
/// the one closest to its peak, then the lower bearing. chosen: indices into candidates, obstacle
/// by obstacle from the left.
void selectContacts(const std::vector<Peak>& peaks,
                    const std::vector<SelectionCandidate>& candidates, int bearing_tolerance,
                    std::vector<int>& chosen);

}  // namespace ipm_mapping
