#pragma once

#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/sweep_rectify.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// Half-open run of rows of one line.
struct RowRange {
  int begin = 0;
  int end = 0;
  [[nodiscard]] bool contains(int row) const { return row >= begin && row < end; }
  [[nodiscard]] int size() const { return end > begin ? end - begin : 0; }
};
[[nodiscard]] inline RowRange intersection(RowRange a, RowRange b) {
  return {a.begin > b.begin ? a.begin : b.begin, a.end < b.end ? a.end : b.end};
}

/// Element i: the rows that all of lines i ... i + lines - 1 see.
[[nodiscard]] std::vector<RowRange> commonRows(const std::vector<RowRange>& rows, int lines);
/// The same, into memory that is used again.
void commonRows(const std::vector<RowRange>& rows, int lines, std::vector<RowRange>& common);

/// Raw image to polar grid: one fixed map per camera and pose, compiled once into byte offsets and
/// weights. Each output pixel is
///   sum_k w_k B(p_k) / 128,  B = (1 2 1)/4 x (1 2 1)/4 * raw,
/// the four p_k being the raw neighbours of the pixel that sees (azimuth, r), and is brightened by
/// as much as the lens has darkened it. Rectified images are stored line by line: `at(row, line)`.
class CylindricalRectification {
 public:
  /// Builds the map; throws nothing, `grid().lines` is 0 where no floor is in view.
  void configure(const CameraModel& camera, const CameraPose& T_base_camera, const PolarGrid& grid);

  /// What rectify() begins with; after it single lines can be had.
  void load(GrayView raw);
  /// Rows `part` of a line, moved. Both lines beside it and both rows beside the part have to be in
  /// view.
  void sampleMoved(int line, RowRange part, const kernels::MovedRows& moved, std::uint8_t* out);

  /// `raw` has the calibrated size. Rows outside rows(line) are left as they are.
  void rectify(GrayView raw, ImageView<std::uint8_t> rectified) {
    rectify(raw, ranges_, rectified);
  }
  /// Of fewer rows.
  void rectify(GrayView raw, const std::vector<RowRange>& rows, ImageView<std::uint8_t> rectified);

  [[nodiscard]] const PolarGrid& grid() const { return grid_; }
  /// Rows of a line that are in view.
  [[nodiscard]] RowRange rows(int line) const { return ranges_[static_cast<std::size_t>(line)]; }
  [[nodiscard]] const std::vector<RowRange>& ranges() const { return ranges_; }
  /// When the pixel that shows a place in view is read, as a share of the readout: -0.5 the first
  /// row of the image, 0 the middle one, 0.5 the last.
  [[nodiscard]] float readTime(int row, int line) const {
    return v_.at(row, line) * readout_per_row_ - 0.5F;
  }

  /// Squared distance of the pixel that shows a place in view from the image's centre; 1 in the
  /// corners.
  [[nodiscard]] float squaredRadius(int row, int line) const {
    const float du = u_.at(row, line) - centre_u_, dv = v_.at(row, line) - centre_v_;
    return (du * du + dv * dv) / (centre_u_ * centre_u_ + centre_v_ * centre_v_);
  }
  /// From now on images are divided by 1 - shading rho^2, rho^2 their squaredRadius().
  void setShading(double shading);
  [[nodiscard]] double shading() const { return shading_; }
  /// Brings a rectified image that was divided by another shading up to date.
  void shadeAgain(double before, ImageView<std::uint8_t> rectified) const;

 private:
  void compileLine(const CameraModel& camera, const CameraPose& T_base_camera, int line);

  PolarGrid grid_;
  std::vector<RowRange> ranges_;
  Image<std::int32_t> offsets_;   // of the upper left neighbour in the pair image, bytes
  Image<std::uint32_t> weights_;  // of the four neighbours, one byte each, sum 128
  Image<float> u_, v_;            // raw pixels
  Image<std::uint16_t> gains_;    // of the output pixels
  float centre_u_ = 1.0F, centre_v_ = 1.0F;
  double shading_ = 0.0;
  float readout_per_row_ = 1.0F;
  std::vector<std::int32_t> moved_offsets_;
  std::vector<std::uint32_t> moved_weights_;
  Image<std::uint8_t> smooth_;  // B
  Image<std::uint16_t> pairs_;  // B(u, v) | B(u, v + 1) << 8
};

}  // namespace ipm_mapping::sweep
