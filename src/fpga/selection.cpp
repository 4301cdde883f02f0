#include "ipm_mapping/fpga/selection.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <tuple>

namespace ipm_mapping::fpga {
namespace {

/// A contact with its distance to the peak that it serves.
struct Candidate {
  std::uint32_t word = 0;
  int distance = 0;

  /// Nearest to the robot first, then nearest to its peak, then the lower bearing.
  [[nodiscard]] bool beats(const Candidate& o) const {
    return std::make_tuple(-wordRow(word), distance, wordBearing(word)) <
           std::make_tuple(-wordRow(o.word), o.distance, wordBearing(o.word));
  }
};

int distanceTo(const Peaks& peaks, int peak, int bearing) {
  return std::abs(peakBearing(peaks[peak]) - bearing);
}

/// Best candidate among the contacts that serve the peaks first ... last.
std::optional<Candidate> best(const Contacts& cor, const Peaks& peaks, int first, int last,
                              int tolerance) {
  std::optional<Candidate> winner;
  for (const ContactEntry& contact : cor) {
    if (!contact.found) continue;
    const int bearing = wordBearing(contact.word);
    const int peak = servedPeak(peaks, bearing);
    const Candidate candidate{contact.word, distanceTo(peaks, peak, bearing)};
    if (peak < first || peak > last || candidate.distance > tolerance) continue;
    if (!winner || candidate.beats(*winner)) winner = candidate;
  }
  return winner;
}

}  // namespace

int servedPeak(const Peaks& peaks, int bearing) {
  int nearest = 0;
  for (int i = 1; i < peaks.size; ++i) {
    if (distanceTo(peaks, i, bearing) < distanceTo(peaks, nearest, bearing)) nearest = i;
  }
  return nearest;
}

void selectContacts(const Contacts& cor, const Peaks& peaks, int bearing_tolerance,
                    SelectedContacts& selected) {
  selected.clear();
  for (int first = 0; first < peaks.size;) {
    int last = first;
    while (last + 1 < peaks.size && !peakStartsObstacle(peaks[last + 1])) ++last;
    if (const auto winner = best(cor, peaks, first, last, bearing_tolerance)) {
      selected.push(winner->word);
    }
    first = last + 1;
  }
}

}  // namespace ipm_mapping::fpga
