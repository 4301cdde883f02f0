#include "ipm_mapping/sweep/straight_foot.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/sweep/contact_edge.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int widest_gap = 5;        // beams within a run that may lack a contact on its line
constexpr std::size_t settled = 4;   // contacts after which a line is as good as its tolerance
constexpr double unsettled = 1.5;    // times the tolerance before
constexpr double other_thing = 3.0;  // candidates off the line
constexpr int most_missed = 1;       // beams in a row where the edge may be gone
constexpr float edge_memory = 0.8F;  // contrast changes slowly along an edge

/// Strongest change within a row of a contact, signed.
float contrastAt(const CurrentView& current, const VerticalSweep& sweep, int beam,
                 const BeamChoice& choice) {
  const RowRange seen = sweep.rows(beam);
  const int centre = static_cast<int>(std::lround(sweep.sweepRow(choice.candidate)));
  float strongest = 0.0F;
  for (int row = centre - 1; row <= centre + 1; ++row) {
    if (row <= seen.begin || row + 1 >= seen.end) continue;
    const float g = edgeContrast(current, sweep.firstLine(beam), row);
    if (std::abs(g) > std::abs(strongest)) strongest = g;
  }
  return strongest;
}

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

void StraightFoot::configure(const VerticalSweep& sweep, double height,
                             const SelectionParameters& selection,
                             const StraightFootParameters& parameters) {
  selection_ = selection;
  parameters_ = parameters;
  height_ = height;
  first_r_ = sweep.r(0.0);
  candidates_per_log_ = 1.0 / std::log(sweep.r(1.0) / first_r_);
  plain_edge_.configure(sweep, selection, parameters);
  direction_.clear();
  for (int beam = 0; beam < sweep.beams(); ++beam)
    direction_.emplace_back(std::cos(sweep.azimuth(beam)), std::sin(sweep.azimuth(beam)));
  run_.reserve(direction_.size());
  contacts_behind_.resize(direction_.size());
  continued_.resize(direction_.size());
}

double StraightFoot::candidateOf(double r) const {
  return candidates_per_log_ * std::log(r / first_r_);
}

Eigen::Vector2d StraightFoot::point(int beam, double r) const {
  return height_ / r * direction_[static_cast<std::size_t>(beam)];
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
      if (!(r > 0.0) || std::abs(choice.candidate - candidateOf(r)) > tolerance) continue;
    }
    run.line.add(direction, scene.sweep.r(choice.candidate));
    run_.push_back(beam);
    gap = -1;
  }
  return static_cast<int>(run_.size()) >= parameters_.foot_beams && measure(scene, run);
}

/// False where the run is too short, not straight, or no edge of one polarity runs along it.
bool StraightFoot::measure(const Scene& scene, Run& run) const {
  const double r_front = run.line.r(direction_[static_cast<std::size_t>(run_.front())]);
  const double r_back = run.line.r(direction_[static_cast<std::size_t>(run_.back())]);
  if (!(r_front > 0.0) || !(r_back > 0.0)) return false;
  run.length = (point(run_.front(), r_front) - point(run_.back(), r_back)).norm();
  if (run.length < parameters_.foot_length * height_) return false;
  float sum = 0.0F, sizes = 0.0F;
  for (const int beam : run_) {
    const BeamChoice& choice = scene.choices[static_cast<std::size_t>(beam)];
    const double r = run.line.r(direction_[static_cast<std::size_t>(beam)]);
    if (!(r > 0.0) || std::abs(choice.candidate - candidateOf(r)) > parameters_.foot_tolerance)
      return false;
    const float g = contrastAt(scene.current, scene.sweep, beam, choice);
    sum += g;
    sizes += std::abs(g);
    const int support = static_cast<int>(scene.sweep.sweepRow(choice.candidate)) - choice.top;
    run.score = beam == run_.front() ? choice.score : std::min(run.score, choice.score);
    run.support = beam == run_.front() ? support : std::min(run.support, support);
  }
  run.contrast = sum / static_cast<float>(run_.size());
  return std::abs(sum) == sizes && std::abs(run.contrast) >= parameters_.foot_contrast;
}

/// Is everything from the near end of the view up to the edge floor in the eyes of the references?
bool StraightFoot::floorInFront(const Scene& scene, int beam, int row) const {
  const int end = scene.sweep.rows(beam).end;
  for (int from = row + PlainEdge::edge_rows; from < end; from += selection_.free_window) {
    int sum = 0, number = 0;
    for (int q = 0; q < scene.count; ++q) {
      const std::uint16_t* cost = scene.references[q].floor_cost.row(beam);
      for (int j = from; j < std::min(end, from + selection_.free_window); ++j) {
        if (cost[j] == kernels::no_cost) continue;
        sum += cost[j];
        ++number;
      }
    }
    if (sum > selection_.free_cost * kernels::cost_unit * number) return false;
  }
  return true;
}

/// Floor in front, and behind the edge nothing that only floor explains.
bool StraightFoot::mayStand(const Scene& scene, int beam, int candidate) const {
  const int row = static_cast<int>(scene.sweep.sweepRow(candidate));
  if (!floorInFront(scene, beam, row)) return false;
  scene.sweep.aimBeam(scene.references, scene.count, beam);
  return plain_edge_.mayStand(scene.current, scene.references, scene.count, scene.sweep, beam,
                              candidate);
}

/// The edge near an expected candidate, as a contact; nothing where it is not the run's.
BeamChoice StraightFoot::footAt(const Scene& scene, const Run& run, int beam, double expected,
                                float contrast) const {
  BeamChoice foot;
  const int first_row = static_cast<int>(scene.sweep.sweepRow(0.0));
  const RowRange seen = scene.sweep.rows(beam);
  const int centre = static_cast<int>(std::lround(expected));
  const int from = centre - parameters_.foot_window, to = centre + parameters_.foot_window;
  if (from < 0 || to >= scene.sweep.candidates() || first_row + from - 2 < seen.begin ||
      first_row + to + 2 >= seen.end)
    return foot;
  const auto along = [&](int candidate) {
    return edgeContrast(scene.current, scene.sweep.firstLine(beam), first_row + candidate) /
           contrast;
  };
  int best = from;
  float most = along(from);
  for (int c = from + 1; c <= to; ++c) {
    const float share = along(c);
    if (share > most) most = share, best = c;
  }
  const auto least = static_cast<float>(parameters_.foot_share);
  if (most < least || most * least > 1.0F || !mayStand(scene, beam, best)) return foot;
  const float before = along(best - 1), after = along(best + 1);
  const float bend = before - 2.0F * most + after;
  foot.candidate = static_cast<float>(best);
  if (bend < -1e-3F && most >= before && most >= after)
    foot.candidate += 0.5F * (before - after) / bend;
  foot.score = static_cast<float>(parameters_.foot_score) * run.score;
  foot.top = first_row + best - run.support;
  return foot;
}

void StraightFoot::walk(const Scene& scene, const Run& run, int side) {
  const int end = side < 0 ? run_.front() : run_.back();
  const int contacts = static_cast<int>(run_.size()), beams = static_cast<int>(direction_.size());
  FloorLine line = run.line;
  float contrast = run.contrast;
  const Eigen::Vector2d start = point(end, line.r(direction_[static_cast<std::size_t>(end)]));
  int missed = 0;
  for (int beam = end + side; beam >= 0 && beam < beams && missed <= most_missed; beam += side) {
    const auto i = static_cast<std::size_t>(beam);
    const double r = line.r(direction_[i]);
    if (!(r > 0.0) || (point(beam, r) - start).norm() > parameters_.foot_reach * run.length) return;
    const double expected = candidateOf(r);
    if (scene.choices[i].any()) {
      if (std::abs(scene.choices[i].candidate - expected) > other_thing) return;
      missed = 0;
      continue;
    }
    const BeamChoice foot = footAt(scene, run, beam, expected, contrast);
    ++missed;
    if (!foot.any()) continue;
    missed = 0;
    line.add(direction_[i], scene.sweep.r(foot.candidate));
    contrast = edge_memory * contrast +
               (1.0F - edge_memory) * contrastAt(scene.current, scene.sweep, beam, foot);
    if (contacts <= contacts_behind_[i]) continue;
    continued_[i] = foot;
    contacts_behind_[i] = contacts;
  }
}

void StraightFoot::complete(const CurrentView& current, const SweepReference* references, int count,
                            VerticalSweep& sweep, std::vector<BeamChoice>& choices) {
  if (parameters_.foot_reach <= 0.0 || choices.size() != direction_.size()) return;
  const Scene scene{current, references, count, sweep, choices};
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
