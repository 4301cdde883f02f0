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
constexpr int margin = 3;               // rows that a sample keeps from the edge of the view

/// Normal equations of the kernels in the units of the solution: gains in 1 / gain_scale.
void unpack(const double* sums, double gain, Eigen::Matrix<double, 5, 5>& A,
            Eigen::Matrix<double, 5, 1>& b) {
  const double* upper = sums + 5;
  const Eigen::Matrix<double, 5, 1> unit(
      (Eigen::Matrix<double, 5, 1>() << gain, gain, gain, 1.0 / gain_scale, 1.0).finished());
  for (int row = 0; row < 5; ++row) {
    b[row] = unit[row] * sums[row];
    for (int column = row; column < 5; ++column, ++upper)
      A(row, column) = A(column, row) = unit[row] * unit[column] * *upper;
  }
}

}  // namespace

/// Odometry and unchanged brightness as a prior. A heading that is wrong by e since the reference
/// has also carried the robot x e / 2 sideways; what is left is independent. Wheels slip: distance
/// and heading have the heavy tails of a Cauchy distribution, so that odometry which contradicts
/// the floor by far loses its say.
struct MotionRefinement::Prior {
  SE2 odometry;
  double sd_forward, sd_sideways, sd_turn, sd_gain, sd_offset;

  Prior(const MotionRefinementParameters& p, const SE2& motion, double seconds)
      : odometry(motion),
        sd_forward(p.sd_forward * motion.distance() + p.sd_forward_floor),
        sd_sideways(p.sd_sideways * motion.distance() + p.sd_sideways_floor),
        sd_turn(p.sd_turn * motion.distance() + p.sd_turn_share * std::abs(motion.theta) +
                p.sd_turn_rate * seconds + p.sd_turn_floor),
        sd_gain(p.sd_gain),
        sd_offset(p.sd_offset) {}

  /// Adds the prior's normal equations at a state.
  void add(const SE2& motion, const Photometric& photometric, Matrix5& A, Vector5& b) const {
    Vector5 row = Vector5::Zero();
    row[0] = 1.0;
    addRow(row, odometry.x - motion.x, sd_forward, true, A, b);
    row[0] = 0.0;
    row[2] = 1.0;
    const double turned = odometry.theta - motion.theta;
    addRow(row, turned, sd_turn, true, A, b);
    const double lever = 0.5 * odometry.x;
    row[1] = 1.0;
    row[2] = -lever;
    addRow(row, odometry.y - motion.y - lever * turned, sd_sideways, false, A, b);
    addBrightness(photometric, A(3, 3), A(4, 4), b[3], b[4]);
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
  static void addRow(const Vector5& row, double e, double sd, bool heavy_tails, Matrix5& A,
                     Vector5& b) {
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
  for (auto* arrays : {&d_row, &d_line, &gradient})
    for (auto& array : *arrays) array.assign(n, 0.0F);
}

void MotionRefinement::Samples::move(std::size_t from, std::size_t to) {
  row[to] = row[from];
  line[to] = line[from];
  for (std::size_t k = 0; k < 3; ++k) {
    d_row[k][to] = d_row[k][from];
    d_line[k][to] = d_line[k][from];
  }
}

kernels::SamplePositions MotionRefinement::Samples::positions() {
  return {row.data(),
          line.data(),
          {d_row[0].data(), d_row[1].data(), d_row[2].data()},
          {d_line[0].data(), d_line[1].data(), d_line[2].data()}};
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
  p.rows_per_log = static_cast<float>(grid_.rows_per_log);
  p.row_at_one = static_cast<float>(grid_.row(1.0));
  p.lines_per_radian = static_cast<float>(grid_.lines_per_radian);
  p.line_ahead = static_cast<float>(grid_.line(0.0));
  return p;
}

void MotionRefinement::warp(const RectifiedFrame& reference, const Eigen::Vector3d& correction) {
  const Eigen::Vector3f c = correction.cast<float>();
  kernels::warpSamples(
      reference.image.view(), samples_.positions(), samples_.reference_mean.data(), c.data(),
      samples_.count,
      {samples_.warped.data(),
       samples_.warped_high.data(),
       {samples_.gradient[0].data(), samples_.gradient[1].data(), samples_.gradient[2].data()}});
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
                                       Matrix5& A, Vector5& b) {
  const kernels::AlignmentResidual e = residual(state.photometric, high_pass);
  const std::array<const float*, 3> gradient{
      samples_.gradient[0].data(), samples_.gradient[1].data(), samples_.gradient[2].data()};
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
void MotionRefinement::step(const Prior& prior, const SE2& base, Eigen::Vector3d& correction,
                            RefinedMotion& state) {
  Matrix5 A;
  Vector5 b;
  normalEquations(state, true, tukey * std::max(state.sigma, anneal_), A, b);
  prior.add(state.motion, state.photometric, A, b);
  const Eigen::LLT<Matrix5> solver(A);
  const Vector5 delta = solver.solve(b);
  correction += delta.head<3>();
  state.motion = {base.x + correction.x(), base.y + correction.y(), base.theta + correction.z()};
  state.photometric.gain += delta[3] / gain_scale;
  state.photometric.offset += delta[4];
  state.covariance = solver.solve(Matrix5::Identity()).topLeftCorner<3, 3>();
}

/// Gain and offset on the plain images, the motion being settled.
void MotionRefinement::fitBrightness(RefinedMotion& state) {
  constexpr int rounds = 3;
  state.photometric = {};
  state.sigma = first_spread;
  const Prior prior(parameters_, state.motion, 0.0);
  for (int round = 0; round < rounds; ++round) {
    Matrix5 A;
    Vector5 b;
    normalEquations(state, false, tukey * state.sigma, A, b);
    prior.addBrightness(state.photometric, A(3, 3), A(4, 4), b[3], b[4]);
    const Eigen::Matrix2d brightness = A.bottomRightCorner<2, 2>();
    const Eigen::Vector2d right_side = b.tail<2>();
    const Eigen::Vector2d delta = brightness.llt().solve(right_side);
    state.photometric.gain += delta[0] / gain_scale;
    state.photometric.offset += delta[1];
  }
}

RefinedMotion MotionRefinement::refine(const RectifiedFrame& current,
                                       const RectifiedFrame& reference, const SE2& odometry,
                                       const SE2& start) {
  RefinedMotion state;
  state.motion = parameters_.refine ? start : odometry;
  state.sigma = first_spread;
  const Prior prior(parameters_, odometry, current.stamp - reference.stamp);
  SE2 base = state.motion;
  Eigen::Vector3d correction = Eigen::Vector3d::Zero();
  linearize(current, reference, base);
  warp(reference, correction);
  state.samples = samples_.count;
  if (state.samples < parameters_.min_samples) {
    state.motion = odometry;
    return state;
  }
  for (int i = 0; parameters_.refine && i < parameters_.iterations; ++i) {
    const Eigen::Vector3d before = correction;
    anneal_ = parameters_.first_spread * std::pow(0.5, i);
    step(prior, base, correction, state);
    state.refined = true;
    if (correction.head<2>().norm() > linear_within * grid_.height ||
        std::abs(correction.z()) > linear_within) {
      base = state.motion;
      correction.setZero();
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
