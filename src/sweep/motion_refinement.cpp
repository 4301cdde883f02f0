#include "ipm_mapping/sweep/motion_refinement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

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

/// Grey level between pixels and its slopes there.
struct Patch {
  float value, by_row, by_line;
};

Patch patchAt(const Image<std::uint8_t>& image, float row, float line) {
  const float r = std::clamp(row, 0.0F, static_cast<float>(image.width()) - 1.01F);
  const float l = std::clamp(line, 0.0F, static_cast<float>(image.height()) - 1.01F);
  const int ir = static_cast<int>(r), il = static_cast<int>(l);
  const float a = r - static_cast<float>(ir), b = l - static_cast<float>(il);
  const std::uint8_t* p = image.row(il) + ir;
  const std::uint8_t* q = p + image.width();
  const auto p0 = static_cast<float>(p[0]), p1 = static_cast<float>(p[1]);
  const auto q0 = static_cast<float>(q[0]), q1 = static_cast<float>(q[1]);
  const float here = p0 + a * (p1 - p0), next = q0 + a * (q1 - q0);
  return {here + b * (next - here), (p1 - p0) + b * ((q1 - q0) - (p1 - p0)), next - here};
}

double tukeyWeight(double e, double limit) {
  const double share = e / limit, rest = 1.0 - share * share;
  return rest > 0.0 ? rest * rest : 0.0;
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
  floor_begin_.assign(static_cast<std::size_t>(grid.lines), 0);
  const int first = std::max(0, static_cast<int>(grid.row(grid.height * parameters.farthest)));
  for (int line = 1; line < grid.lines - 1; line += parameters.line_step) {
    const RowRange range = rows[static_cast<std::size_t>(line)];
    for (int row = std::max(first, range.begin); row < range.end; row += parameters.row_step) {
      const double azimuth = grid.azimuth(line), distance = grid.distance(row);
      points_.push_back({row, line, distance * std::cos(azimuth), distance * std::sin(azimuth)});
    }
  }
  samples_.reserve(points_.size());
  deviations_.reserve(points_.size());
}

/// Position of a floor point in the reference and how it moves with the motion:
///   d row  = -rows_per_log   (p . dp) / |p|^2,
///   d line = -lines_per_rad  (p x dp) / |p|^2,   dp/dx = (1,0), dp/dy = (0,1), dp/dtheta = R' X.
bool MotionRefinement::linearizeOne(const FloorPoint& point, const FootMotion& motion,
                                    const RectifiedFrame& reference, Sample& s) const {
  const Eigen::Vector2d p = motion * Eigen::Vector2d(point.x, point.y);
  const double d2 = p.squaredNorm();
  const double row = grid_.rowOfSquared(d2), line = grid_.line(std::atan2(p.y(), p.x()));
  if (!(line >= 1.0 && line < grid_.lines - 3.0)) return false;
  const RowRange range = intersection(rows_[static_cast<std::size_t>(line)],
                                      rows_[static_cast<std::size_t>(line) + 1]);
  if (!(row >= range.begin + margin && row < range.end - margin - 1)) return false;
  const double X = foot_.x() + point.x, Y = foot_.y() + point.y;
  const Eigen::Vector2d turned(-motion.s * X - motion.c * Y, motion.c * X - motion.s * Y);
  const Eigen::Vector3d along(p.x(), p.y(), p.dot(turned));
  const Eigen::Vector3d across(-p.y(), p.x(), p.x() * turned.y() - p.y() * turned.x());
  s.row = static_cast<float>(row);
  s.line = static_cast<float>(line);
  for (int k = 0; k < 3; ++k) {
    s.d_row[k] = static_cast<float>(-grid_.rows_per_log * along[k] / d2);
    s.d_line[k] = static_cast<float>(-grid_.lines_per_radian * across[k] / d2);
  }
  s.reference_mean = reference.mean.at(s.row, s.line);
  return true;
}

void MotionRefinement::linearize(const RectifiedFrame& current, const RectifiedFrame& reference,
                                 const SE2& motion) {
  const FootMotion foot_motion(motion, foot_);
  samples_.clear();
  for (const FloorPoint& point : points_) {
    if (point.row < floor_begin_[static_cast<std::size_t>(point.line)]) continue;
    Sample s;
    if (!linearizeOne(point, foot_motion, reference, s)) continue;
    s.current = static_cast<float>(current.image.at(point.row, point.line));
    s.current_mean = current.mean.at(static_cast<float>(point.row), static_cast<float>(point.line));
    samples_.push_back(s);
  }
}

void MotionRefinement::warp(const RectifiedFrame& reference, const Eigen::Vector3d& correction) {
  const Eigen::Vector3f c = correction.cast<float>();
  for (Sample& s : samples_) {
    const Patch patch =
        patchAt(reference.image, s.row + s.d_row[0] * c[0] + s.d_row[1] * c[1] + s.d_row[2] * c[2],
                s.line + s.d_line[0] * c[0] + s.d_line[1] * c[1] + s.d_line[2] * c[2]);
    s.warped = patch.value;
    for (int k = 0; k < 3; ++k)
      s.gradient[k] = patch.by_row * s.d_row[k] + patch.by_line * s.d_line[k];
  }
}

/// Robust standard deviation of the residual, within sane bounds.
double MotionRefinement::spread(const RefinedMotion& state, bool high_pass) {
  const auto gain = static_cast<float>(state.photometric.gain);
  const auto offset = static_cast<float>(state.photometric.offset);
  deviations_.clear();
  for (const Sample& s : samples_) {
    const float a = high_pass ? s.current - s.current_mean : s.current;
    const float b = high_pass ? s.warped - s.reference_mean : s.warped;
    deviations_.push_back(std::abs(a - (gain * b + offset)));
  }
  const auto middle = deviations_.begin() + static_cast<std::ptrdiff_t>(deviations_.size() / 2);
  std::nth_element(deviations_.begin(), middle, deviations_.end());
  return std::clamp(median_to_sigma * static_cast<double>(*middle), least_spread, most_spread);
}

/// One Gauss-Newton step with the spread of the step before.
void MotionRefinement::step(const Prior& prior, const SE2& base, Eigen::Vector3d& correction,
                            RefinedMotion& state) {
  Matrix5 A = Matrix5::Zero();
  Vector5 b = Vector5::Zero();
  const double gain = state.photometric.gain, offset = state.photometric.offset;
  const double limit = tukey * std::max(state.sigma, anneal_);
  for (const Sample& s : samples_) {
    const double warped = static_cast<double>(s.warped - s.reference_mean);
    const double e = static_cast<double>(s.current - s.current_mean) - (gain * warped + offset);
    const double w = tukeyWeight(e, limit);
    if (w == 0.0) continue;
    Vector5 J;
    J << gain * static_cast<double>(s.gradient[0]), gain * static_cast<double>(s.gradient[1]),
        gain * static_cast<double>(s.gradient[2]), warped / gain_scale, 1.0;
    b.noalias() += (w * e) * J;
    A.noalias() += (w * J) * J.transpose();
  }
  state.sigma = spread(state, true);
  const double information = parameters_.correlation / (state.sigma * state.sigma);
  A *= information;
  b *= information;
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
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (const Sample& s : samples_) {
      const double e =
          static_cast<double>(s.current) -
          (state.photometric.gain * static_cast<double>(s.warped) + state.photometric.offset);
      const double w = tukeyWeight(e, tukey * state.sigma);
      const Eigen::Vector2d J(static_cast<double>(s.warped) / gain_scale, 1.0);
      b.noalias() += (w * e) * J;
      A.noalias() += (w * J) * J.transpose();
    }
    state.sigma = spread(state, false);
    const double information = parameters_.correlation / (state.sigma * state.sigma);
    A *= information;
    b *= information;
    prior.addBrightness(state.photometric, A(0, 0), A(1, 1), b[0], b[1]);
    const Eigen::Vector2d delta = A.llt().solve(b);
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
  state.samples = static_cast<int>(samples_.size());
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
      if (static_cast<int>(samples_.size()) < parameters_.min_samples) break;
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
