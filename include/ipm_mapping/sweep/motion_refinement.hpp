#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/foot_motion.hpp"
#include "ipm_mapping/sweep/local_mean.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// A rectified frame with what is needed to compare it with another.
struct RectifiedFrame {
  Image<std::uint8_t> image;  ///< rows x lines of the polar grid
  LocalMean mean;
  SE2 T_odom_base;
  SE2 T_floor_base;  ///< the same by chaining refined motions
  double stamp = 0.0;
};

/// Motion between two frames as the floor shows it.
struct RefinedMotion {
  SE2 motion;  ///< pose of the current base in the reference's
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, theta
  Photometric photometric;
  double sigma = 0.0;            ///< robust spread of the floor's residual, grey levels
  int samples = 0;               ///< floor pixels that both frames see
  bool refined = false;          ///< false: too little floor, the motion is odometry's
  double reference_stamp = 0.0;  ///< seconds: of the frame that the motion starts from
};

/// Aligns the floor of two frames: Gauss-Newton over (x, y, theta, gain, offset) on high-passed
/// images, Tukey weights with a spread from the median, odometry as prior:
///   min sum_i rho(I_c(p_i) - gain I_r(w(p_i; x, y, theta)) - offset) * correlation / sigma^2
///       + |(x, y, theta) - odometry|^2 / sd^2 + ((gain - 1) / sd_gain)^2 + (offset / sd_offset)^2.
/// y and theta look nearly the same on the floor; wheels do not slide sideways, so that y is known
/// once theta is, and that separates them. Distance and heading have heavy tails: wheels slip.
/// Then gain and offset alone on the plain images.
class MotionRefinement {
 public:
  void configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                 const Eigen::Vector2d& camera_foot, const MotionRefinementParameters& parameters);

  /// Floor of a line begins at this row: what lies farther stands behind a contact. 0: all of it.
  void setFloorBegin(int line, int row) { floor_begin_[static_cast<std::size_t>(line)] = row; }
  void forgetFloor() { floor_begin_.assign(floor_begin_.size(), 0); }

  /// `odometry` is the prior, `start` where the search begins: what is known from refining the
  /// frames in between. Where floor is missing the answer is odometry's.
  [[nodiscard]] RefinedMotion refine(const RectifiedFrame& current, const RectifiedFrame& reference,
                                     const SE2& odometry, const SE2& start);

 private:
  /// A fixed floor point of the current view.
  struct FloorPoint {
    int row, line;
    double x, y;  // around the camera's foot
  };
  /// The same while two frames are aligned: position in the reference is linear in the correction.
  struct Sample {
    float current, current_mean, reference_mean;
    float row, line;            // in the reference, at the linearisation point
    float d_row[3], d_line[3];  // by x, y, theta
    float gradient[3];          // of the reference's grey level by x, y, theta
    float warped;
  };
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  struct Prior;

  void linearize(const RectifiedFrame& current, const RectifiedFrame& reference, const SE2& motion);
  bool linearizeOne(const FloorPoint& point, const FootMotion& foot,
                    const RectifiedFrame& reference, Sample& sample) const;
  void warp(const RectifiedFrame& reference, const Eigen::Vector3d& correction);
  double spread(const RefinedMotion& state, bool high_pass);
  void step(const Prior& prior, const SE2& base, Eigen::Vector3d& correction, RefinedMotion& state);
  void fitBrightness(RefinedMotion& state);

  PolarGrid grid_;
  std::vector<RowRange> rows_;
  Eigen::Vector2d foot_ = Eigen::Vector2d::Zero();
  MotionRefinementParameters parameters_;
  double anneal_ = 0.0;
  std::vector<FloorPoint> points_;
  std::vector<int> floor_begin_;
  std::vector<Sample> samples_;
  std::vector<float> deviations_;
};

}  // namespace ipm_mapping::sweep
