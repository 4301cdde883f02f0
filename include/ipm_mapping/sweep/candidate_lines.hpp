#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/beam_sums.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/foot_motion.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

inline constexpr double half_beam = 0.5 * (kernels::beam_lines - 1);  ///< lines to its middle

/// A reference view on the sweep rows, brightness already that of the current view.
struct SweepReference {
  ImageView<const std::int16_t> even, odd;    ///< fine rows 2j and 2j + 1
  ImageView<const std::uint16_t> floor_cost;  ///< sweepRows x beams
  FootMotion motion;
  /// What it sees, as commonRows() of a beam's lines and one more, where that is less than the
  /// view.
  const std::vector<RowRange>* rows = nullptr;
  ImageView<const std::int32_t> sums{};  ///< BeamSums of even; empty: brightness is taken as it is
  double stamp = 0.0;

  [[nodiscard]] RowRange seen(std::size_t line, const std::vector<RowRange>& view) const {
    return rows != nullptr ? (*rows)[line] : view[line];
  }
};

/// Where the vertical lines that stand at the candidates of a beam lie in the references: lines of
/// the reference beside the eight of the beam, their rows moved by ln(d / d').
class CandidateLines {
 public:
  static constexpr int max_references = 2;
  static constexpr int least_patch = 4;  ///< rows that tell a brightness

  /// `reference_rows` of the fine rows; `inverse_distance` of every candidate, 1/m.
  void configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                 const std::vector<float>& inverse_distance);

  /// Takes the candidates of a beam whose lines in the current view begin at `first_line`.
  void aimBeam(const CurrentView& current, const SweepReference* references, int count, int beam,
               int first_line);
  /// Takes the line of one of them, on the sweep rows of its support that the references see.
  void aim(const SweepReference* references, int count, int candidate, RowRange support);
  /// The surface there may have become brighter or darker, by at most `most` 1/32 grey levels, as
  /// the mean over a patch of its rows shows.
  void allowForBrightness(const SweepReference* references, int count, int candidate,
                          RowRange patch, std::int32_t most);
  /// It has not.
  void sameBrightness(int count);
  /// Brings what allowForBrightness() will read of a candidate near, while another one is worked
  /// on.
  void fetchBrightness(const SweepReference* references, int count, int candidate,
                       RowRange patch) const;

  [[nodiscard]] const kernels::EvidencePath* paths() const { return paths_.data(); }

 private:
  /// First line, and by how many fine rows it is moved; fractions in 1/2^15.
  struct Places {
    std::vector<std::int32_t> line, shift, line_fraction, row_fraction;
  };
  void place(const FootMotion& motion, double azimuth, Places& places);
  void aim(const SweepReference& reference, const Places& places, std::size_t candidate,
           RowRange support, kernels::EvidencePath& path);
  [[nodiscard]] std::size_t within(int candidate) const;

  PolarGrid grid_;
  int candidates_ = 0;
  std::vector<RowRange> reference_rows_;  // fine rows that nine lines see, from each line on
  std::vector<float> inverse_distance_;
  std::vector<float> line_position_, row_position_;
  const std::int32_t* sums_ = nullptr;  // of the current view, the beam's
  std::array<Places, max_references> places_;
  std::array<kernels::EvidencePath, max_references> paths_;
};

}  // namespace ipm_mapping::sweep
