#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/cylindrical_rectification.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// A camera with a rolling shutter reads its rows one after another while the robot goes on. A row
/// that is read t after the image's stamp shows the floor as it is seen from a robot that has moved
/// by v t and turned by w t: with (c, s) the direction of azimuth a and u the velocity of the
/// camera's foot, what belongs at (a, r) of a global shutter is found at
///   a + t (r / h (s u_x - c u_y) - w),   ln r + t r / h (c u_x + s u_y),
/// to first order and for the floor; what stands on it is right at its foot. A turn shears the
/// image, and floor that was seen before the turn no longer lies on the floor of now.
class RollingShutter {
 public:
  /// So many lines beside a line, and rows below the view, may be reached that a turn of
  /// `fastest_turn` and a way of `fastest_way` are made good for a readout as `longest`, seconds.
  /// 0: none, and nothing of the view is lost.
  void configure(const CylindricalRectification& rectification, const Eigen::Vector2d& camera_foot,
                 double longest);

  /// Rectifies a raw image as a global shutter had seen it at its stamp; of rows() only. `readout`:
  /// seconds from the first row to the last, negative where the image was turned upside down.
  void rectify(CylindricalRectification& rectification, GrayView raw, const Velocity& velocity,
               double readout, ImageView<std::uint8_t> rectified);
  /// Whether that would move anything by as much as a fifth of a line or row.
  [[nodiscard]] bool matters(const Velocity& velocity, double readout) const;

  /// Whether rectify() has room for all of it: the robot does not turn or drive too fast.
  [[nodiscard]] bool reaches(const Velocity& velocity, double readout) const;
  /// Makes black what an image shows beside rows(): nobody may take it for a part of the view.
  void blankOutside(Image<std::uint8_t>& image) const;

  /// The longest readout that is made good in a fast turn.
  [[nodiscard]] double longest() const { return longest_; }
  /// What rectify() leaves of the view.
  [[nodiscard]] const std::vector<RowRange>& rows() const { return rows_; }

  static constexpr double fastest_turn = 0.8;  ///< radians per second
  static constexpr double fastest_way = 0.5;   ///< metres per second

 private:
  struct Shift {
    double lines, rows;
  };
  /// The most that anything is moved, at the near end of the view.
  [[nodiscard]] Shift most(const Velocity& velocity, double readout) const;
  [[nodiscard]] kernels::MovedRows moved(int line, const Velocity& foot, double readout) const;

  PolarGrid grid_;
  std::vector<RowRange> rows_;
  Eigen::Vector2d foot_ = Eigen::Vector2d::Zero();
  double longest_ = 0.0;
  int beside_ = 0, below_ = 0;
  std::vector<float> nearness_;  // 1 / distance of the rows
};

}  // namespace ipm_mapping::sweep
