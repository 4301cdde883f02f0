#include "ipm_mapping/sweep/self_calibration.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

using I = CalibrationIndex;
static_assert(I::ReadoutTime == I::count - 2 && I::TimeOffset == I::count - 1, "the camera's own");

constexpr double known_time = 1e-6;      // seconds: how well, if it is not to be learnt
constexpr double longest_readout = 0.1;  // seconds

}  // namespace

void SelfCalibration::setCamera(const CameraPose& T_base_camera) {
  const CalibrationInformation of_the_camera = knownOfTheCamera();
  stated_ = StatedCamera(T_base_camera);
  T_base_camera_ = T_base_camera;
  const CalibrationParameters& p = parameters_;
  CalibrationVector sd;
  sd << p.sd_pitch, p.sd_roll, p.sd_yaw, p.sd_height_wrong / stated_.height, p.sd_scale,
      p.sd_turn_scale, p.sd_yaw_rate, p.learn_readout ? p.sd_readout : known_time,
      p.learn_time_offset ? p.sd_time_offset : known_time;
  prior_.information = sd.cwiseAbs2().cwiseInverse().asDiagonal();
  sd[I::LogHeight] = p.sd_height / stated_.height;
  prior_right_height_.information = sd.cwiseAbs2().cwiseInverse().asDiagonal();
  forget();
  learnt_.evidence = of_the_camera;
  learnt_.aligned = learnt_.state = known().mean();
  learnt_.covariance = known().covariance();
  reset();
}

/// What is left of the evidence about readout time and clock when all else is unknown.
CalibrationInformation SelfCalibration::knownOfTheCamera() const {
  CalibrationInformation result;
  if (learnt_.pairs == 0) {
    result.information.bottomRightCorner<2, 2>() =
        learnt_.evidence.information.bottomRightCorner<2, 2>();
    result.vector.tail<2>() = learnt_.evidence.vector.tail<2>();
    return result;
  }
  const Eigen::Matrix2d information = learnt_.covariance.bottomRightCorner<2, 2>().inverse();
  result.information.bottomRightCorner<2, 2>() =
      information - prior_.information.bottomRightCorner<2, 2>();
  result.vector.tail<2>() = information * learnt_.state.tail<2>() - prior_.vector.tail<2>();
  return result;
}

void SelfCalibration::forget() {
  learnt_ = {};
  learnt_.covariance = prior_.covariance();
}

bool SelfCalibration::adopt(const SelfCalibration& other) {
  if (T_base_camera_.matrix() != other.T_base_camera_.matrix() ||
      prior_.information != other.prior_.information ||
      prior_right_height_.information != other.prior_right_height_.information ||
      parameters_.readout_time != other.parameters_.readout_time)
    return false;
  learnt_ = other.learnt_;
  return bounded();
}

void SelfCalibration::configure(const CylindricalRectification& rectification,
                                const std::vector<RowRange>& rows,
                                const CalibrationVector& rectified_with) {
  rectified_with_ = rectified_with;
  pair_.configure(rectification, rows, stated_, rectified_with, parameters_, noise_);
}

/// Short while the views would not overlap under the pitch that is possible, and never more than
/// twice as long as the pair before: the first ones have to come soon.
double SelfCalibration::baseline() const {
  const CalibrationParameters& p = parameters_;
  const double share = std::min(p.sd_pitch / sigma(I::Pitch), std::exp2(learnt_.pairs));
  return stated_.height * std::clamp(p.short_baseline * share, p.short_baseline, p.long_baseline);
}

/// A turn shows what is not known yet about the readout, its beginning and end what is not known
/// about the stamps, and either may soon be over.
bool SelfCalibration::telling(const Velocity& velocity) const {
  const CalibrationParameters& p = parameters_;
  const double turn = std::abs(velocity.theta);
  const double changed = std::abs(velocity.theta - last_velocity_.theta);
  return (p.learn_readout && turn > p.readout_turn && sigma(I::ReadoutTime) > p.readout_known) ||
         (p.learn_time_offset && changed > p.readout_turn &&
          sigma(I::TimeOffset) > p.time_offset_known);
}

bool SelfCalibration::due(const RectifiedFrame& current) const {
  if (!seen_any_) return true;
  const CalibrationParameters& p = parameters_;
  const double spacing = telling(current.velocity) ? stated_.height * p.short_baseline
                         : confident() && !learnt_.height_in_doubt
                             ? stated_.height * p.settled_spacing
                             : std::min(baseline(), stated_.height * p.spacing);
  const SE2& pose = current.T_odom_base;
  return std::hypot(pose.x - last_pair_.x, pose.y - last_pair_.y) >= spacing;
}

CalibrationInformation SelfCalibration::known() const {
  return {prior_.information + learnt_.evidence.information,
          prior_.vector + learnt_.evidence.vector};
}

bool SelfCalibration::offer(const RectifiedFrame& current, const ReferenceRing& ring) {
  if (!due(current)) return false;
  if (current.sheared) return false;
  reference_ = ring.find(current, baseline());
  if (reference_ == nullptr || reference_->sheared) return false;
  seen_any_ = true;
  last_pair_ = current.T_odom_base;
  last_velocity_ = current.velocity;
  compare({current, *reference_});
  if (evidence_.used) {
    learnt_.refused = 0;
    learn();
  } else if (++learnt_.refused > parameters_.least_pairs &&
             learnt_.pairs < parameters_.least_pairs) {
    forget();
  }
  return evidence_.used;
}

/// The first pair of all is aligned from several starts: the views may lie pixels apart.
void SelfCalibration::compare(const FramePair& pair) {
  evidence_ = pair_.evaluate(pair, known(), learnt_.aligned);
  if (learnt_.pairs > 0) return;
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
  learnt_.evidence.information = kept * learnt_.evidence.information + evidence_.about.information;
  learnt_.evidence.vector = kept * learnt_.evidence.vector + evidence_.about.vector;
  CalibrationInformation all = known();
  learnt_.aligned = all.mean();
  judgeHeight(all);
  if (!learnt_.wrong_height)
    all.information += prior_right_height_.information - prior_.information;
  learnt_.state = all.mean();
  learnt_.covariance = all.covariance();
  ++learnt_.pairs;
}

/// With some reluctance to change the mind.
void SelfCalibration::judgeHeight(const CalibrationInformation& known) {
  const CalibrationMatrix P = known.covariance();
  const double ratio = std::abs(learnt_.aligned[I::LogHeight] - learnt_.aligned[I::LogScale]);
  const double variance = P(I::LogHeight, I::LogHeight) + P(I::LogScale, I::LogScale) -
                          2.0 * P(I::LogHeight, I::LogScale);
  const double sigma = std::sqrt(std::max(0.0, variance)), limit = parameters_.sd_scale + sigma;
  learnt_.wrong_height = ratio > (learnt_.wrong_height ? 0.8 : 1.0) * limit;
  learnt_.height_in_doubt = std::abs(ratio - parameters_.sd_scale) < sigma;
}

double SelfCalibration::ratioSigma() const {
  const double variance = learnt_.covariance(I::LogHeight, I::LogHeight) +
                          learnt_.covariance(I::LogScale, I::LogScale) -
                          2.0 * learnt_.covariance(I::LogHeight, I::LogScale);
  return std::sqrt(std::max(0.0, variance));
}

bool SelfCalibration::bounded() const {
  const double height = stated_.height * std::expm1(learnt_.state[I::LogHeight]);
  return learnt_.state.head<3>().cwiseAbs().maxCoeff() <= parameters_.max_tilt &&
         std::abs(height) <= parameters_.max_height;
}

bool SelfCalibration::believable() const {
  return learnt_.pairs >= parameters_.least_pairs && bounded();
}

bool SelfCalibration::confident() const {
  return believable() && sigma(I::Pitch) <= parameters_.confident_tilt &&
         ratioSigma() <= parameters_.confident_height;
}

bool SelfCalibration::worthApplying() const {
  const CalibrationParameters& p = parameters_;
  if (learnt_.pairs == 0 || !bounded()) return false;
  const CalibrationVector change = (learnt_.state - rectified_with_).cwiseAbs();
  const double sigmas = confident() ? 1.0 : p.early_sigmas;
  const double pitch = sigmas * sigma(I::Pitch), roll = sigmas * sigma(I::Roll);
  const double height = stated_.height * sigmas * ratioSigma();
  return change[I::Pitch] > std::max(p.apply_tilt, pitch) ||
         change[I::Roll] > std::max(p.apply_tilt, roll) ||
         stated_.height * change[I::LogHeight] > std::max(p.apply_height, height);
}

bool SelfCalibration::readoutDiffers(double in_force) const {
  const double change = std::abs(readout() - in_force);
  const double surely = parameters_.readout_sigmas * sigma(I::ReadoutTime);
  return learnt_.pairs > 0 && bounded() && std::abs(readout()) <= longest_readout &&
         change > std::max(parameters_.apply_readout, surely);
}

double SelfCalibration::timeOffset() const {
  const double most = parameters_.max_time_offset;
  return std::clamp(learnt_.state[I::TimeOffset], -most, most);
}

bool SelfCalibration::timeOffsetDiffers(double in_force) const {
  const CalibrationParameters& p = parameters_;
  const double change = std::abs(timeOffset() - in_force);
  const double surely = p.time_offset_sigmas * sigma(I::TimeOffset);
  return learnt_.pairs >= p.time_offset_pairs && bounded() &&
         change > std::max(p.apply_time_offset, surely);
}

Sway SelfCalibration::remainingTilt() const {
  if (learnt_.pairs == 0) return {};
  const Eigen::Vector3d tilt = stated_.axes * (learnt_.state - rectified_with_).head<3>();
  return {tilt.y(), tilt.x()};
}

CalibrationReport SelfCalibration::report() const {
  const CalibrationParameters& p = parameters_;
  const double height = stated_.height * std::exp(learnt_.state[I::LogHeight]);
  const double scale = std::exp(learnt_.state[I::LogScale]);
  CalibrationReport r;
  r.pitch = {pitchOf(T_base_camera_), pitchOf(corrected(T_base_camera_, learnt_.state)),
             sigma(I::Pitch)};
  r.roll = {0.0, learnt_.state[I::Roll], sigma(I::Roll)};
  r.yaw = {0.0, learnt_.state[I::Yaw], sigma(I::Yaw)};
  r.height = {stated_.height, height, height * sigma(I::LogHeight)};
  r.scale = {1.0, scale, scale * sigma(I::LogScale)};
  r.turn_scale = {1.0, 1.0 + learnt_.state[I::TurnScale], sigma(I::TurnScale)};
  r.yaw_rate = {0.0, learnt_.state[I::YawRate], sigma(I::YawRate)};
  r.readout = {parameters_.readout_time, readout(), sigma(I::ReadoutTime)};
  r.time_offset = {0.0, learnt_.state[I::TimeOffset], sigma(I::TimeOffset)};
  r.ratio_sigma = ratioSigma();
  r.pairs = learnt_.pairs;
  r.believable = believable();
  r.confident = confident();
  r.applied = !rectified_with_.isZero();
  const auto surely = [&p](const CalibrationReport::Value& value, double useful) {
    return std::abs(value.off()) > std::max(useful, p.warn_sigmas * value.sigma);
  };
  r.pitch_off = r.believable && surely(r.pitch, p.warn_tilt);
  r.roll_off = r.believable && surely(r.roll, p.warn_tilt);
  r.height_off = r.believable && surely(r.height, p.warn_height);
  r.time_off = r.believable && surely(r.time_offset, p.warn_time_offset);
  return r;
}

}  // namespace ipm_mapping::sweep
