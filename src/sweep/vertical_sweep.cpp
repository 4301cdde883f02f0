#include "ipm_mapping/sweep/vertical_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/kernels/sweep_costs.hpp"

namespace ipm_mapping::sweep {
namespace {

constexpr int place_step = 8;        // candidates between exact places
constexpr double below_view = 1.25;  // candidates reach this far below the image, in r
constexpr double half_beam = 0.5 * (kernels::beam_lines - 1);
constexpr double fraction_unit = 32767.0;  // 1/2^15 as a signed number
constexpr int block_rows = 32, leaning_block_rows = 8;
constexpr double weight_unit = 256.0;
constexpr int peak_reach = 6;       // candidates around a step that a maximum is compared with
constexpr float peak_share = 0.5F;  // of that maximum

}  // namespace

double VerticalSweep::azimuth(int beam) const { return grid_.azimuth(firstLine(beam) + half_beam); }

double VerticalSweep::r(double candidate) const {
  return grid_.r(sweepRow(candidate) * PolarGrid::rows_per_sweep_row);
}

void VerticalSweep::configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                              const std::vector<RowRange>& current_rows, double max_support,
                              const EvidenceParameters& p) {
  grid_ = grid;
  beam_step_ = p.beam_step;
  search_step_ = p.search_step;
  const double sweep_rows_per_log = grid.rows_per_log / PolarGrid::rows_per_sweep_row;
  support_rows_ = static_cast<int>(std::lround(-std::log(1.0 - max_support) * sweep_rows_per_log));
  first_row_ = std::min(support_rows_, grid.sweepRows());
  const int last_row =
      grid.sweepRows() + static_cast<int>(std::log(below_view) * sweep_rows_per_log);
  candidates_ = std::max(0, last_row - first_row_);
  beams_ = std::max(0, (grid.lines - kernels::beam_lines - 1) / beam_step_);
  floor_cap_ = static_cast<std::int32_t>(std::lround(p.floor_cap * kernels::cost_unit));
  prior_ = static_cast<std::int32_t>(std::lround(p.vertical_prior * kernels::cost_unit));
  const std::vector<RowRange> beams = commonRows(current_rows, kernels::beam_lines);
  beam_rows_.clear();
  for (int beam = 0; beam < beams_; ++beam)
    beam_rows_.push_back(beams[static_cast<std::size_t>(firstLine(beam))]);
  reference_rows_ = commonRows(reference_rows, kernels::beam_lines + 1);
  row_weight_.clear();
  for (int j = 0; j < grid.sweepRows(); ++j)
    row_weight_.push_back(static_cast<std::int32_t>(
        std::lround(weight_unit * p.evidence_rows * grid.r(j * PolarGrid::rows_per_sweep_row) /
                    sweep_rows_per_log)));
  bound_.resize(static_cast<std::size_t>(last_row + 1));
  row_r_.clear();
  for (int j = 0; j <= last_row; ++j) row_r_.push_back(grid.r(j * PolarGrid::rows_per_sweep_row));
  potential_.resize(bound_.size());
  evidence_.resize(static_cast<std::size_t>(block_rows + kernels::overrun));
  cost_.resize(evidence_.size());
  for (auto& places : places_) places.resize(static_cast<std::size_t>(candidates_));
}

/// Most that any support ending at a row can gain (vertical costs are never negative), and what all
/// rows above a row offer.
void VerticalSweep::bound(const SweepReference* references, int count, int beam) {
  const RowRange seen = rows(beam);
  std::int32_t best = 0, offered = 0;
  for (int j = 0; j < static_cast<int>(bound_.size()); ++j) {
    std::int32_t gain = 0;
    for (int q = 0; q < count && seen.contains(j); ++q) {
      const std::int32_t f = references[q].floor_cost.at(j, beam);
      if (f == kernels::no_cost) continue;
      gain += ((std::min(f, floor_cap_) - prior_) * row_weight_[static_cast<std::size_t>(j)]) >> 8;
    }
    potential_[static_cast<std::size_t>(j)] = offered;
    offered += std::max(gain, 0);
    best = std::max(best + gain, 0);
    bound_[static_cast<std::size_t>(j)] = best;
  }
}

/// Exact places of every place_step-th candidate, straight lines in between.
void VerticalSweep::place(const FootMotion& motion, int beam, std::vector<Place>& places) const {
  const Eigen::Vector2d direction(std::cos(azimuth(beam)), std::sin(azimuth(beam)));
  const auto exact = [&](int candidate) {
    const double d = distance(candidate);
    const Eigen::Vector2d p = motion * (d * direction);
    const double d2 = p.squaredNorm();
    return Place{grid_.line(std::atan2(p.y(), p.x())) - half_beam,
                 0.5 * grid_.rows_per_log * std::log(d * d / d2)};
  };
  Place a = exact(0);
  for (int c = 0; c < candidates_; c += place_step) {
    const Place b = exact(c + place_step);
    for (int k = 0; k < place_step && c + k < candidates_; ++k) {
      const double t = static_cast<double>(k) / place_step;
      places[static_cast<std::size_t>(c + k)] = {a.line + t * (b.line - a.line),
                                                 a.shift + t * (b.shift - a.shift)};
    }
    a = b;
  }
}

/// Where a candidate's vertical line is found in one reference, and on which rows.
VerticalSweep::Aim VerticalSweep::aim(const SweepReference& reference, const Place& place,
                                      RowRange support) const {
  Aim aim;
  const double line_floor = std::floor(place.line), shift_floor = std::floor(place.shift);
  if (!(line_floor >= 0.0 && line_floor < static_cast<double>(reference_rows_.size()))) return aim;
  const int line = static_cast<int>(line_floor), shift = static_cast<int>(shift_floor);
  const RowRange seen = reference_rows_[static_cast<std::size_t>(line)];
  // fine row 2 j + shift and the one after it have to be in view
  aim.rows = intersection(support, {(seen.begin - shift + 1) >> 1, (seen.end - shift) >> 1});
  const int half = shift >> 1;
  const bool odd = (shift & 1) != 0;
  aim.upper = (odd ? reference.odd : reference.even).row(line);
  aim.lower = (odd ? reference.even : reference.odd).row(line);
  aim.upper_offset = half;
  aim.lower_offset = odd ? half + 1 : half;
  aim.row_fraction = static_cast<std::int16_t>((place.shift - shift_floor) * fraction_unit);
  aim.line_fraction = static_cast<std::int16_t>((place.line - line_floor) * fraction_unit);
  return aim;
}

/// Adds to the evidence of a block of rows what one reference says about a candidate.
void VerticalSweep::addEvidence(const CurrentView& current, const SweepReference& reference,
                                const Aim& aim, int beam, RowRange block) {
  const RowRange rows = intersection(aim.rows, block);
  if (rows.size() == 0) return;
  kernels::VerticalPath path;
  path.stride = grid_.sweepRows();
  path.current = current.grey.row(firstLine(beam)) + rows.begin;
  path.weight = current.weight.row(firstLine(beam)) + rows.begin;
  path.upper = aim.upper + rows.begin + aim.upper_offset;
  path.lower = aim.lower + rows.begin + aim.lower_offset;
  path.row_fraction = aim.row_fraction;
  path.line_fraction = aim.line_fraction;
  kernels::verticalCost(path, rows.size(), cost_.data());
  kernels::accumulateEvidence(reference.floor_cost.row(beam) + rows.begin, cost_.data(),
                              row_weight_.data() + rows.begin, floor_cap_, prior_, rows.size(),
                              evidence_.data() + (rows.begin - block.begin));
}

/// Where a candidate's line is found in every reference.
void VerticalSweep::aimAll(const SweepReference* references, int count, int candidate,
                           RowRange support) {
  const auto c = static_cast<std::size_t>(std::clamp(candidate, 0, candidates_ - 1));
  for (int q = 0; q < count; ++q)
    aims_[static_cast<std::size_t>(q)] =
        aim(references[q], places_[static_cast<std::size_t>(q)][c], support);
}

/// Candidate at whose distance a surface that leans away is met on a row: with d the contact's
/// distance and r the row's, the height is z = (h - r d) / (1 + r lean), the distance d + lean z.
int VerticalSweep::leaningCandidate(int candidate, double lean, int row) const {
  const double ratio = grid_.r(row * PolarGrid::rows_per_sweep_row) / r(candidate);
  const double rise = (1.0 - ratio) / (1.0 + ratio * r(candidate) * lean);  // z / h
  const double farther = std::log1p(lean * rise * r(candidate));            // ln of the distances
  return candidate - static_cast<int>(
                         std::lround(farther * grid_.rows_per_log / PolarGrid::rows_per_sweep_row));
}

/// Score of one candidate, block by block upward from the contact. It stops where even the whole
/// gain that the floor's cost still offers above cannot raise the score: nothing is lost by that.
float VerticalSweep::scoreOf(const CurrentView& current, const SweepReference* references,
                             int count, int beam, int candidate, double lean, std::int32_t least,
                             std::int16_t& top) {
  const int contact = first_row_ + candidate;
  const RowRange support = intersection(rows(beam), {contact - support_rows_, contact + 1});
  if (support.size() < 2) return 0.0F;
  aimAll(references, count, candidate, support);
  const int step = lean > 0.0 ? leaning_block_rows : block_rows;
  std::int32_t sum = 0, best = 0;
  int best_row = support.end - 1;
  for (int end = support.end; end > support.begin; end -= step) {
    const RowRange block{std::max(support.begin, end - step), end};
    if (lean > 0.0)
      aimAll(references, count, leaningCandidate(candidate, lean, (block.begin + end) / 2),
             support);
    std::fill_n(evidence_.begin(), step, 0);
    for (int q = 0; q < count; ++q)
      addEvidence(current, references[q], aims_[static_cast<std::size_t>(q)], beam, block);
    for (int j = block.end - 1; j >= block.begin; --j) {
      sum += evidence_[static_cast<std::size_t>(j - block.begin)];
      if (sum > best) best = sum, best_row = j;
    }
    const std::int32_t reachable = sum + potential_[static_cast<std::size_t>(block.begin)] -
                                   potential_[static_cast<std::size_t>(support.begin)];
    if (std::max(best, reachable) < least) return 0.0F;
    if (reachable <= best) break;
  }
  top = static_cast<std::int16_t>(best_row);
  return static_cast<float>(best) / static_cast<float>(kernels::cost_unit * count);
}

void VerticalSweep::aimBeam(const SweepReference* references, int count, int beam) {
  bound(references, count, beam);
  for (int q = 0; q < count; ++q)
    place(references[q].motion, beam, places_[static_cast<std::size_t>(q)]);
}

float VerticalSweep::leaningScore(const CurrentView& current, const SweepReference* references,
                                  int count, int beam, int candidate, double lean,
                                  float least_score, std::int16_t& top) {
  count = std::min(count, max_references);
  const auto least =
      static_cast<std::int32_t>(least_score * static_cast<float>(kernels::cost_unit * count));
  return scoreOf(current, references, count, beam, candidate, lean, least, top);
}

/// Scores of one beam. Maxima are wider than search_step: between two evaluated candidates only the
/// neighbourhood of a maximum is evaluated too, the rest lies on a straight line.
void VerticalSweep::evaluateBeam(const CurrentView& current, const SweepReference* references,
                                 int count, int beam, std::int32_t least, float* score,
                                 std::int16_t* top) {
  const auto exact = [&](int c) {
    if (bound_[static_cast<std::size_t>(first_row_ + c)] >= least)
      score[c] = scoreOf(current, references, count, beam, c, 0.0, least, top[c]);
  };
  for (int c = 0; c < candidates_; c += search_step_) exact(c);
  for (int c = search_step_; search_step_ > 1 && c < candidates_; c += search_step_) {
    const int before = c - search_step_;
    const float ends = std::max(score[before], score[c]);
    if (ends <= 0.0F) continue;
    const int from = std::max(0, before - peak_reach);
    const int to = std::min(candidates_, c + peak_reach + 1);
    const bool near_peak = ends >= peak_share * *std::max_element(score + from, score + to);
    for (int k = before + 1; k < c; ++k) {
      if (near_peak) {
        exact(k);
        continue;
      }
      const auto t = static_cast<float>(k - before) / static_cast<float>(search_step_);
      score[k] = score[before] + t * (score[c] - score[before]);
      top[k] = score[before] > score[c] ? top[before] : top[c];
    }
  }
}

void VerticalSweep::evaluate(const CurrentView& current, const SweepReference* references,
                             int count, float least_score, SweepScores& scores) {
  count = std::min(count, max_references);
  scores.score.ensure(candidates_, beams_);
  scores.top.ensure(candidates_, beams_);
  const auto least =
      static_cast<std::int32_t>(least_score * static_cast<float>(kernels::cost_unit * count));
  for (int beam = 0; beam < beams_; ++beam) {
    float* score = scores.score.row(beam);
    std::int16_t* top = scores.top.row(beam);
    std::fill(score, score + candidates_, 0.0F);
    std::fill(top, top + candidates_, static_cast<std::int16_t>(grid_.sweepRows()));
    bound(references, count, beam);
    if (*std::max_element(bound_.begin(), bound_.end()) < least) continue;
    for (int q = 0; q < count; ++q)
      place(references[q].motion, beam, places_[static_cast<std::size_t>(q)]);
    evaluateBeam(current, references, count, beam, least, score, top);
  }
}

}  // namespace ipm_mapping::sweep
