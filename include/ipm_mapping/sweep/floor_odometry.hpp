#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/parameters/floor_odometry_parameters.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"
#include "ipm_mapping/sweep/motion_refinement.hpp"
#include "ipm_mapping/sweep/odometry_of_frame.hpp"
#include "ipm_mapping/sweep/reference_ring.hpp"

namespace ipm_mapping::sweep {

/// What one frame says about the robot's way.
struct FloorObservation {
  double stamp = 0.0;                     ///< seconds
  SE2 T_odom_base;                        ///< wheel odometry at the stamp
  const RefinedMotion* motion = nullptr;  ///< as the floor shows it; null: the frame was not used
  Kept reference = Kept::No;              ///< later motions may start from this frame
  Velocity velocity = {};                 ///< by wheel odometry, at the stamp
  double time_offset = 0.0;               ///< seconds that the stamp was moved by
};

/// Where the robot is and how fast it goes, by wheels and floor together.
struct FloorPose {
  SE2 T_odom_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, theta, axes of odom
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    ///< x, y, theta in base axes, a second
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();
};

/// Visual odometry (the source, §8.3): chains the motions that the floor shows into one trajectory,
/// which starts where wheel odometry starts.
///
/// A refined motion M spans a window, from its reference frame to now, that reaches over many
/// frames; e = odometry^-1 M is what odometry got wrong in it. Only the share w of the window that
/// no earlier frame has corrected yet counts, so that every piece of the way is corrected once:
///   T_now = T_from odometry(from, now) exp(w log e),
/// `from` = the last refined frame with w = its distance to now over the window's length, or the
/// reference with w = 1 where that is newer. In between (standing, turning, no floor) the wheels
/// lead on.
///
/// Covariance: the refinement's own, by the same shares (windows that overlap see the same floor:
/// over one window's length they are worth one window); wheel odometry's where nothing was refined;
/// and two errors that never change and therefore add up, of the scale and of the heading per
/// metre.
class FloorOdometry {
 public:
  explicit FloorOdometry(const SweepParameters& sweep = {},
                         const FloorOdometryParameters& parameters = {});

  /// New parameters from the next frame on; the pose stays, references are forgotten.
  void configure(const SweepParameters& sweep, const FloorOdometryParameters& parameters);
  /// Forgets everything: the next frame lies where wheel odometry puts it. For clocks and odometry
  /// that jumped.
  void reset();
  /// Takes every frame, in order; allocates nothing.
  const FloorPose& add(const FloorObservation& now);
  [[nodiscard]] const FloorPose& pose() const { return pose_; }

 private:
  /// A frame, how far wheel odometry had come there, and what is known of its pose.
  struct Place : OdometryOfFrame {
    double stamp = 0.0;
    double way = 0.0;    ///< metres of odometry's path since the start
    double turn = 0.0;   ///< radians turned to either side since the start
    double going = 0.0;  ///< seconds in which the wheels moved since the start
    SE2 pose;            ///< wheels and floor
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of what differs from frame to frame
    Eigen::Vector3d by_scale = Eigen::Vector3d::Zero();    ///< d pose / d scale
    Eigen::Vector3d by_turn = Eigen::Vector3d::Zero();     ///< d pose / d heading per metre
  };
  /// What the floor says that odometry got wrong between two frames.
  struct Correction {
    Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< log e, base axes of the newer frame
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    double seconds = 0.0;  ///< of the window in which the wheels moved
  };

  [[nodiscard]] Place arrive(const FloorObservation& now) const;
  [[nodiscard]] const Place* referenceAt(double stamp) const;
  [[nodiscard]] static Correction correct(const Place& reference, const RefinedMotion& motion,
                                          const Place& now);
  void followWheels(Place& now) const;
  void followFloor(const Place& reference, const Correction& correction, Place& now) const;
  static void extend(const Place& from, const SE2& delta, const Eigen::Matrix3d& noise, Place& now);
  void remember(const Place& now, Kept kept);
  void publish(const Place& now);
  void measureVelocity(const Place& now, const Correction* correction);

  MotionRefinementParameters wheels_;
  FloorOdometryParameters parameters_;
  std::vector<Place> references_;  // ring
  std::size_t next_ = 0, used_ = 0;
  Place last_;    // the frame before
  Place anchor_;  // the last refined frame, or the first one
  bool started_ = false;
  FloorPose pose_;
};

}  // namespace ipm_mapping::sweep
