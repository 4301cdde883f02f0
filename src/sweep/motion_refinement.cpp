#include "ipm_mapping/sweep/motion_refinement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr double gain_scale = 100.0;  // keeps the normal equations well conditioned
constexpr double least_spread = 1.0, most_spread = 4.0, first_spread = 4.0;  // grey levels
constexpr double tukey = 2.5;
constexpr double cauchy = 2.0;  // standard deviations at which odometry's say is halved
constexpr double median_to_sigma = 1.48;
constexpr double converged = 5e-5;      // metres and radians
constexpr double linear_within = 0.03;  // camera heights, radians: beyond it positions are redone
constexpr float brightest = 255.0F;
constexpr double clearly = 1.5;  // times as many floor points agree

// Places of the unknowns.
constexpr int x_at = 0, y_at = 1, theta_at = 2, pitch_at = 3, roll_at = 4, gain_at = 5,
              offset_at = 6;
static_assert(gain_at == kernels::alignment_moves && offset_at + 1 == kernels::alignment_unknowns);

/// Normal equations of the kernels in the units of the solution: gains in 1 / gain_scale.
template <class Normal, class Unknowns>
void unpack(const double* sums, double gain, Normal& A, Unknowns& b) {
  const double* upper = sums + kernels::alignment_unknowns;
  Unknowns unit = Unknowns::Constant(gain);
  unit[gain_at] = 1.0 / gain_scale;
  unit[offset_at] = 1.0;
  for (int row = 0; row < unit.size(); ++row) {
    b[row] = unit[row] * sums[row];
    for (int column = row; column < unit.size(); ++column, ++upper)
      A(row, column) = A(column, row) = unit[row] * unit[column] * *upper;
  }
}

SE2 moved(const SE2& base, double x, double y, double theta) {
  return {base.x + x, base.y + y, base.theta + theta};
}

}  // namespace

/// Odometry, small sway and unchanged brightness as a prior. A heading that is wrong by e since the
/// reference has also carried the robot x e / 2 sideways; what is left is independent. Wheels slip:
/// distance and heading have the heavy tails of a Cauchy distribution, so that odometry which
/// contradicts the floor by far loses its say; so has the sway, for a robot is quiet until it nods.
struct MotionRefinement::Prior {
  SE2 odometry;
  double sd_forward, sd_sideways, sd_turn, sd_sway, sd_gain, sd_offset;

  Prior(const MotionRefinementParameters& p, const SE2& motion, double seconds)
      : odometry(motion),
        sd_forward(p.sd_forward * motion.distance() + p.sd_forward_floor),
        sd_sideways(p.sd_sideways * motion.distance() + p.sd_sideways_floor),
        sd_turn(p.sd_turn * motion.distance() + p.sd_turn_share * std::abs(motion.theta) +
                p.sd_turn_rate * seconds + p.sd_turn_floor),
        sd_sway(p.sd_sway),
        sd_gain(p.sd_gain),
        sd_offset(p.sd_offset) {}

  /// Adds the prior's normal equations at a state.
  void add(const RefinedMotion& state, Normal& A, Unknowns& b) const {
    const SE2& motion = state.motion;
    Unknowns row = Unknowns::Unit(x_at);
    addRow(row, odometry.x - motion.x, sd_forward, true, A, b);
    row = Unknowns::Unit(theta_at);
    const double turned = odometry.theta - motion.theta;
    addRow(row, turned, sd_turn, true, A, b);
    const double lever = 0.5 * odometry.x;
    row = Unknowns::Unit(y_at) - lever * Unknowns::Unit(theta_at);
    addRow(row, odometry.y - motion.y - lever * turned, sd_sideways, false, A, b);
    addRow(Unknowns::Unit(pitch_at), -state.sway.pitch, sd_sway, true, A, b);
    addRow(Unknowns::Unit(roll_at), -state.sway.roll, sd_sway, true, A, b);
    addBrightness(state.photometric, A(gain_at, gain_at), A(offset_at, offset_at), b[gain_at],
                  b[offset_at]);
  }
  void addBrightness(const Photometric& photometric, double& A_gain, double& A_offset,
                     double& b_gain, double& b_offset) const {
    const double gain = 1.0 / (sd_gain * gain_scale * sd_gain * gain_scale);
    const double offset = 1.0 / (sd_offset * sd_offset);
    A_gain += gain;
    A_offset += offset;
    b_gain += gain * gain_scale * (1.0 - photometric.gain);
    b_offset -= offset * photometric.offset;
  }

 private:
  static void addRow(const Unknowns& row, double e, double sd, bool heavy_tails, Normal& A,
                     Unknowns& b) {
    const double share = e / (heavy_tails ? cauchy * sd : sd);
    const double information = 1.0 / (sd * sd * (heavy_tails ? 1.0 + share * share : 1.0));
    A.noalias() += (information * row) * row.transpose();
    b.noalias() += (information * e) * row;
  }
};

kernels::AlignmentResidual MotionRefinement::residual(const Photometric& photometric,
                                                      bool high_pass) const {
  return {(high_pass ? samples_.current_high : samples_.current).data(),
          (high_pass ? samples_.warped_high : samples_.warped).data(),
          static_cast<float>(photometric.gain), static_cast<float>(photometric.offset),
          samples_.count};
}

/// Normal equations of the floor, weighed by Tukey; and the residual's robust standard deviation,
/// within sane bounds.
void MotionRefinement::normalEquations(RefinedMotion& state, bool high_pass, double limit,
                                       Normal& A, Unknowns& b) {
  const kernels::AlignmentResidual e = residual(state.photometric, high_pass);
  std::array<const float*, kernels::alignment_moves> gradient;
  for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] = samples_.gradient[k].data();
  std::array<double, kernels::alignment_sums> sums;
  kernels::alignmentSums(e, gradient.data(), static_cast<float>(limit), sums.data());
  const float median =
      kernels::medianDeviation(e, static_cast<float>(most_spread), samples_.deviation.data());
  state.sigma =
      std::clamp(median_to_sigma * static_cast<double>(median), least_spread, most_spread);
  const double information = parameters_.correlation / (state.sigma * state.sigma);
  for (double& sum : sums) sum *= information;
  unpack(sums.data(), state.photometric.gain, A, b);
}

/// One Gauss-Newton step; outliers are judged by the spread of the step before.
void MotionRefinement::step(const Prior& prior, const SE2& base, Correction& correction,
                            RefinedMotion& state) {
  Normal A;
  Unknowns b;
  normalEquations(state, true, tukey * std::max(state.sigma, anneal_), A, b);
  prior.add(state, A, b);
  const Eigen::LLT<Normal> solver(A);
  const Unknowns delta = solver.solve(b);
  correction += delta.head<kernels::alignment_moves>();
  state.motion = moved(base, correction[x_at], correction[y_at], correction[theta_at]);
  state.sway = {correction[pitch_at], correction[roll_at]};
  state.photometric.gain += delta[gain_at] / gain_scale;
  state.photometric.offset += delta[offset_at];
  state.covariance = solver.solve(Normal::Identity()).topLeftCorner<3, 3>();
}

double MotionRefinement::medianOf(const std::vector<float>& grey) {
  return kernels::medianDeviation({grey.data(), grey.data(), 0.0F, 0.0F, samples_.count}, brightest,
                                  samples_.deviation.data());
}

/// Gain and offset on the plain images, the motion being settled.
void MotionRefinement::fitBrightness(double gain, RefinedMotion& state) {
  constexpr int rounds = 3;
  state.photometric = {};
  state.photometric.gain = gain;
  state.sigma = first_spread;
  const Prior prior(parameters_, state.motion, 0.0);
  for (int round = 0; round < rounds; ++round) {
    Normal A;
    Unknowns b;
    normalEquations(state, false, tukey * state.sigma, A, b);
    prior.addBrightness(state.photometric, A(gain_at, gain_at), A(offset_at, offset_at), b[gain_at],
                        b[offset_at]);
    const Eigen::Matrix2d brightness = A.bottomRightCorner<2, 2>();
    const Eigen::Vector2d right_side = b.tail<2>();
    const Eigen::Vector2d delta = brightness.llt().solve(right_side);
    state.photometric.gain += delta[0] / gain_scale;
    state.photometric.offset += delta[1];
  }
}

/// Lamps and automatic exposure may change more than what counts as an outlier. Then the search
/// begins a second time at the gain of the middle floor point; that may be one of somebody who has
/// come, so it has to agree with clearly more of the floor.
void MotionRefinement::fitBrightness(RefinedMotion& state) {
  fitBrightness(1.0, state);
  if (state.sigma < most_spread) return;
  const double before = medianOf(samples_.warped);
  const double gain = before > 0.0 ? medianOf(samples_.current) / before : 1.0;
  if (std::abs(gain - 1.0) <= parameters_.sd_gain) return;
  const auto agreeing = [&](const RefinedMotion& fit) {
    const kernels::AlignmentResidual e = residual(fit.photometric, false);
    int n = 0;
    for (int i = 0; i < e.count; ++i)
      n += std::abs(e.current[i] - (e.gain * e.warped[i] + e.offset)) <= most_spread ? 1 : 0;
    return n;
  };
  RefinedMotion other = state;
  fitBrightness(gain, other);
  if (agreeing(other) > clearly * agreeing(state)) state = other;
}

RefinedMotion MotionRefinement::refine(const RectifiedFrame& current,
                                       const RectifiedFrame& reference, const SE2& odometry,
                                       const SE2& start) {
  RefinedMotion state;
  state.motion = parameters_.refine ? start : odometry;
  state.sigma = first_spread;
  const Prior prior(parameters_, odometry, current.went - reference.went);
  SE2 base = state.motion;
  Correction correction = Correction::Zero();
  linearize(current, reference, base);
  warp(reference, correction);
  state.samples = samples_.count;
  if (state.samples < parameters_.min_samples) {
    state.motion = odometry;
    return state;
  }
  for (int i = 0; parameters_.refine && i < parameters_.iterations; ++i) {
    const Correction before = correction;
    anneal_ = parameters_.first_spread * std::pow(0.5, i);
    step(prior, base, correction, state);
    state.refined = true;
    if (correction.head<2>().norm() > linear_within * grid_.height ||
        std::abs(correction[theta_at]) > linear_within) {
      base = state.motion;
      correction.head<3>().setZero();
      linearize(current, reference, base);
      if (samples_.count < parameters_.min_samples) break;
      warp(reference, correction);
      continue;
    }
    warp(reference, correction);
    if (anneal_ < least_spread * 4 && (correction - before).cwiseAbs().maxCoeff() < converged)
      break;
  }
  fitBrightness(state);
  return state;
}

}  // namespace ipm_mapping::sweep
