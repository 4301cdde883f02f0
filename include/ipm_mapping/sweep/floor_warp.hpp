#pragma once

#include <Eigen/Core>
#include <cmath>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/sweep/calibration_state.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"

namespace ipm_mapping::sweep {

/// How the robot moves while the rows of two images are read, and what of the readout is still in
/// them: seconds from the first row to the last.
struct ReadoutOfPair {
  Velocity current, reference;
  double current_seconds = 0.0, reference_seconds = 0.0;

  [[nodiscard]] bool moving() const { return current.moving() || reference.moving(); }
};
/// The motion between a current and a reference view of a robot that moves on in both.
class MovingPair {
 public:
  MovingPair(const SE2& motion, const Velocity& current, const Velocity& reference)
      : motion_(motion),
        current_(current),
        reference_(reference),
        c_(std::cos(motion.theta)),
        s_(std::sin(motion.theta)) {}

  /// How (x, y, theta) differs if the views are taken so many seconds later, to first order:
  ///   R v_c t_c - v_r t_r + w_r t_r (y, -x),   w_c t_c - w_r t_r.
  [[nodiscard]] Eigen::Vector3d after(double current, double reference) const {
    const Velocity &vc = current_, &vr = reference_;
    return {current * (c_ * vc.x - s_ * vc.y) - reference * (vr.x - vr.theta * motion_.y),
            current * (s_ * vc.x + c_ * vc.y) - reference * (vr.y + vr.theta * motion_.x),
            current * vc.theta - reference * vr.theta};
  }

 private:
  SE2 motion_;
  Velocity current_, reference_;
  double c_, s_;
};
/// When a place was read in the two views, as shares of the readout before or after the stamp.
struct ReadTimes {
  double current = 0.0, reference = 0.0;
};

/// Where the reference view sees a floor point of the current view, exactly, when the pose that
/// both views were rectified with is off. A pixel's direction stays what the lens makes it; which
/// floor point it is taken for depends on tilt and height, in both views:
///   p = h n_xy / -n_z,  n = tilt * direction;   p_ref = R(theta) p + t;
///   direction_ref = tilt^-1 sway^-1 (p_ref, -h),
/// sway: how the robot's pitch and roll differ between the two, for it is not quite rigid. What is
/// read t after the stamp is seen by a robot that has gone on by v t and turned by w t: the motion
/// from one view to the other then differs from row to row (MovingPair).
class FloorWarp {
 public:
  /// Columns of the derivatives.
  enum : int { Pitch, Roll, Yaw, LogHeight, X, Y, Theta, SwayPitch, SwayRoll, ReadoutTime, count };
  struct Position {
    double row = 0.0, line = 0.0;  ///< in the reference's grid
    Eigen::Vector3d n, v, g;  ///< current direction; floor point from the reference, true, grid
    double c = 1.0, s = 0.0, tx = 0.0,
           ty = 0.0;             ///< the motion between the two rows, around the foot
    Eigen::Vector3d by_readout;  ///< how that motion moves with the readout time
  };
  using Slopes = Eigen::Matrix<double, 2, count>;  ///< of row and line

  /// `rectified_with`: the correction that the grid's pose has over the stated one already.
  FloorWarp(const PolarGrid& grid, const StatedCamera& stated, const CalibrationVector& state,
            const CalibrationVector& rectified_with, const SE2& motion,
            const Eigen::Vector2d& sway = Eigen::Vector2d::Zero(),
            const ReadoutOfPair& readout = {});

  /// `direction` in base axes of the stated pose; false where it does not meet the floor.
  bool operator()(const Eigen::Vector3d& direction, Position& position,
                  const ReadTimes& times = {}) const;
  [[nodiscard]] bool rolling() const { return readout_.moving(); }
  /// How a position moves with what is estimated.
  [[nodiscard]] Slopes slopes(const Position& position) const;

 private:
  void moveBetweenRows(const ReadTimes& times, Position& at) const;

  const PolarGrid& grid_;
  Eigen::Matrix3d tilt_, turning_, axes_, grid_from_true_;
  Eigen::Vector2d foot_;
  double height_;
  SE2 motion_;
  ReadoutOfPair readout_;
  MovingPair moving_;
};

/// Direction of a grid position in base axes of the stated pose.
[[nodiscard]] Eigen::Vector3d statedDirection(const PolarGrid& grid, const StatedCamera& stated,
                                              const CalibrationVector& rectified_with, double row,
                                              double line);

}  // namespace ipm_mapping::sweep
