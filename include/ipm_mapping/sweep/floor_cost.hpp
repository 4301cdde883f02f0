#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"
#include "ipm_mapping/sweep/foot_motion.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// Brightness of the current view over that of a reference: I_c = gain I_r + offset.
struct Photometric {
  double gain = 1.0;
  double offset = 0.0;  ///< grey levels
  /// Beyond that, views are not compared as they should be.
  [[nodiscard]] bool withinBounds() const;
  /// In the units of the kernels, 2^14 for a gain of one and for an offset of one grey level.
  [[nodiscard]] std::int32_t fixedGain() const;
  [[nodiscard]] std::int32_t fixedOffset() const;
};

/// What is known about the current frame on the sweep rows.
struct CurrentView {
  ImageView<const std::int16_t> grey;           ///< sweepRows x lines, 1/32 grey levels
  ImageView<const std::uint16_t> weight;        ///< of the noise model
  const std::vector<RowRange>* rows = nullptr;  ///< valid sweep rows of each line
  ImageView<const std::int32_t> sums{};         ///< BeamSums of grey, one of every beam
};

/// Does this column look like floor? The reference is warped over the floor; per pixel
///   F = min(min(e, e - mean(e))^2 / variance, 9), e = I_c - (gain I_r + offset),
/// mean(e) over the neighbourhood (a highlight or shadow that drifts over the floor is a nuisance
/// that the floor may explain), averaged over the eight lines of a beam.
class FloorCost {
 public:
  void configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                 const EvidenceParameters& parameters);

  /// `cost` is sweepRows x beams, kernels::cost_unit for 1 sigma^2, kernels::no_cost where a pixel
  /// of the beam was not seen in both views. `reference` is a rectified image, `reference_rows`
  /// what it sees of each line where that is less than the view.
  void evaluate(const CurrentView& current, ImageView<const std::uint8_t> reference,
                const FootMotion& motion, const Photometric& photometric,
                ImageView<std::uint16_t> cost,
                const std::vector<RowRange>* reference_rows = nullptr);

  /// The residual of the last evaluation, sweepRows x lines, 1/32 grey levels, no_residual where
  /// there is none.
  [[nodiscard]] ImageView<const std::int16_t> residual() const { return residual_.view(); }

 private:
  void buildNodes(const FootMotion& motion);
  void nodesOf(int line);
  [[nodiscard]] RowRange seenInBoth(const std::vector<RowRange>& reference, RowRange rows) const;
  void compare(const CurrentView& current, const Photometric& photometric,
               const std::vector<RowRange>& reference_rows);
  void accumulate(int line, int sign);
  void squaresOf(const CurrentView& current, int line);
  [[nodiscard]] RowRange comparedByAll(int beam) const;

  PolarGrid grid_;
  std::vector<RowRange> reference_rows_;
  int beam_step_ = 1, half_lines_ = 0, half_rows_ = 0;
  int node_rows_ = 0, node_lines_ = 0;
  Image<std::int32_t> row_nodes_, line_nodes_;  // reference position of every 8th row and line
  std::vector<float> inverse_distance_, line_position_, row_position_;  // of a line of nodes
  std::vector<std::int32_t> rows_here_, lines_here_, row_path_, line_path_;
  Image<std::uint16_t> pairs_;      // of the reference
  std::vector<RowRange> compared_;  // rows of every line that both views see
  Image<std::int16_t> residual_;
  std::vector<std::int32_t> sum_, number_;  // over the lines of a window, half_rows_ of margin
  std::vector<std::int32_t> sum_before_, number_before_;  // of the rows before each row
  std::vector<std::int16_t> mean_;                        // of a line
  std::vector<std::uint16_t> squares_;
};

}  // namespace ipm_mapping::sweep
