#include "ipm_mapping/sweep/moving_obstacle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::sweep {
namespace {

constexpr double cells_a_range = 40.0;   // of the history: 5 cm at 2 m
constexpr double reach = 3.2;            // ranges until it wraps around: the view, and the way
constexpr double behind_foot = 0.6;      // cells, to be surely on what has come
constexpr double behind_mirrored = 1.2;  // a mirror image does not quite go along
constexpr double step = 0.9;             // cells between places along a bearing
constexpr double longest_step = 0.3;     // metres from frame to frame
constexpr int most_missing = 6;          // beams between neighbours
constexpr double same_thing = 6.0;       // candidates between neighbours

Eigen::Vector2d lengthened(const Eigen::Vector2d& p, double by) {
  return p * (1.0 + by / p.norm());
}

}  // namespace

void MovingObstacle::reset() {
  history_.clear();
  feet_.clear();
  feet_before_.clear();
}

void MovingObstacle::configure(const VerticalSweep& sweep, double max_range,
                               const EvidenceParameters& evidence,
                               const MovingParameters& parameters) {
  parameters_ = parameters;
  grid_ = sweep.scoreGrid();
  cost_ = static_cast<std::int32_t>(std::lround(parameters.moving_cost * kernels::cost_unit));
  least_rows_ = static_cast<int>(std::lround(grid_.rowsUp(parameters.moving_height)));
  row_weight_.clear();
  const double first_row = sweep.sweepRow(0.0);
  for (int row = 0; row < static_cast<int>(sweep.sweepRow(sweep.candidates())); ++row)
    row_weight_.push_back(static_cast<float>(evidence.evidence_rows * grid_.slope(row - first_row) /
                                             grid_.candidates_per_log / kernels::cost_unit));
  come_.resize(static_cast<std::size_t>(sweep.beams()));
  feet_.reserve(come_.size());
  feet_before_.reserve(come_.size());
  history_.configure(max_range / cells_a_range, reach * max_range);
  reset();
}

/// Cumulative sum outwards from the near end: the run begins where the sum was last zero.
BeamChoice MovingObstacle::footOf(const ComparedFrame& frame, int beam) const {
  const RowRange rows = frame.sweep.rows(beam);
  const int first_row = static_cast<int>(frame.sweep.sweepRow(0.0));
  BeamChoice foot;
  foot.moving = true;
  float sum = 0.0F;
  int begin = rows.end - 1;
  for (int row = rows.end - 1; row >= std::max(rows.begin, first_row); --row) {
    std::int32_t least = kernels::no_cost;
    for (int q = 0; q < frame.count; ++q) {
      const std::int32_t cost = frame.references[q].floor_cost.row(beam)[row];
      least = std::min(least, cost == kernels::no_cost ? cost_ : cost);
    }
    if (sum <= 0.0F) {
      if (isFoot(foot, begin)) break;
      sum = foot.score = 0.0F;
      begin = row;
    }
    sum += static_cast<float>(least - cost_) * row_weight_[static_cast<std::size_t>(row)];
    if (sum <= foot.score) continue;
    foot.score = sum;
    foot.top = row;
    foot.candidate = static_cast<float>(begin - first_row);
  }
  if (!isFoot(foot, begin)) foot.candidate = -1.0F;
  return foot;
}

bool MovingObstacle::isFoot(const BeamChoice& foot, int begin) const {
  return foot.score >= static_cast<float>(parameters_.moving_score) &&
         begin - foot.top >= least_rows_;
}

bool MovingObstacle::hasCome(const ComparedFrame& frame, const SE2& T_floor_foot,
                             const Eigen::Vector2d& p_foot) const {
  const Eigen::Vector2d here = T_floor_foot * lengthened(p_foot, behind_foot * history_.cell());
  const Eigen::Vector2d along =
      T_floor_foot * lengthened(p_foot, behind_mirrored * history_.cell());
  for (int q = 0; q < frame.count; ++q) {
    const int ago = history_.framesAgo(frame.references[q].stamp);
    if (ago < 0 || !history_.wasFree(here, ago)) continue;
    const Eigen::Vector2d way = T_floor_foot.translation() - history_.foot(ago);
    if (history_.wasFree(along - way, ago)) return true;
  }
  return false;
}

/// Beams from one on that see the same thing, but for a few that do not see it.
int MovingObstacle::endOfRun(int first) const {
  const int beams = static_cast<int>(come_.size());
  const auto candidate = [&](int beam) {
    return double{come_[static_cast<std::size_t>(beam)].candidate};
  };
  int last = first;
  for (int beam = first + 1; beam < beams && beam - last <= most_missing + 1; ++beam)
    if (come_[static_cast<std::size_t>(beam)].any() &&
        std::abs(candidate(beam) - candidate(last)) <= same_thing)
      last = beam;
  return last + 1;
}

double MovingObstacle::widthOf(int first, int end) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (int beam = first; beam < end; ++beam) {
    const BeamChoice& foot = come_[static_cast<std::size_t>(beam)];
    if (foot.any()) nearest = std::min(nearest, grid_.point(beam, double{foot.candidate}).norm());
  }
  return nearest * std::abs(grid_.azimuth_step) * (end - first);
}

void MovingObstacle::complete(const ComparedFrame& frame, const SE2& T_floor_foot,
                              std::vector<BeamChoice>& choices) {
  if (parameters_.moving_score <= 0.0 || choices.size() != come_.size()) return;
  std::swap(feet_, feet_before_);
  feet_.clear();
  for (std::size_t i = 0; i < come_.size(); ++i) {
    const int beam = static_cast<int>(i);
    come_[i] = choices[i].any() ? BeamChoice{} : footOf(frame, beam);
    if (come_[i].any() &&
        !hasCome(frame, T_floor_foot, grid_.point(beam, double{come_[i].candidate})))
      come_[i] = BeamChoice{};
  }
  for (int first = 0; first < static_cast<int>(come_.size()); ++first) {
    if (!come_[static_cast<std::size_t>(first)].any()) continue;
    const int end = endOfRun(first);
    if (end - first > 1 && widthOf(first, end) >= parameters_.moving_width &&
        seenAgain(T_floor_foot, first, end))
      publish(first, end, choices);
    first = end - 1;
  }
}

/// Remembers the feet of a run; true if one of them is a step from what the frame before had.
bool MovingObstacle::seenAgain(const SE2& T_floor_foot, int first, int end) {
  bool again = false;
  for (int beam = first; beam < end; ++beam) {
    const BeamChoice& foot = come_[static_cast<std::size_t>(beam)];
    if (!foot.any()) continue;
    const Eigen::Vector2d p_floor = T_floor_foot * grid_.point(beam, double{foot.candidate});
    again = again || std::any_of(feet_before_.begin(), feet_before_.end(),
                                 [&](const Eigen::Vector2d& before) {
                                   return (p_floor - before).norm() <= longest_step;
                                 });
    feet_.push_back(p_floor);
  }
  return again;
}

/// A run, and what it lacks in between: plain things look like floor there.
void MovingObstacle::publish(int first, int end, std::vector<BeamChoice>& choices) const {
  auto before = static_cast<std::size_t>(first);
  for (auto i = before; i < static_cast<std::size_t>(end); ++i) {
    if (!come_[i].any()) continue;
    const BeamChoice &a = come_[before], &b = come_[i];
    for (std::size_t k = before; k <= i; ++k) {
      if (choices[k].any()) continue;
      const float t =
          i == before ? 0.0F : static_cast<float>(k - before) / static_cast<float>(i - before);
      choices[k] = t < 0.5F ? a : b;
      choices[k].candidate = a.candidate + t * (b.candidate - a.candidate);
    }
    before = i;
  }
}

void MovingObstacle::remember(const SE2& T_floor_foot, const Obstacles& obstacles) {
  if (parameters_.moving_score <= 0.0) return;
  history_.beginFrame(obstacles.view.stamp, T_floor_foot.translation());
  for (const Bearing& bearing : obstacles.bearings) {
    const bool occupied = bearing.state == BearingState::Occupied;
    if (!occupied && bearing.state != BearingState::Free) continue;
    const Eigen::Vector2d ray(std::cos(bearing.angle), std::sin(bearing.angle));
    const double end = double{bearing.range} - (occupied ? 2.0 * history_.cell() : 0.0);
    for (double d = bearing.near; d < end; d += step * history_.cell())
      history_.setFree(T_floor_foot * Eigen::Vector2d(d * ray));
  }
}

}  // namespace ipm_mapping::sweep
