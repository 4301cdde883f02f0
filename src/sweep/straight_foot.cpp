#include "ipm_mapping/sweep/straight_foot.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping::sweep {
namespace {

constexpr int widest_gap = 5;        // beams within a run that may lack a contact on its line
constexpr std::size_t settled = 4;   // contacts after which a line is as good as its tolerance
constexpr double unsettled = 1.5;    // times the tolerance before
constexpr double other_thing = 3.0;  // candidates off the line
constexpr int most_missed = 1;       // beams in a row where the edge may be gone
constexpr float edge_memory = 0.8F;  // contrast changes slowly along an edge

}  // namespace

void FloorLine::add(const Eigen::Vector2d& direction, double r) {
  const Eigen::Vector2d u = direction / r;
  xx_ += u.x() * u.x();
  xy_ += u.x() * u.y();
  yy_ += u.y() * u.y();
  x_ += u.x();
  y_ += u.y();
  const double det = xx_ * yy_ - xy_ * xy_;
  if (det > 1e-12 * xx_ * xx_) line_ = {(yy_ * x_ - xy_ * y_) / det, (xx_ * y_ - xy_ * x_) / det};
}

void StraightFoot::configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                             const FootParameters& parameters) {
  parameters_ = parameters;
  grid_ = sweep.scoreGrid();
  edge_.configure(sweep, free_floor, parameters);
  least_support_ = static_cast<int>(std::lround(grid_.rowsUp(parameters.foot_support)));
  direction_.clear();
  for (int beam = 0; beam < sweep.beams(); ++beam)
    direction_.emplace_back(std::cos(sweep.azimuth(beam)), std::sin(sweep.azimuth(beam)));
  run_.reserve(direction_.size());
  contacts_behind_.resize(direction_.size());
  continued_.resize(direction_.size());
}

Eigen::Vector2d StraightFoot::point(int beam, double r) const {
  return grid_.height / r * direction_[static_cast<std::size_t>(beam)];
}

/// Contacts from `first` on that lie on one line, small gaps allowed; true if they say enough.
bool StraightFoot::collect(const Scene& scene, int first, Run& run) {
  run_.clear();
  const int beams = static_cast<int>(direction_.size());
  for (int beam = first, gap = 0; beam < beams && gap <= widest_gap; ++beam, ++gap) {
    const BeamChoice& choice = scene.choices[static_cast<std::size_t>(beam)];
    if (!choice.any()) continue;
    const Eigen::Vector2d& direction = direction_[static_cast<std::size_t>(beam)];
    if (run_.size() >= 2) {
      const double r = run.line.r(direction);
      const double tolerance = parameters_.foot_tolerance * (run_.size() < settled ? unsettled : 1);
      if (!(r > 0.0) || std::abs(choice.candidate - grid_.candidateOfSlope(r)) > tolerance)
        continue;
    }
    run.line.add(direction, scene.frame.sweep.r(choice.candidate));
    run_.push_back(beam);
    gap = -1;
  }
  return static_cast<int>(run_.size()) >= parameters_.foot_beams && measure(scene, run);
}

/// False where the run is too short, too low, not straight, or no edge of one polarity runs along
/// it.
bool StraightFoot::measure(const Scene& scene, Run& run) const {
  const double r_front = run.line.r(direction_[static_cast<std::size_t>(run_.front())]);
  const double r_back = run.line.r(direction_[static_cast<std::size_t>(run_.back())]);
  if (!(r_front > 0.0) || !(r_back > 0.0)) return false;
  run.length = (point(run_.front(), r_front) - point(run_.back(), r_back)).norm();
  if (run.length < parameters_.foot_length * grid_.height) return false;
  KnownFoot& foot = run.foot;
  float sum = 0.0F, sizes = 0.0F;
  for (const int beam : run_) {
    const BeamChoice& choice = scene.choices[static_cast<std::size_t>(beam)];
    const double r = run.line.r(direction_[static_cast<std::size_t>(beam)]);
    if (!(r > 0.0) ||
        std::abs(choice.candidate - grid_.candidateOfSlope(r)) > parameters_.foot_tolerance)
      return false;
    const float g = FootEdge::contrastAt(scene.frame, beam, choice);
    sum += g;
    sizes += std::abs(g);
    const int support = static_cast<int>(scene.frame.sweep.sweepRow(choice.candidate)) - choice.top;
    const bool first = beam == run_.front();
    foot.score = first ? choice.score : std::min(foot.score, choice.score);
    foot.support = first ? support : std::min(foot.support, support);
  }
  if (foot.support < least_support_) return false;
  foot.contrast = sum / static_cast<float>(run_.size());
  return std::abs(sum) == sizes && std::abs(foot.contrast) >= parameters_.foot_contrast;
}

void StraightFoot::walk(const Scene& scene, const Run& run, int side) {
  const int end = side < 0 ? run_.front() : run_.back();
  const int contacts = static_cast<int>(run_.size()), beams = static_cast<int>(direction_.size());
  FloorLine line = run.line;
  KnownFoot known = run.foot;
  const Eigen::Vector2d start = point(end, line.r(direction_[static_cast<std::size_t>(end)]));
  int missed = 0;
  for (int beam = end + side; beam >= 0 && beam < beams && missed <= most_missed; beam += side) {
    const auto i = static_cast<std::size_t>(beam);
    const double r = line.r(direction_[i]);
    if (!(r > 0.0) || (point(beam, r) - start).norm() > parameters_.foot_reach * run.length) return;
    const double expected = grid_.candidateOfSlope(r);
    if (scene.choices[i].any()) {
      if (std::abs(scene.choices[i].candidate - expected) > other_thing) return;
      missed = 0;
      continue;
    }
    const BeamChoice foot = edge_.find(scene.frame, known, beam, expected);
    ++missed;
    if (!foot.any()) continue;
    missed = 0;
    line.add(direction_[i], scene.frame.sweep.r(foot.candidate));
    known.contrast = edge_memory * known.contrast +
                     (1.0F - edge_memory) * FootEdge::contrastAt(scene.frame, beam, foot);
    if (contacts <= contacts_behind_[i]) continue;
    continued_[i] = foot;
    contacts_behind_[i] = contacts;
  }
}

void StraightFoot::complete(const ComparedFrame& frame, std::vector<BeamChoice>& choices) {
  if (parameters_.foot_reach <= 0.0 || choices.size() != direction_.size()) return;
  const Scene scene{frame, choices};
  std::fill(contacts_behind_.begin(), contacts_behind_.end(), 0);
  const int beams = static_cast<int>(choices.size());
  for (int beam = 0; beam < beams; ++beam) {
    Run run;
    if (!choices[static_cast<std::size_t>(beam)].any() || !collect(scene, beam, run)) continue;
    walk(scene, run, -1);
    walk(scene, run, 1);
    beam = run_.back() - 1;  // the end of one face may begin the next
  }
  for (std::size_t i = 0; i < choices.size(); ++i)
    if (contacts_behind_[i] > 0) choices[i] = continued_[i];
}

}  // namespace ipm_mapping::sweep
