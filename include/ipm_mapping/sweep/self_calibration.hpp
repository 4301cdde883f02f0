#pragma once

#include <vector>

#include "ipm_mapping/calibration_report.hpp"
#include "ipm_mapping/parameters/calibration_parameters.hpp"
#include "ipm_mapping/sweep/floor_pair.hpp"
#include "ipm_mapping/sweep/reference_ring.hpp"

namespace ipm_mapping::sweep {

/// Pitch, roll, heading and height of the camera, scale and heading drift of odometry, readout time
/// and stamps of the images, from how the floor moves between frames: an information filter over
/// pairs of frames, a new one every `spacing` of way. The prior never fades, evidence does.
///
/// The floor shows the way only in camera heights. Either the stated height is right, and
/// odometry's scale makes up for what is off, or, when that had to be more than `sd_scale`, the
/// height is held to be wrong, and odometry is trusted to `sd_scale`. Frames are aligned without
/// that judgement, and compared often until it is clear.
class SelfCalibration {
 public:
  SelfCalibration(const CalibrationParameters& parameters, const MotionRefinementParameters& noise)
      : parameters_(parameters), noise_(noise) {}

  /// A new stated pose: forgets everything but the camera's own, its readout time and its clock.
  void setCamera(const CameraPose& T_base_camera);
  /// Another camera: forgets that, too.
  void forgetCamera() { learnt_ = {}; }
  /// What another one has learnt about the same stated pose with the same priors is known from now
  /// on. True if its correction may stay in force.
  bool adopt(const SelfCalibration& other);
  /// How frames are rectified from now on: with corrected(stated pose, rectified_with). What was
  /// learnt stays.
  void configure(const CylindricalRectification& rectification, const std::vector<RowRange>& rows,
                 const CalibrationVector& rectified_with);
  /// Poses or clock jumped: what was learnt stays.
  void reset() { seen_any_ = false; }

  /// Compares the frame with an earlier one where the robot has driven far enough; true if
  /// something was learnt.
  bool offer(const RectifiedFrame& current, const ReferenceRing& ring);

  [[nodiscard]] const CalibrationVector& state() const { return learnt_.state; }
  [[nodiscard]] const CalibrationMatrix& covariance() const { return learnt_.covariance; }
  [[nodiscard]] double sigma(int index) const {
    return std::sqrt(learnt_.covariance(index, index));
  }
  /// Of height over odometry's way, relative.
  [[nodiscard]] double ratioSigma() const;
  [[nodiscard]] int pairs() const { return learnt_.pairs; }
  /// Enough pairs, and no farther from the stated pose than the bounds allow.
  [[nodiscard]] bool believable() const;
  [[nodiscard]] bool confident() const;
  /// The estimate is worth working with instead of the one in force.
  [[nodiscard]] bool worthApplying() const;
  /// How the camera's true attitude differs from the one in force, as far as is known; none before
  /// the first pair.
  [[nodiscard]] Sway remainingTilt() const;
  /// How long the camera takes to read an image, as far as is known, seconds.
  [[nodiscard]] double readout() const {
    return parameters_.readout_time + learnt_.state[CalibrationIndex::ReadoutTime];
  }
  /// That is surely and usefully another than the one in force.
  [[nodiscard]] bool readoutDiffers(double in_force) const;
  /// How long after its stamp an image was taken, as far as is known and allowed, seconds.
  [[nodiscard]] double timeOffset() const;
  [[nodiscard]] double mostTimeOffset() const { return parameters_.max_time_offset; }
  /// The same of it.
  [[nodiscard]] bool timeOffsetDiffers(double in_force) const;
  /// The correction that frames are rectified with.
  [[nodiscard]] const CalibrationVector& inForce() const { return rectified_with_; }
  /// Beside the stated pose.
  [[nodiscard]] CalibrationReport report() const;

  /// What the last pair said.
  [[nodiscard]] const PairEvidence& lastPair() const { return evidence_; }
  /// The other frame of that pair; valid until the ring takes the next frame.
  [[nodiscard]] const RectifiedFrame* lastReference() const { return reference_; }
  [[nodiscard]] FloorPair& floor() { return pair_; }

 private:
  struct Learnt {
    CalibrationInformation evidence;
    bool wrong_height = false, height_in_doubt = false;
    CalibrationVector aligned = CalibrationVector::Zero();  ///< without judging the height
    CalibrationVector state = CalibrationVector::Zero();
    CalibrationMatrix covariance = CalibrationMatrix::Identity();
    int pairs = 0, refused = 0;
  };

  [[nodiscard]] double baseline() const;
  [[nodiscard]] bool bounded() const;
  [[nodiscard]] bool due(const RectifiedFrame& current) const;
  [[nodiscard]] bool telling(const Velocity& velocity) const;
  [[nodiscard]] CalibrationInformation known() const;
  [[nodiscard]] CalibrationInformation knownOfTheCamera() const;
  void judgeHeight(const CalibrationInformation& known);
  void compare(const FramePair& pair);
  void learn();
  void forget();

  CalibrationParameters parameters_;
  MotionRefinementParameters noise_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  StatedCamera stated_;
  FloorPair pair_;
  CalibrationVector rectified_with_ = CalibrationVector::Zero();
  CalibrationInformation prior_, prior_right_height_;
  Learnt learnt_;
  PairEvidence evidence_;
  const RectifiedFrame* reference_ = nullptr;
  SE2 last_pair_;
  Velocity last_velocity_;
  bool seen_any_ = false;
};

}  // namespace ipm_mapping::sweep
