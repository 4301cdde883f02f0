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
constexpr double before_end = 2.0;       // cells: free floor ends where something may stand,
constexpr double before_limit = 1.0;     // less so where it is the end of what is looked at,
constexpr double at_limit = 0.5;         // so near to it
constexpr double fastest = 3.0;          // metres a second
constexpr double longest_pause = 0.5;    // seconds between two sights
constexpr double widest_gap = 0.25;      // metres between neighbours
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
                               const SelectionParameters& selection,
                               const MovingParameters& parameters) {
  parameters_ = parameters;
  grid_ = sweep.scoreGrid();
  cost_ = static_cast<std::uint16_t>(std::lround(parameters.moving_cost * kernels::cost_unit));
  const double least_height =
      std::max(parameters.moving_height, selection.least_height / grid_.height);
  least_rows_ = static_cast<int>(std::lround(grid_.rowsUp(std::min(least_height, 0.9))));
  row_weight_.clear();
  const double first_row = sweep.sweepRow(0.0);
  for (int row = 0; row < static_cast<int>(sweep.sweepRow(sweep.candidates())); ++row)
    row_weight_.push_back(static_cast<float>(evidence.evidence_rows * grid_.slope(row - first_row) /
                                             grid_.candidates_per_log / kernels::cost_unit));
  least_.resize(row_weight_.size());
  come_.resize(static_cast<std::size_t>(sweep.beams()));
  run_.reserve(come_.size());
  feet_.reserve(come_.size());
  feet_before_.reserve(come_.size());
  history_.configure(max_range / cells_a_range, reach * max_range);
  reset();
}

/// What every row of a beam costs the floor at least; what a reference does not see says nothing.
void MovingObstacle::fillLeastCost(const ComparedFrame& frame, int beam, RowRange rows) {
  std::fill(least_.begin() + rows.begin, least_.begin() + rows.end, kernels::no_cost);
  for (int q = 0; q < frame.count; ++q) {
    const std::uint16_t* cost = frame.references[q].floor_cost.row(beam);
    for (int row = rows.begin; row < rows.end; ++row) {
      const std::uint16_t seen = cost[row] == kernels::no_cost ? cost_ : cost[row];
      least_[static_cast<std::size_t>(row)] = std::min(least_[static_cast<std::size_t>(row)], seen);
    }
  }
}

/// Cumulative sum outwards from the near end: the run begins where the sum was last zero.
BeamChoice MovingObstacle::footOf(const ComparedFrame& frame, int beam) {
  const int first_row = static_cast<int>(frame.sweep.sweepRow(0.0));
  const RowRange rows =
      intersection(frame.sweep.rows(beam), {first_row, static_cast<int>(row_weight_.size())});
  BeamChoice foot;
  if (rows.size() <= 0) return foot;
  fillLeastCost(frame, beam, rows);
  foot.moving = true;
  float sum = 0.0F;
  int begin = rows.end - 1;
  for (int row = rows.end - 1; row >= rows.begin; --row) {
    const std::int32_t least = least_[static_cast<std::size_t>(row)];
    if (sum <= 0.0F) {
      if (isFoot(foot, begin)) break;
      if (least <= cost_) continue;  // floor, as most rows are
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

/// Collects the beams from one on that see the same thing, but for a few that do not see it.
void MovingObstacle::collectRun(int first) {
  run_.assign(1, first);
  for (int beam = first + 1; beam < static_cast<int>(come_.size()); ++beam) {
    const int last = run_.back();
    if (beam - last > most_missing + 1) break;
    if (!come_[static_cast<std::size_t>(beam)].any()) continue;
    const double apart = std::abs(double{come_[static_cast<std::size_t>(beam)].candidate} -
                                  double{come_[static_cast<std::size_t>(last)].candidate});
    if (apart <= same_thing && (footAt(beam) - footAt(last)).norm() <= widest_gap)
      run_.push_back(beam);
  }
}

Eigen::Vector2d MovingObstacle::footAt(int beam) const {
  return grid_.point(beam, double{come_[static_cast<std::size_t>(beam)].candidate});
}

double MovingObstacle::widthOfRun() const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int beam : run_) nearest = std::min(nearest, footAt(beam).norm());
  return nearest * std::abs(grid_.azimuth_step) * (run_.back() - run_.front() + 1);
}

/// True where a beam has found nothing, nothing sure, or something well behind the foot: the sweep
/// looks over low things at what stands behind them.
bool MovingObstacle::inFrontOf(const BeamChoice& foot, const BeamChoice& choice) const {
  return !choice.any() || choice.doubtful || foot.candidate > choice.candidate + 2.0 * same_thing;
}

void MovingObstacle::complete(const ComparedFrame& frame, const SE2& T_floor_foot, double stamp,
                              std::vector<BeamChoice>& choices) {
  if (parameters_.moving_score <= 0.0 || choices.size() != come_.size()) return;
  const double since = stamp - feet_stamp_;
  longest_step_ = since <= longest_pause ? fastest * since + 2.0 * history_.cell() : -1.0;
  std::swap(feet_, feet_before_);
  feet_.clear();
  feet_stamp_ = stamp;
  for (std::size_t i = 0; i < come_.size(); ++i) {
    const int beam = static_cast<int>(i);
    come_[i] = footOf(frame, beam);
    if (come_[i].any() &&
        (!inFrontOf(come_[i], choices[i]) || !hasCome(frame, T_floor_foot, footAt(beam))))
      come_[i] = BeamChoice{};
  }
  for (int first = 0; first < static_cast<int>(come_.size()); ++first) {
    if (!come_[static_cast<std::size_t>(first)].any()) continue;
    collectRun(first);
    if (run_.size() > 1 && widthOfRun() >= widthAsked(choices) && seenAgain(T_floor_foot))
      publishRun(choices);
    first = run_.back();
  }
}

/// Twice as much where it would take the place of a contact.
double MovingObstacle::widthAsked(const std::vector<BeamChoice>& choices) const {
  const bool displaces = std::any_of(run_.begin(), run_.end(), [&](int beam) {
    const BeamChoice& choice = choices[static_cast<std::size_t>(beam)];
    return choice.any() && !choice.doubtful;
  });
  return (displaces ? 2.0 : 1.0) * parameters_.moving_width;
}

/// Remembers the feet of a run; true if one of them is a step from what the frame before had.
bool MovingObstacle::seenAgain(const SE2& T_floor_foot) {
  bool again = false;
  for (const int beam : run_) {
    const Eigen::Vector2d p_floor = T_floor_foot * footAt(beam);
    again = again || std::any_of(feet_before_.begin(), feet_before_.end(),
                                 [&](const Eigen::Vector2d& before) {
                                   return (p_floor - before).norm() <= longest_step_;
                                 });
    feet_.push_back(p_floor);
  }
  return again;
}

/// A run, and what it lacks in between: plain things look like floor there.
void MovingObstacle::publishRun(std::vector<BeamChoice>& choices) const {
  auto before = static_cast<std::size_t>(run_.front());
  for (const int beam : run_) {
    const auto here = static_cast<std::size_t>(beam);
    const BeamChoice &a = come_[before], &b = come_[here];
    for (std::size_t k = before; k <= here; ++k) {
      const float t = here == before
                          ? 0.0F
                          : static_cast<float>(k - before) / static_cast<float>(here - before);
      BeamChoice between = t < 0.5F ? a : b;
      between.candidate = a.candidate + t * (b.candidate - a.candidate);
      if (inFrontOf(between, choices[k])) choices[k] = between;
    }
    before = here;
  }
}

void MovingObstacle::remember(const SE2& T_floor_foot, const Obstacles& obstacles) {
  if (parameters_.moving_score <= 0.0) return;
  history_.beginFrame(obstacles.view.stamp, T_floor_foot.translation());
  for (const Bearing& bearing : obstacles.bearings) {
    if (bearing.state != BearingState::Occupied && bearing.state != BearingState::Free) continue;
    const Eigen::Vector2d ray(std::cos(bearing.angle), std::sin(bearing.angle));
    const Eigen::Vector2d p_end = obstacles.view.cameraFoot() + double{bearing.range} * ray;
    const bool seen_all = bearing.state == BearingState::Free &&
                          p_end.norm() > obstacles.max_range - at_limit * history_.cell();
    const double end =
        double{bearing.range} - (seen_all ? before_limit : before_end) * history_.cell();
    for (double d = bearing.near; d < end; d += step * history_.cell())
      history_.setFree(T_floor_foot * Eigen::Vector2d(d * ray));
  }
}

}  // namespace ipm_mapping::sweep
