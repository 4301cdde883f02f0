#include "ipm_mapping/sweep/self_calibration.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

using I = CalibrationIndex;

}  // namespace

void SelfCalibration::setCamera(const CameraPose& T_base_camera) {
  stated_ = StatedCamera(T_base_camera);
  T_base_camera_ = T_base_camera;
  const CalibrationParameters& p = parameters_;
  CalibrationVector sd;
  sd << p.sd_pitch, p.sd_roll, p.sd_yaw, p.sd_height_wrong / stated_.height, p.sd_scale,
      p.sd_turn_scale, p.sd_yaw_rate;
  prior_.information = sd.cwiseAbs2().cwiseInverse().asDiagonal();
  sd[I::LogHeight] = p.sd_height / stated_.height;
  prior_right_height_.information = sd.cwiseAbs2().cwiseInverse().asDiagonal();
  forget();
  reset();
}

void SelfCalibration::forget() {
  learnt_ = {};
  aligned_.setZero();
  state_.setZero();
  covariance_ = prior_.covariance();
  pairs_ = refused_ = 0;
  wrong_height_ = height_in_doubt_ = false;
}

void SelfCalibration::configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                                const CalibrationVector& rectified_with) {
  rectified_with_ = rectified_with;
  pair_.configure(grid, rows, stated_, rectified_with, parameters_, noise_);
}

/// Short while the views would not overlap under the pitch that is possible, and never more than
/// twice as long as the pair before: the first ones have to come soon.
double SelfCalibration::baseline() const {
  const CalibrationParameters& p = parameters_;
  const double share = std::min(p.sd_pitch / sigma(I::Pitch), std::exp2(pairs_));
  return stated_.height * std::clamp(p.short_baseline * share, p.short_baseline, p.long_baseline);
}

bool SelfCalibration::due(const SE2& pose) const {
  if (!seen_any_) return true;
  const CalibrationParameters& p = parameters_;
  const double spacing = confident() && !height_in_doubt_
                             ? stated_.height * p.settled_spacing
                             : std::min(baseline(), stated_.height * p.spacing);
  return std::hypot(pose.x - last_pair_.x, pose.y - last_pair_.y) >= spacing;
}

CalibrationInformation SelfCalibration::known() const {
  return {prior_.information + learnt_.information, prior_.vector + learnt_.vector};
}

bool SelfCalibration::offer(const RectifiedFrame& current, const ReferenceRing& ring) {
  if (!due(current.T_odom_base)) return false;
  reference_ = ring.find(current.T_odom_base, current.stamp, baseline());
  if (reference_ == nullptr) return false;
  seen_any_ = true;
  last_pair_ = current.T_odom_base;
  compare({current, *reference_});
  if (evidence_.used) {
    refused_ = 0;
    learn();
  } else if (++refused_ > parameters_.least_pairs && pairs_ < parameters_.least_pairs) {
    forget();
  }
  return evidence_.used;
}

/// The first pair of all is aligned from several starts: the views may lie pixels apart.
void SelfCalibration::compare(const FramePair& pair) {
  evidence_ = pair_.evaluate(pair, known(), aligned_);
  if (pairs_ > 0) return;
  for (const double pitch : {-1.0, 0.0, 1.0}) {
    for (const double height : {-1.0, 0.0, 1.0}) {
      CalibrationVector start = CalibrationVector::Zero();
      start[I::Pitch] = pitch * parameters_.sd_pitch;
      start[I::LogHeight] = height * parameters_.sd_height_wrong / stated_.height;
      const PairEvidence other = pair_.evaluate(pair, known(), start);
      if (other.likeness * other.samples > evidence_.likeness * evidence_.samples)
        evidence_ = other;
    }
  }
}

void SelfCalibration::learn() {
  const double kept = 1.0 - 1.0 / parameters_.memory;
  learnt_.information = kept * learnt_.information + evidence_.about.information;
  learnt_.vector = kept * learnt_.vector + evidence_.about.vector;
  CalibrationInformation all = known();
  aligned_ = all.mean();
  judgeHeight(all);
  if (!wrong_height_) all.information += prior_right_height_.information - prior_.information;
  state_ = all.mean();
  covariance_ = all.covariance();
  ++pairs_;
}

/// With some reluctance to change the mind.
void SelfCalibration::judgeHeight(const CalibrationInformation& known) {
  const CalibrationMatrix P = known.covariance();
  const double ratio = std::abs(aligned_[I::LogHeight] - aligned_[I::LogScale]);
  const double variance = P(I::LogHeight, I::LogHeight) + P(I::LogScale, I::LogScale) -
                          2.0 * P(I::LogHeight, I::LogScale);
  const double sigma = std::sqrt(std::max(0.0, variance)), limit = parameters_.sd_scale + sigma;
  wrong_height_ = ratio > (wrong_height_ ? 0.8 : 1.0) * limit;
  height_in_doubt_ = std::abs(ratio - parameters_.sd_scale) < sigma;
}

double SelfCalibration::ratioSigma() const {
  const double variance = covariance_(I::LogHeight, I::LogHeight) +
                          covariance_(I::LogScale, I::LogScale) -
                          2.0 * covariance_(I::LogHeight, I::LogScale);
  return std::sqrt(std::max(0.0, variance));
}

bool SelfCalibration::bounded() const {
  const double height = stated_.height * std::expm1(state_[I::LogHeight]);
  return state_.head<3>().cwiseAbs().maxCoeff() <= parameters_.max_tilt &&
         std::abs(height) <= parameters_.max_height;
}

bool SelfCalibration::believable() const { return pairs_ >= parameters_.least_pairs && bounded(); }

bool SelfCalibration::confident() const {
  return believable() && sigma(I::Pitch) <= parameters_.confident_tilt &&
         ratioSigma() <= parameters_.confident_height;
}

bool SelfCalibration::worthApplying() const {
  const CalibrationParameters& p = parameters_;
  if (pairs_ == 0 || !bounded()) return false;
  const CalibrationVector change = (state_ - rectified_with_).cwiseAbs();
  const double sigmas = confident() ? 1.0 : p.early_sigmas;
  const double pitch = sigmas * sigma(I::Pitch), roll = sigmas * sigma(I::Roll);
  const double height = stated_.height * sigmas * ratioSigma();
  return change[I::Pitch] > std::max(p.apply_tilt, pitch) ||
         change[I::Roll] > std::max(p.apply_tilt, roll) ||
         stated_.height * change[I::LogHeight] > std::max(p.apply_height, height);
}

CalibrationReport SelfCalibration::report() const {
  const CalibrationParameters& p = parameters_;
  const double height = stated_.height * std::exp(state_[I::LogHeight]);
  const double scale = std::exp(state_[I::LogScale]);
  CalibrationReport r;
  r.pitch = {pitchOf(T_base_camera_), pitchOf(corrected(T_base_camera_, state_)), sigma(I::Pitch)};
  r.roll = {0.0, state_[I::Roll], sigma(I::Roll)};
  r.yaw = {0.0, state_[I::Yaw], sigma(I::Yaw)};
  r.height = {stated_.height, height, height * sigma(I::LogHeight)};
  r.scale = {1.0, scale, scale * sigma(I::LogScale)};
  r.turn_scale = {1.0, 1.0 + state_[I::TurnScale], sigma(I::TurnScale)};
  r.yaw_rate = {0.0, state_[I::YawRate], sigma(I::YawRate)};
  r.ratio_sigma = ratioSigma();
  r.pairs = pairs_;
  r.believable = believable();
  r.confident = confident();
  r.applied = !rectified_with_.isZero();
  const auto surely = [&p](const CalibrationReport::Value& value, double useful) {
    return std::abs(value.off()) > std::max(useful, p.warn_sigmas * value.sigma);
  };
  r.pitch_off = r.believable && surely(r.pitch, p.warn_tilt);
  r.roll_off = r.believable && surely(r.roll, p.warn_tilt);
  r.height_off = r.believable && surely(r.height, p.warn_height);
  return r;
}

}  // namespace ipm_mapping::sweep
