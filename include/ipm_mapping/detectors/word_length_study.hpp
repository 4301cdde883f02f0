#pragma once
// What a word length does to a drive: the sweep over one wire's fraction bits on several frame
// pairs, up to the map of their contacts.

#include <string>
#include <vector>

#include "ipm_mapping/fpga/word_length.hpp"
#include "ipm_mapping/mapping/occupancy_map.hpp"
#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// One word length over all pairs, against long words.
struct WordLengthRow {
  int fraction_bits = 0;
  int pairs = 0;               ///< that the software part could set up
  double median_error = 0.0;   ///< px, of the reference point; median of the pairs
  double worst_error = 0.0;    ///< px, of all pairs
  double changed_mask = 0.0;   ///< pixels a pair
  double contact_error = 0.0;  ///< px; median of the pairs that kept a point
  int points = 0, lost_points = 0;
  int map_cells = 0;      ///< occupied by the points of long words
  int changed_cells = 0;  ///< occupied on one side only
};

class WordLengthStudy {
 public:
  /// Sweeps `first` to `last` fraction bits. Maps are made with the map's own cell size; a cell is
  /// occupied as soon as a point falls into it, as in the source's map.
  WordLengthStudy(const Parameters& parameters, fpga::ExploredWire wire, int first, int last);

  /// Takes a pair, whose view says where the robot stood. The results of its sweep; none when the
  /// pair cannot be set up even with long words, or cannot be represented.
  std::vector<fpga::WordLengthResult> add(const fpga::ExplorerInput& pair);

  [[nodiscard]] std::vector<WordLengthRow> rows() const;
  [[nodiscard]] fpga::ExploredWire wire() const { return wire_; }

 private:
  struct Width {
    int fraction_bits;
    std::vector<fpga::WordLengthResult> results;
    OccupancyMap map;
  };

  Parameters parameters_;
  fpga::ExploredWire wire_;
  std::vector<Width> widths_;
  OccupancyMap ideal_map_;
};

/// Header line and one line a row.
[[nodiscard]] std::string wordLengthCsv(fpga::ExploredWire wire,
                                        const std::vector<WordLengthRow>& rows);

}  // namespace ipm_mapping
