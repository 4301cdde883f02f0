#include "ipm_mapping/sweep/level_top.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace ipm_mapping::sweep {
namespace {

constexpr int peak_reach = 6;  // candidates around a maximum that belong to it
constexpr float least_evidence = 1.0F;
constexpr double flat_face = 0.08;   // log, as top_length: 8 % of the camera's height
constexpr int face_rows = 5;         // fewer say nothing of a height
constexpr int front_rows = 4;        // of a top in front of a candidate that lies on it
constexpr float front_slope = 0.1F;  // per candidate, of the maximum made there: flat
constexpr float above = 1.01F;       // a threshold

}  // namespace

void LevelTop::configure(const VerticalSweep& sweep, const SelectionParameters& parameters) {
  parameters_ = parameters;
  const ScoreGrid grid = sweep.scoreGrid();
  const auto rows = [&](double log) { return log * grid.candidates_per_log; };
  least_rows_ = std::max(1, static_cast<int>(std::lround(rows(parameters.top_length))));
  const double lower = std::clamp(parameters.least_height / grid.height, 0.0, 0.9);
  least_face_ = std::max(face_rows, static_cast<int>(std::ceil(grid.rowsUp(lower))));
  flat_face_ = static_cast<int>(std::lround(rows(flat_face)));
  slabs_.reserve(static_cast<std::size_t>(std::max(0, sweep.candidates())));
}

/// The best level surface that begins near the upper end of a candidate's face.
LevelTop::Top LevelTop::topOf(const ComparedFrame& frame, int beam, int candidate, int top) const {
  const int contact = static_cast<int>(frame.sweep.sweepRow(candidate));
  const int last = std::min(top + parameters_.top_reach, contact - least_face_);
  Top best;
  for (int begin = top; begin <= last; ++begin) {
    std::int16_t end = 0;
    const float score = frame.sweep.levelScore(frame.references, frame.count, beam, candidate,
                                               begin, std::max(least_evidence, best.score), end);
    if (begin - end >= least_rows_ && score > best.score) best = {begin, score};
  }
  return best;
}

void LevelTop::findSlabs(const ComparedFrame& frame, const BearingSelection& selection,
                         const SweepScores& scores, int beam, double farthest) {
  slabs_.clear();
  VerticalSweep& sweep = frame.sweep;
  const float* s = scores.score.row(beam);
  const auto share = static_cast<float>(parameters_.weak_share);
  const auto clear = static_cast<float>(parameters_.nearer_score);
  const int in_view = sweep.rows(beam).end - static_cast<int>(sweep.sweepRow(0.0));
  const int end = std::min(in_view, sweep.candidates() - 1);
  bool aimed = false;
  for (int c = 1; c < end; ++c) {
    if (!(s[c] > 0.0F) || s[c] < s[c - 1] || !(s[c] > s[c + 1])) continue;
    if (s[c] < share * selection.leastScore(c) || s[c] > clear) continue;
    if (sweep.distance(c) > farthest) continue;
    if (!aimed) {
      sweep.offered(frame.references, frame.count, beam, c);
      sweep.aimBeam(frame.current, frame.references, frame.count, beam);
      aimed = true;
    }
    const Top top = topOf(frame, beam, c, scores.top.at(c, beam));
    if (top.score < least_evidence) continue;
    Slab slab{c, s[c], top, top.begin - 1, 0.0F};
    if (static_cast<int>(sweep.sweepRow(c)) - top.begin <= flat_face_)
      slab.front_score =
          sweep.levelFront(frame.references, frame.count, beam, c, top.begin, slab.front);
    slabs_.push_back(slab);
  }
}

/// To at least what it takes to be a clear contact; the whole maximum keeps its shape.
void LevelTop::raise(const Slab& slab, float clear, float* score, int candidates) {
  const float target = std::max(clear, slab.score + slab.top.score);
  const float most = score[slab.candidate];
  if (most >= target) return;  // by the maximum beside it
  const int from = std::max(0, slab.candidate - peak_reach);
  const int to = std::min(candidates - 1, slab.candidate + peak_reach);
  for (int c = from; c <= to; ++c)
    if (score[c] <= most) score[c] *= target / most;
}

void LevelTop::moveToFront(const Slab& slab, int front, float clear, SweepScores& scores, int beam,
                           int candidates) {
  float* s = scores.score.row(beam);
  const float score = std::max(clear, slab.score + slab.top.score + slab.front_score);
  const int to = std::min(candidates - 1, front + peak_reach);
  for (int c = std::max(0, front - peak_reach); c <= to; ++c) {
    const float here = score - front_slope * static_cast<float>(std::abs(c - front));
    if (here <= s[c]) continue;
    s[c] = here;
    scores.top.at(c, beam) = static_cast<std::int16_t>(slab.front + 1 + c - front);
  }
}

/// A floor point that is seen at r but is at r + tilt moves as one that is z high, with
/// r^2 / (h - z) = (r + tilt)^2 / h.
double LevelTop::farthest(double tilt) const {
  const double raised = 2.0 * tilt;  // per metre
  return raised > 0.0 ? 0.5 * parameters_.least_height / raised
                      : std::numeric_limits<double>::infinity();
}

void LevelTop::add(const ComparedFrame& frame, const BearingSelection& selection, const Sway& tilt,
                   SweepScores& scores) {
  if (parameters_.top_length <= 0.0) return;
  const int candidates = frame.sweep.candidates();
  const auto clear = [&](int candidate) {
    return above *
           std::max(static_cast<float>(parameters_.nearer_score), selection.leastScore(candidate));
  };
  for (int beam = 0; beam < frame.sweep.beams(); ++beam) {
    findSlabs(frame, selection, scores, beam, farthest(tilt.at(frame.sweep.azimuth(beam))));
    for (const Slab& slab : slabs_) {
      raise(slab, clear(slab.candidate), scores.score.row(beam), candidates);
      const int nearer = slab.front + 1 - slab.top.begin;
      const int front = slab.candidate + nearer;
      if (nearer >= front_rows && slab.front_score >= least_evidence && front < candidates)
        moveToFront(slab, front, clear(front), scores, beam, candidates);
    }
  }
}

}  // namespace ipm_mapping::sweep
