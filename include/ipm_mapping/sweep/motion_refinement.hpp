#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/geometry/se2.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/sweep_alignment.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/foot_motion.hpp"
#include "ipm_mapping/sweep/lens_shading.hpp"
#include "ipm_mapping/sweep/local_mean.hpp"
#include "ipm_mapping/sweep/odometry_of_frame.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"
#include "ipm_mapping/sweep/sway.hpp"

namespace ipm_mapping::sweep {

/// A rectified frame with what is needed to compare it with another.
struct RectifiedFrame : OdometryOfFrame {
  Image<std::uint8_t> image;  ///< rows x lines of the polar grid
  LocalMean mean;
  double readout = 0.0;  ///< seconds: the rolling shutter that has been undone
  bool sheared = false;  ///< too fast for all of it to be undone
  SE2 T_floor_base;      ///< the same by chaining refined motions
  double stamp = 0.0;
  double stood = 0.0;  ///< seconds until then in which the robot stood and looked on
  double went = 0.0;   ///< seconds until then in which odometry changed

  /// Seconds by which another frame is newer, but for what the robot stood in between.
  [[nodiscard]] double age(const RectifiedFrame& newer) const {
    return (newer.stamp - newer.stood) - (stamp - stood);
  }
};

/// Motion between two frames as the floor shows it.
struct RefinedMotion {
  SE2 motion;  ///< pose of the current base in the reference's
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of x, y, theta
  Sway sway;  ///< of the robot in the reference against the current frame
  Photometric photometric;
  double sigma = 0.0;            ///< robust spread of the floor's residual, grey levels
  int samples = 0;               ///< floor pixels that both frames see
  bool refined = false;          ///< false: too little floor, the motion is odometry's
  double reference_stamp = 0.0;  ///< seconds: of the frame that the motion starts from
};

/// Aligns the floor of two frames: Gauss-Newton over (x, y, theta, sway, gain, offset) on
/// high-passed images, Tukey weights with a spread from the median, odometry as prior:
///   min sum_i rho(I_c(p_i) - gain I_r(w(p_i; x, y, theta, sway)) - offset) * correlation / sigma^2
///       + |(x, y, theta) - odometry|^2 / sd^2 + |sway|^2 / sd_sway^2
///       + ((gain - 1) / sd_gain)^2 + (offset / sd_offset)^2.
/// y and theta look nearly the same on the floor; wheels do not slide sideways, so that y is known
/// once theta is, and that separates them. Distance, heading and sway have heavy tails: wheels
/// slip, and robots stand still or nod. Then gain and offset alone on the plain images.
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
  [[nodiscard]] std::size_t mostSamples() const { return points_.size(); }
  /// The floor that the last refine(), whose answer it was, has compared; for as long as there is
  /// no other one.
  [[nodiscard]] FloorSamples floor(const RefinedMotion& motion);

 private:
  /// A fixed floor point of the current view.
  struct FloorPoint {
    int row, line;
  };
  /// The same while two frames are aligned: position in the reference is linear in the correction.
  struct Samples {
    using Array = std::vector<float>;
    using Moves = std::array<Array, kernels::alignment_moves>;
    int count = 0;
    std::vector<int> seen_row, seen_line;         // in the current frame
    Array row, line;                              // in the reference, at the linearisation point
    Moves d_row, d_line;                          // by x, y, theta, pitch, roll
    Array current, current_high, reference_mean;  // high: without the local mean
    Array warped, warped_high;                    // of the reference
    Moves gradient;                               // of its grey level by the same
    Array deviation;

    void resize(std::size_t n);
    void move(std::size_t from, std::size_t to);
    kernels::SamplePositions positions();
  };
  /// Of x, y, theta, pitch and roll.
  using Correction = Eigen::Matrix<double, kernels::alignment_moves, 1>;
  /// Those, gain and offset.
  using Unknowns = Eigen::Matrix<double, kernels::alignment_unknowns, 1>;
  using Normal = Eigen::Matrix<double, kernels::alignment_unknowns, kernels::alignment_unknowns>;
  struct Prior;

  void linearize(const RectifiedFrame& current, const RectifiedFrame& reference, const SE2& motion);
  [[nodiscard]] kernels::FloorProjection projection(const SE2& motion) const;
  [[nodiscard]] bool inView(float row, float line) const;
  void warp(const RectifiedFrame& reference, const Correction& correction);
  [[nodiscard]] kernels::AlignmentResidual residual(const Photometric& photometric,
                                                    bool high_pass) const;
  void normalEquations(RefinedMotion& state, bool high_pass, double limit, Normal& A, Unknowns& b);
  void step(const Prior& prior, const SE2& base, Correction& correction, RefinedMotion& state);
  [[nodiscard]] double medianOf(const std::vector<float>& grey);
  void fitBrightness(double gain, RefinedMotion& state);
  void fitBrightness(RefinedMotion& state);

  PolarGrid grid_;
  std::vector<RowRange> rows_;
  Eigen::Vector2d foot_ = Eigen::Vector2d::Zero();
  MotionRefinementParameters parameters_;
  double anneal_ = 0.0;
  std::vector<FloorPoint> points_;
  std::vector<int> floor_begin_;
  std::vector<float> x_, y_;  // of the points, around the camera's foot
  Samples samples_;
};

}  // namespace ipm_mapping::sweep
