#include "ipm_mapping/sweep/vertical_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ipm_mapping::sweep {
namespace {

constexpr double below_view = 1.25;  // candidates reach this far below the image, in r
constexpr int leaning_block_rows = 8;
constexpr int upright = -1;  // as a slope
constexpr double weight_unit = 256.0;
constexpr int peak_reach = 6;       // candidates around a step that a maximum is compared with
constexpr float peak_share = 0.5F;  // of that maximum
constexpr std::int32_t any_brightness = 255 * kernels::grey_unit;

}  // namespace

double VerticalSweep::azimuth(int beam) const { return grid_.azimuth(firstLine(beam) + half_beam); }

double VerticalSweep::r(double candidate) const {
  return grid_.r(sweepRow(candidate) * PolarGrid::rows_per_sweep_row);
}

ScoreGrid VerticalSweep::scoreGrid() const {
  ScoreGrid grid;
  grid.first_azimuth = azimuth(0);
  grid.azimuth_step = azimuth(1) - azimuth(0);
  grid.first_slope = r(0.0);
  grid.candidates_per_log = 1.0 / std::log(r(1.0) / r(0.0));
  grid.height = grid_.height;
  return grid;
}

void VerticalSweep::configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                              const std::vector<RowRange>& current_rows, double max_support,
                              const EvidenceParameters& p) {
  grid_ = grid;
  beam_step_ = p.beam_step;
  search_step_ = p.search_step;
  rival_share_ = static_cast<float>(p.rival_share);
  const double sweep_rows_per_log = grid.rows_per_log / PolarGrid::rows_per_sweep_row;
  support_rows_ = static_cast<int>(std::lround(-std::log(1.0 - max_support) * sweep_rows_per_log));
  first_row_ = std::min(support_rows_, grid.sweepRows());
  const int last_row =
      grid.sweepRows() + static_cast<int>(std::log(below_view) * sweep_rows_per_log);
  candidates_ = std::max(0, last_row - first_row_);
  beams_ = std::max(0, (grid.lines - kernels::beam_lines - 1) / beam_step_);
  floor_cap_ = static_cast<std::int32_t>(std::lround(p.floor_cap * kernels::cost_unit));
  prior_ = static_cast<std::int32_t>(std::lround(p.vertical_prior * kernels::cost_unit));
  brightness_ = static_cast<std::int32_t>(std::lround(p.vertical_brightness * kernels::grey_unit));
  brightness_rows_ = std::max(
      CandidateLines::least_patch + 1,
      static_cast<int>(std::lround(-std::log(1.0 - p.brightness_support) * sweep_rows_per_log)));
  const std::vector<RowRange> beams = commonRows(current_rows, kernels::beam_lines);
  beam_rows_.clear();
  for (int beam = 0; beam < beams_; ++beam)
    beam_rows_.push_back(beams[static_cast<std::size_t>(firstLine(beam))]);
  row_weight_.clear();
  for (int j = 0; j < grid.sweepRows(); ++j)
    row_weight_.push_back(static_cast<std::int32_t>(
        std::lround(weight_unit * p.evidence_rows * grid.r(j * PolarGrid::rows_per_sweep_row) /
                    sweep_rows_per_log)));
  row_weight_.resize(row_weight_.size() + kernels::overrun);
  bound_.resize(static_cast<std::size_t>(last_row + 1));
  row_r_.clear();
  for (int j = 0; j <= last_row; ++j) row_r_.push_back(grid.r(j * PolarGrid::rows_per_sweep_row));
  potential_.resize(bound_.size());
  gain_.resize(bound_.size() + kernels::overrun);
  least_vertical_.assign(
      gain_.size(),
      static_cast<std::uint16_t>(std::lround(p.least_vertical_cost * kernels::cost_unit)));
  vertical_cost_.resize(gain_.size());
  std::vector<float> inverse_distance;
  for (int c = 0; c < candidates_; ++c)
    inverse_distance.push_back(static_cast<float>(candidateR(c) / grid.height));
  lines_.configure(grid, reference_rows, inverse_distance);
  tabulateLeaning();
}

/// Most that any support ending at a row can gain (noise makes every vertical line cost something),
/// and what all rows above a row offer. Returns the most of all rows.
std::int32_t VerticalSweep::bound(const SweepReference* references, int count, int beam) {
  const RowRange seen = rows(beam);
  std::fill(gain_.begin(), gain_.end(), 0);
  for (int q = 0; q < count; ++q)
    kernels::accumulateEvidence(references[q].floor_cost.row(beam) + seen.begin,
                                least_vertical_.data(), row_weight_.data() + seen.begin, floor_cap_,
                                prior_, seen.size(), gain_.data() + seen.begin);
  std::int32_t best = 0, offered = 0, most = 0;
  for (std::size_t j = 0; j < bound_.size(); ++j) {
    potential_[j] = offered;
    offered += std::max(gain_[j], 0);
    best = std::max(best + gain_[j], 0);
    bound_[j] = best;
    most = std::max(most, best);
  }
  return most;
}

void VerticalSweep::aimBeam(const CurrentView& current, const SweepReference* references, int count,
                            int beam) {
  lines_.aimBeam(current, references, std::min(count, max_references), beam, firstLine(beam));
}

/// How many candidates farther a surface that leans away is met on a row than at its contact: with
/// d the contact's distance and r the row's, the height is z = (h - r d) / (1 + r lean), the
/// distance d + lean z.
int VerticalSweep::fartherBy(int candidate, double lean, int row) const {
  const double r_contact = candidateR(candidate);
  const double ratio = row_r_[static_cast<std::size_t>(row)] / r_contact;
  const double rise = (1.0 - ratio) / (1.0 + ratio * r_contact * lean);  // z / h
  const double farther = std::log1p(lean * rise * r_contact);            // ln of the distances
  return static_cast<int>(
      std::lround(farther * grid_.rows_per_log / PolarGrid::rows_per_sweep_row));
}

void VerticalSweep::tabulateLeaning() {
  for (std::size_t slope = 0; slope < lean_slopes.size(); ++slope) {
    farther_[slope].resize(support_rows_ + 1, candidates_);
    for (int c = 0; c < candidates_; ++c)
      for (int k = 0; k <= support_rows_ && k <= first_row_ + c; ++k)
        farther_[slope].at(k, c) =
            static_cast<std::int16_t>(fartherBy(c, lean_slopes[slope], first_row_ + c - k));
  }
}

/// Score of one candidate, block by block upward from the contact. It stops where even the whole
/// gain that the floor's cost still offers above cannot raise the score: nothing is lost by that.
/// The brightness of a leaning surface is taken from the upright patch at its foot.
float VerticalSweep::scoreOf(const SweepReference* references, int count, int beam, int candidate,
                             int slope, std::int32_t least, std::int16_t& top) {
  const int contact = first_row_ + candidate;
  const RowRange support = intersection(rows(beam), {contact - support_rows_, contact + 1});
  if (support.size() < 2) return 0.0F;
  const kernels::EvidenceTerms terms{row_weight_.data(), potential_.data(), floor_cap_, prior_};
  const bool leans = slope != upright;
  const int step = leans ? leaning_block_rows : support.size();
  kernels::Climb climb;
  climb.best_row = support.end - 1;
  for (int end = support.end; end > support.begin && !climb.over; end -= step) {
    const RowRange part{std::max(support.begin, end - step), end};
    const int farther = leans ? farther_[static_cast<std::size_t>(slope)].at(
                                    contact - (part.begin + end) / 2, candidate)
                              : 0;
    lines_.aim(references, count, candidate - farther, support);
    if (brightness_ > 0 && end == support.end)
      lines_.allowForBrightness(references, count, candidate - farther, brightnessRows(contact),
                                brightness_);
    kernels::climbSupport(lines_.paths(), count, terms, part.begin, part.end, support.begin, least,
                          climb);
  }
  if (climb.best < least) return 0.0F;
  top = static_cast<std::int16_t>(climb.best_row);
  return static_cast<float>(climb.best) / static_cast<float>(kernels::cost_unit * count);
}

void VerticalSweep::fetch(const SweepReference* references, int count, int candidate) const {
  if (brightness_ > 0)
    lines_.fetchBrightness(references, std::min(count, max_references), candidate,
                           brightnessRows(first_row_ + candidate));
}

float VerticalSweep::offered(const SweepReference* references, int count, int beam, int candidate) {
  count = std::min(count, max_references);
  bound(references, count, beam);
  return static_cast<float>(bound_[static_cast<std::size_t>(first_row_ + candidate)]) /
         static_cast<float>(kernels::cost_unit * count);
}

float VerticalSweep::leaningScore(const SweepReference* references, int count, int beam,
                                  int candidate, int slope, float least_score, std::int16_t& top) {
  count = std::min(count, max_references);
  const auto least =
      static_cast<std::int32_t>(least_score * static_cast<float>(kernels::cost_unit * count));
  if (bound_[static_cast<std::size_t>(first_row_ + candidate)] < least) return 0.0F;
  return scoreOf(references, count, beam, candidate, slope, least, top);
}

float VerticalSweep::levelScore(const SweepReference* references, int count, int beam,
                                int candidate, int begin, float least_score, std::int16_t& top) {
  count = std::min(count, max_references);
  const auto least =
      static_cast<std::int32_t>(least_score * static_cast<float>(kernels::cost_unit * count));
  const int farthest = begin - candidate;  // row of the first candidate
  const int highest = first_row_ + candidate - support_rows_;
  const RowRange support = intersection(rows(beam), {std::max(highest, farthest), begin});
  const kernels::EvidenceTerms terms{row_weight_.data(), potential_.data(), floor_cap_, prior_};
  kernels::Climb climb;
  climb.best_row = support.end;
  lines_.sameBrightness(count);
  for (int row = support.end - 1; row >= support.begin && !climb.over; --row) {
    lines_.aim(references, count, candidate - (begin - row), {row, row + 1});
    kernels::climbSupport(lines_.paths(), count, terms, row, row + 1, support.begin, least, climb);
  }
  top = static_cast<std::int16_t>(climb.best_row);
  return static_cast<float>(climb.best) / static_cast<float>(kernels::cost_unit * count);
}

float VerticalSweep::levelFront(const SweepReference* references, int count, int beam,
                                int candidate, int begin, int& front) {
  count = std::min(count, max_references);
  const int last = std::min(rows(beam).end, begin + candidates_ - candidate);
  const kernels::EvidenceTerms terms{row_weight_.data(), potential_.data(), floor_cap_, prior_};
  const std::int32_t patience = 8 * kernels::cost_unit * count;
  lines_.sameBrightness(count);
  std::int32_t sum = 0, best = 0;
  front = begin - 1;
  for (int row = begin; row < last && sum > best - patience; ++row) {
    kernels::Climb climb;
    lines_.aim(references, count, candidate + (row - begin), {row, row + 1});
    kernels::climbSupport(lines_.paths(), count, terms, row, row + 1, row, 0, climb);
    sum += climb.sum;
    if (sum > best) best = sum, front = row;
  }
  return static_cast<float>(best) / static_cast<float>(kernels::cost_unit * count);
}

/// Gains of the rows that one reference shows of the line it was aimed at; how many there are.
int VerticalSweep::gainsOf(const kernels::EvidencePath& path) {
  const int rows = std::max(0, path.end - path.begin);
  if (rows == 0) return 0;
  kernels::VerticalPath v = path.vertical;
  v.current += path.begin;
  v.weight += path.begin;
  v.upper += path.begin;
  v.lower += path.begin;
  kernels::verticalCost(v, rows, vertical_cost_.data());
  std::fill_n(gain_.begin(), rows + kernels::overrun, 0);
  kernels::accumulateEvidence(path.floor + path.begin, vertical_cost_.data(),
                              row_weight_.data() + path.begin, floor_cap_, prior_, rows,
                              gain_.data());
  return rows;
}

float VerticalSweep::evidence(const SweepReference* references, int count, int beam, int candidate,
                              RowRange part) {
  count = std::min(count, max_references);
  const RowRange support = intersection(rows(beam), part);
  lines_.aim(references, count, candidate, support);
  lines_.allowForBrightness(references, count, candidate, support, any_brightness);
  int compared = 0;
  std::int32_t sum = 0;
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q) {
    const int n = gainsOf(lines_.paths()[q]);
    for (int i = 0; i < n; ++i) sum += gain_[static_cast<std::size_t>(i)];
    compared += n;
  }
  if (compared == 0 || 2 * compared < part.size() * count)
    return std::numeric_limits<float>::lowest();
  return static_cast<float>(sum) / static_cast<float>(kernels::cost_unit * count);
}

void VerticalSweep::gains(const SweepReference* references, int count, int beam, int candidate,
                          int above, float* gain) {
  count = std::min(count, max_references);
  const int contact = first_row_ + candidate;
  const RowRange support = intersection(rows(beam), {contact - above + 1, contact + 1});
  const float unit = 1.0F / static_cast<float>(kernels::cost_unit * count);
  std::fill(gain, gain + above, 0.0F);
  lines_.aim(references, count, candidate, support);
  lines_.allowForBrightness(references, count, candidate, brightnessRows(contact), brightness_);
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q) {
    const kernels::EvidencePath& path = lines_.paths()[q];
    const int n = gainsOf(path);
    for (int i = 0; i < n; ++i)
      gain[contact - path.begin - i] +=
          unit * static_cast<float>(gain_[static_cast<std::size_t>(i)]);
  }
}

/// Scores of one beam, from the near end on. Maxima are wider than search_step: between two
/// evaluated candidates only the neighbourhood of a maximum is evaluated too, the rest lies on a
/// straight line. A candidate that cannot come near the best of those in front of it is not
/// followed.
void VerticalSweep::evaluateBeam(const SweepReference* references, int count, int beam,
                                 std::int32_t least, float* score, std::int16_t* top) {
  const float unit = rival_share_ * static_cast<float>(kernels::cost_unit * count);
  float best = 0.0F;
  const auto exact = [&](int c) {
    const std::int32_t needed = std::max(least, static_cast<std::int32_t>(unit * best));
    if (bound_[static_cast<std::size_t>(first_row_ + c)] < needed) return;
    score[c] = scoreOf(references, count, beam, c, upright, needed, top[c]);
    best = std::max(best, score[c]);
  };
  const int last = (candidates_ - 1) / search_step_ * search_step_;
  for (int c = last; c >= 0; c -= search_step_) {
    fetch(references, count, c - search_step_);
    exact(c);
  }
  best = 0.0F;
  for (int c = last; search_step_ > 1 && c > 0; c -= search_step_) {
    const int before = c - search_step_;
    const float ends = std::max(score[before], score[c]);
    best = std::max(best, score[c]);
    if (ends <= 0.0F) continue;
    const int from = std::max(0, before - peak_reach);
    const int to = std::min(candidates_, c + peak_reach + 1);
    const bool near_peak = ends >= peak_share * *std::max_element(score + from, score + to);
    for (int k = c - 1; k > before; --k) {
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
    if (bound(references, count, beam) < least) continue;
    aimBeam(current, references, count, beam);
    evaluateBeam(references, count, beam, least, score, top);
  }
}

}  // namespace ipm_mapping::sweep
