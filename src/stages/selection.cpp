#include "ipm_mapping/stages/selection.hpp"

#include <cstdlib>

namespace ipm_mapping {
namespace {

/// Index of the peak nearest to a bearing; the lower one on a tie. Peaks are sorted.
int nearestPeak(const std::vector<Peak>& peaks, int bearing) {
  int best = 0;
  for (int i = 1; i < static_cast<int>(peaks.size()); ++i) {
    if (std::abs(peaks[static_cast<std::size_t>(i)].bearing - bearing) <
        std::abs(peaks[static_cast<std::size_t>(best)].bearing - bearing))
      best = i;
  }
  return best;
}

/// The winner so far of one obstacle.
struct Winner {
  int index = -1;
  double range = 0.0;
  int distance = 0;
  int bearing = 0;

  void offer(int i, const SelectionCandidate& candidate, int to_peak) {
    const bool better =
        index < 0 || candidate.range < range ||
        (candidate.range == range &&
         (to_peak < distance || (to_peak == distance && candidate.bearing < bearing)));
    if (better) *this = {i, candidate.range, to_peak, candidate.bearing};
  }
};

}  // namespace

void selectContacts(const std::vector<Peak>& peaks,
                    const std::vector<SelectionCandidate>& candidates, int bearing_tolerance,
                    std::vector<int>& chosen) {
  chosen.clear();
  const int n_peaks = static_cast<int>(peaks.size());
  for (int begin = 0; begin < n_peaks;) {
    int end = begin + 1;
    while (end < n_peaks && !peaks[static_cast<std::size_t>(end)].new_obstacle) ++end;
    Winner winner;
    for (int i = 0; i < static_cast<int>(candidates.size()); ++i) {
      const SelectionCandidate& candidate = candidates[static_cast<std::size_t>(i)];
      const int peak = nearestPeak(peaks, candidate.bearing);
      const int distance =
          std::abs(peaks[static_cast<std::size_t>(peak)].bearing - candidate.bearing);
      if (peak >= begin && peak < end && distance <= bearing_tolerance)
        winner.offer(i, candidate, distance);
    }
    if (winner.index >= 0) chosen.push_back(winner.index);
    begin = end;
  }
}

}  // namespace ipm_mapping
