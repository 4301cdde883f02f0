#pragma once
// What a word length costs: the datapath with other fraction bits on a chosen wire. Slow and
// generic; at the contract's widths it gives the contract's bits.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ipm_mapping/fpga/software_part.hpp"
#include "ipm_mapping/fpga/vectors.hpp"

namespace ipm_mapping::fpga {

/// Wires whose fraction bits can be turned.
enum class ExploredWire : std::uint8_t {
  HomographyLinear,  ///< columns 1 and 2 (rule 3)
  HomographyOffset,  ///< column 3 (rule 3)
  Coordinate,        ///< between homography and lens, and after it (rule 2)
  Intrinsic,         ///< fx fy cx cy (rule 4)
  Lens,              ///< k1 k2 k3 (rule 4)
  Normalized,        ///< xn yn r2 and the Horner chain (rule 4)
  GaussianTerm,      ///< bits kept below a grey level until the sum (rule 8)
  ClassMean          ///< Otsu's means (rule 9)
};
inline constexpr std::size_t explored_wire_count = 8;
inline constexpr std::array<const char*, explored_wire_count> explored_wire_names{
    "homography_linear", "homography_offset", "coordinate", "intrinsic", "lens",
    "normalized",        "gaussian_term",     "class_mean"};
[[nodiscard]] std::optional<ExploredWire> exploredWire(const std::string& name);

/// Fraction bits of each of them; the integer bits stay those of the contract.
class WordLengths {
 public:
  static constexpr int longest = 24;

  /// The contract's.
  WordLengths();
  /// Long enough that rounding no longer matters.
  static WordLengths ideal();
  WordLengths with(ExploredWire wire, int fraction_bits) const;
  [[nodiscard]] int operator[](ExploredWire wire) const {
    return bits_[static_cast<std::size_t>(wire)];
  }

 private:
  std::array<int, explored_wire_count> bits_;
};

/// A frame pair to explore with.
struct ExplorerInput {
  GroundView view;
  GrayView reference, current;
  std::uint8_t threshold_in = ThresholdRegister::reset_value;
};

/// Where the reference stream samples its frame.
struct SampledPoint {
  bool valid = false;
  double u = 0.0, v = 0.0;  ///< before rule 5's rounding
};

class WordLengthDatapath {
 public:
  WordLengthDatapath(const FpgaParameters& parameters, const WordLengths& lengths)
      : parameters_(parameters), lengths_(lengths) {}

  /// False when the software part cannot set the frame up. paper_order is not explored.
  bool run(const ExplorerInput& input, Wires& wires);
  /// Reference points of the last run, row by row.
  [[nodiscard]] const std::vector<SampledPoint>& sampled() const { return sampled_; }

 private:
  FpgaParameters parameters_;
  WordLengths lengths_;
  std::vector<SampledPoint> sampled_;
};

/// One word length against long words and double precision.
struct WordLengthResult {
  int fraction_bits = 0;
  bool usable = false;         ///< false: the software part refused the frame
  double median_error = 0.0;   ///< px, of the reference point, to the exact geometry
  double worst_error = 0.0;    ///< px
  int changed_difference = 0;  ///< pixels, to long words
  int changed_mask = 0;        ///< pixels, to long words
  int threshold_change = 0;    ///< grey levels, to long words
  int points = 0;              ///< selected
  int lost_points = 0;         ///< of long words' points, none within one bearing spacing
  double contact_error = 0.0;  ///< px, median distance of the others
  SelectedContacts selected;   ///< with this word length
  SelectedContacts ideal;      ///< with long words
};
[[nodiscard]] std::vector<WordLengthResult> sweepWordLength(const ExplorerInput& input,
                                                            const FpgaParameters& parameters,
                                                            ExploredWire wire, int first, int last);
/// Header line and one line a result.
[[nodiscard]] std::string wordLengthCsv(ExploredWire wire,
                                        const std::vector<WordLengthResult>& results);

}  // namespace ipm_mapping::fpga
