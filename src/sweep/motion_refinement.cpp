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
constexpr int margin = 3;        // rows that a sample keeps from the edge of the view

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

void MotionRefinement::configure(const PolarGrid& grid, const std::vector<RowRange>& rows,
                                 const Eigen::Vector2d& camera_foot,
                                 const MotionRefinementParameters& parameters) {
  grid_ = grid;
  rows_ = rows;
  foot_ = camera_foot;
  parameters_ = parameters;
  points_.clear();
  x_.clear();
  y_.clear();
  floor_begin_.assign(static_cast<std::size_t>(grid.lines), 0);
  const int first = std::max(0, static_cast<int>(grid.row(grid.height * parameters.farthest)));
  for (int line = 1; line < grid.lines - 1; line += parameters.line_step) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    for (int row = std::max(first, range.begin); row < range.end; row += parameters.row_step) {
      const double azimuth = grid.azimuth(line), distance = grid.distance(row);
      points_.push_back({row, line});
      x_.push_back(static_cast<float>(distance * std::cos(azimuth)));
      y_.push_back(static_cast<float>(distance * std::sin(azimuth)));
    }
  }
  x_.resize(points_.size() + kernels::overrun);
  y_.resize(x_.size());
  samples_.resize(x_.size());
}

void MotionRefinement::Samples::resize(std::size_t n) {
  for (auto* array :
       {&row, &line, &current, &current_high, &reference_mean, &warped, &warped_high, &deviation})
    array->assign(n, 0.0F);
  seen_row.assign(n, 0);
  seen_line.assign(n, 0);
  for (auto* arrays : {&d_row, &d_line, &gradient})
    for (auto& array : *arrays) array.assign(n, 0.0F);
}

void MotionRefinement::Samples::move(std::size_t from, std::size_t to) {
  row[to] = row[from];
  line[to] = line[from];
  for (std::size_t k = 0; k < d_row.size(); ++k) {
    d_row[k][to] = d_row[k][from];
    d_line[k][to] = d_line[k][from];
  }
}

kernels::SamplePositions MotionRefinement::Samples::positions() {
  kernels::SamplePositions all;
  all.row = row.data();
  all.line = line.data();
  for (std::size_t k = 0; k < d_row.size(); ++k) {
    all.d_row[k] = d_row[k].data();
    all.d_line[k] = d_line[k].data();
  }
  return all;
}

/// Is what is seen around a position of the reference well inside its view?
bool MotionRefinement::inView(float row, float line) const {
  if (!(line >= 1.0F && line < static_cast<float>(grid_.lines - 3))) return false;
  const RowRange range = intersection(rows_[static_cast<std::size_t>(line)],
                                      rows_[static_cast<std::size_t>(line) + 1]);
  return row >= static_cast<float>(range.begin + margin) &&
         row < static_cast<float>(range.end - margin - 1);
}

/// Where the floor points are seen in the reference, and how that moves with the motion; what both
/// frames see becomes the samples.
void MotionRefinement::linearize(const RectifiedFrame& current, const RectifiedFrame& reference,
                                 const SE2& motion) {
  kernels::projectFloor(x_.data(), y_.data(), static_cast<int>(points_.size()), projection(motion),
                        samples_.positions());
  std::size_t n = 0;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const FloorPoint& point = points_[i];
    if (point.row < floor_begin_[static_cast<std::size_t>(point.line)]) continue;
    if (!inView(samples_.row[i], samples_.line[i])) continue;
    samples_.move(i, n);
    samples_.seen_row[n] = point.row;
    samples_.seen_line[n] = point.line;
    samples_.reference_mean[n] = reference.mean.at(samples_.row[n], samples_.line[n]);
    samples_.current[n] = static_cast<float>(current.image.at(point.row, point.line));
    samples_.current_high[n] =
        samples_.current[n] -
        current.mean.at(static_cast<float>(point.row), static_cast<float>(point.line));
    ++n;
  }
  samples_.count = static_cast<int>(n);
}

kernels::FloorProjection MotionRefinement::projection(const SE2& motion) const {
  const FootMotion foot(motion, foot_);
  kernels::FloorProjection p;
  p.c = static_cast<float>(foot.c);
  p.s = static_cast<float>(foot.s);
  p.tx = static_cast<float>(foot.tx);
  p.ty = static_cast<float>(foot.ty);
  p.foot_x = static_cast<float>(foot_.x());
  p.foot_y = static_cast<float>(foot_.y());
  p.height = static_cast<float>(grid_.height);
  p.rows_per_log = static_cast<float>(grid_.rows_per_log);
  p.row_at_one = static_cast<float>(grid_.row(1.0));
  p.lines_per_radian = static_cast<float>(grid_.lines_per_radian);
  p.line_ahead = static_cast<float>(grid_.line(0.0));
  return p;
}

void MotionRefinement::warp(const RectifiedFrame& reference, const Correction& correction) {
  const Eigen::Matrix<float, kernels::alignment_moves, 1> c = correction.cast<float>();
  kernels::WarpedSamples out;
  out.grey = samples_.warped.data();
  out.high = samples_.warped_high.data();
  for (std::size_t k = 0; k < samples_.gradient.size(); ++k)
    out.gradient[k] = samples_.gradient[k].data();
  kernels::warpSamples(reference.image.view(), samples_.positions(), samples_.reference_mean.data(),
                       c.data(), samples_.count, out);
}

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

FloorSamples MotionRefinement::floor(const RefinedMotion& motion) {
  const auto gain = static_cast<float>(motion.photometric.gain);
  const auto offset = static_cast<float>(motion.photometric.offset);
  for (int i = 0; i < samples_.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    samples_.deviation[k] = gain * samples_.warped[k] + offset;
  }
  return {samples_.current.data(),  samples_.deviation.data(),
          samples_.seen_row.data(), samples_.seen_line.data(),
          samples_.row.data(),      samples_.line.data(),
          samples_.count,           motion.sigma};
}

}  // namespace ipm_mapping::sweep
