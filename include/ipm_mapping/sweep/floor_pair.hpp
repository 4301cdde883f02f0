#pragma once

#include <Eigen/Core>
#include <vector>

#include "ipm_mapping/parameters/calibration_parameters.hpp"
#include "ipm_mapping/sweep/calibration_state.hpp"
#include "ipm_mapping/sweep/floor_warp.hpp"
#include "ipm_mapping/sweep/motion_refinement.hpp"

namespace ipm_mapping::sweep {

/// Knowledge about the calibration, as a quadratic: 1/2 x' information x - vector' x.
struct CalibrationInformation {
  CalibrationMatrix information = CalibrationMatrix::Zero();
  CalibrationVector vector = CalibrationVector::Zero();

  [[nodiscard]] CalibrationVector mean() const;
  [[nodiscard]] CalibrationMatrix covariance() const;
  /// The state is known to be this.
  [[nodiscard]] static CalibrationInformation certainly(const CalibrationVector& state);
};

/// Two frames and what odometry says about the way between them.
struct FramePair {
  const RectifiedFrame& current;
  const RectifiedFrame& reference;

  /// If the images were taken `time_offset` seconds after the camera's stamps.
  [[nodiscard]] SE2 odometry(double time_offset) const {
    return reference.poseMovedBy(time_offset).inverse() * current.poseMovedBy(time_offset);
  }
  /// In which odometry may have gone wrong: not while it stood still.
  [[nodiscard]] double seconds() const { return current.went - reference.went; }
};

/// What one pair of frames says.
struct PairEvidence {
  bool used = false;             ///< false: too little floor that fits
  CalibrationInformation about;  ///< motion, sway, brightness eliminated; without what was known
  CalibrationVector state = CalibrationVector::Zero();  ///< with what was known
  SE2 motion;  ///< of the base, pose of the current one in the reference's
  Eigen::Vector2d sway = Eigen::Vector2d::Zero();  ///< of pitch and roll between the frames
  double sigma = 0.0;                              ///< robust spread of the residual, grey levels
  double likeness = 0.0;  ///< correlation of the two views' floor where it fits
  int samples = 0;        ///< floor pixels that fit
};

/// Aligns the floor of two frames over calibration, motion and brightness at once: Gauss-Newton on
/// high-passed images with Tukey weights,
///   min sum_i rho(I_c(p_i) - gain I_r(w(p_i; state, motion, sway)) - offset) correlation / sigma^2
///       + |motion - corrected(odometry, state)|^2 / sd^2 + |sway|^2 / sd^2 + ... of the brightness
///       + what is known about the state,
/// then eliminates all but the state (Schur complement).
class FloorPair {
 public:
  /// `rectified_with`: the correction that the grid's pose has over the stated one; `rows`: what
  /// the frames show. The rectification has to stay where it is.
  void configure(const CylindricalRectification& rectification, const std::vector<RowRange>& rows,
                 const StatedCamera& stated, const CalibrationVector& rectified_with,
                 const CalibrationParameters& parameters, const MotionRefinementParameters& noise);

  /// `known` about the state; `start`: where the search begins.
  [[nodiscard]] PairEvidence evaluate(const FramePair& pair, const CalibrationInformation& known,
                                      const CalibrationVector& start);

  [[nodiscard]] const std::vector<RowRange>& rows() const { return rows_; }
  [[nodiscard]] const PolarGrid& grid() const { return grid_; }
  /// The farthest row that takes part.
  [[nodiscard]] int firstRow() const { return first_row_; }
  /// From the current view to the reference's.
  [[nodiscard]] FloorWarp warp(const FramePair& pair, const CalibrationVector& state,
                               const SE2& motion, const Eigen::Vector2d& sway) const;
  /// Where the floor at a place of the current view is seen; false where the reference does not.
  [[nodiscard]] bool place(const FloorWarp& floor, double row, double line,
                           FloorWarp::Position& at) const {
    return place(floor, {static_cast<float>(row), static_cast<float>(line), direction(row, line)},
                 at);
  }
  /// A position whose four neighbours the reference sees.
  [[nodiscard]] bool inView(const FloorWarp::Position& position) const;
  [[nodiscard]] Eigen::Vector3d direction(double row, double line) const {
    return statedDirection(grid_, stated_, rectified_with_, row, line);
  }

 private:
  static constexpr int shared = CalibrationIndex::count;
  static constexpr int seen = FloorWarp::count + 2;  ///< what a pixel's residual depends on
  static constexpr int own = 7;                      ///< motion, sway, gain, offset
  static constexpr int all = shared + own;
  using Seen = Eigen::Matrix<double, seen, 1>;
  using SeenMatrix = Eigen::Matrix<double, seen, seen>;
  using All = Eigen::Matrix<double, all, 1>;
  using AllMatrix = Eigen::Matrix<double, all, all>;

  struct FloorPoint {
    float row, line;
    Eigen::Vector3d direction;
  };
  bool place(const FloorWarp& floor, const FloorPoint& point, FloorWarp::Position& at) const;
  [[nodiscard]] double readTime(double row, double line) const {
    return static_cast<double>(
        rectification_->readTime(static_cast<int>(row + 0.5), static_cast<int>(line + 0.5)));
  }
  struct Guess {
    CalibrationVector state;
    SE2 motion;
    Eigen::Vector2d sway = Eigen::Vector2d::Zero();
    Photometric photometric;
    double sigma;
    void add(const All& delta);
  };
  struct Normal {
    AllMatrix A = AllMatrix::Zero();
    All b = All::Zero();
  };
  struct PixelSums {
    SeenMatrix A = SeenMatrix::Zero();
    Seen b = Seen::Zero();
    int fitting = 0;
    double cc = 0.0, cr = 0.0, rr = 0.0;  ///< products of the two grey levels
    void add(double weight, double residual, const Seen& J);
    [[nodiscard]] double likeness() const;
    void addTo(Normal& normal, double information) const;
  };

  PixelSums addPixels(const FramePair& pair, const Guess& guess, double limit);
  double spread();
  void addOdometry(const FramePair& pair, const Guess& guess, Normal& normal) const;
  void addRest(const Guess& guess, Normal& normal) const;
  static CalibrationInformation marginal(const Normal& normal, const CalibrationVector& state);

  PolarGrid grid_;
  std::vector<RowRange> rows_;
  const CylindricalRectification* rectification_ = nullptr;
  StatedCamera stated_;
  CalibrationVector rectified_with_ = CalibrationVector::Zero();
  CalibrationParameters parameters_;
  MotionRefinementParameters noise_;
  int first_row_ = 0;
  std::vector<FloorPoint> points_;
  std::vector<float> deviations_;
};

}  // namespace ipm_mapping::sweep
