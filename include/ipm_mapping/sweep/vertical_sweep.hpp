#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/kernels/sweep_costs.hpp"
#include "ipm_mapping/sweep/candidate_lines.hpp"
#include "ipm_mapping/sweep/floor_cost.hpp"
#include "ipm_mapping/sweep/polar_grid.hpp"
#include "ipm_mapping/sweep/score_grid.hpp"

namespace ipm_mapping::sweep {

/// Scores of every candidate contact of every beam.
struct SweepScores {
  Image<float> score;       ///< candidates x beams
  Image<std::int16_t> top;  ///< sweep row where the support ends
};

/// Does this column look like something vertical that stands on the floor at this distance? For a
/// candidate contact at distance d the line maps to one line of the reference, its rows shifted by
/// rows_per_log ln(d / d'). With F and V the costs of floor and vertical per row,
///   S(b) = max over top of sum_{top..b} w(row) mean over references of (min(F, U) - V_b - prior),
/// w(row) = evidence_rows dr: evidence counts per unit of r, as the image does, not per row of the
/// grid. V allows for a small change of the whole surface's brightness: light falls on it from
/// elsewhere, lenses darken towards their corners. Candidates reach below the image: what they
/// absorb stands nearer than the view.
class VerticalSweep {
 public:
  static constexpr int max_references = CandidateLines::max_references;
  /// Of surfaces that lean away from the camera, metres away per metre of height.
  static constexpr std::array<double, 3> lean_slopes{0.2, 0.35, 0.6};

  void configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                 const std::vector<RowRange>& current_rows, double max_support,
                 const EvidenceParameters& parameters);

  /// Scores below `least_score` may be given as 0.
  void evaluate(const CurrentView& current, const SweepReference* references, int count,
                float least_score, SweepScores& scores);

  /// Most that any surface standing at a candidate could score: all that the floor's cost offers.
  float offered(const SweepReference* references, int count, int beam, int candidate);
  /// Prepares leaningScore() and evidence() for the candidates of one beam.
  void aimBeam(const CurrentView& current, const SweepReference* references, int count, int beam);
  /// Brings what the score of a candidate of the aimed beam is made of near: the sums that its
  /// brightness is taken from do not fit a core's own memory.
  void fetch(const SweepReference* references, int count, int candidate) const;
  /// Score of a surface that stands on the floor at a candidate of the aimed beam, of which
  /// offered() was asked last, and leans away by lean_slopes[slope]; less than `least_score` may be
  /// given as 0.
  float leaningScore(const SweepReference* references, int count, int beam, int candidate,
                     int slope, float least_score, std::int16_t& top);

  /// Score of a level surface as high as sweep row `begin` of the upright line at a candidate of
  /// the aimed beam, of which offered() was asked last, seen from the row above `begin` on: with z
  /// = h (1 - r(begin) / r(candidate)) it is met on row j at (h - z) / r(j), one candidate farther
  /// a row. `top` is the row where it ends. One that cannot reach `least_score` may be given as any
  /// lower score.
  float levelScore(const SweepReference* references, int count, int beam, int candidate, int begin,
                   float least_score, std::int16_t& top);

  /// The same surface followed from row `begin` towards the robot; `front` is the last of its rows,
  /// `begin` - 1 where it has none.
  float levelFront(const SweepReference* references, int count, int beam, int candidate, int begin,
                   int& front);

  /// Evidence for an upright surface of any brightness at a candidate of the aimed beam, summed
  /// over a part of the sweep rows whatever its sign: negative where the floor's own texture goes
  /// on there. The lowest number where less than half of the rows can be compared.
  float evidence(const SweepReference* references, int count, int beam, int candidate,
                 RowRange part);

  /// What single rows of an upright surface at a candidate of the aimed beam gain, the contact's
  /// first and `above` of them; 0 where they cannot be compared.
  void gains(const SweepReference* references, int count, int beam, int candidate, int above,
             float* gain);

  [[nodiscard]] int beams() const { return beams_; }
  [[nodiscard]] int candidates() const { return candidates_; }
  [[nodiscard]] int firstLine(int beam) const { return beam * beam_step_; }
  /// Azimuth of the middle of a beam.
  [[nodiscard]] double azimuth(int beam) const;
  /// Sweep row of a candidate; fractions allowed.
  [[nodiscard]] double sweepRow(double candidate) const { return first_row_ + candidate; }
  [[nodiscard]] double r(double candidate) const;
  [[nodiscard]] double distance(double candidate) const { return grid_.height / r(candidate); }
  [[nodiscard]] ScoreGrid scoreGrid() const;
  /// Sweep rows that all lines of a beam see.
  [[nodiscard]] RowRange rows(int beam) const { return beam_rows_[static_cast<std::size_t>(beam)]; }

 private:
  std::int32_t bound(const SweepReference* references, int count, int beam);
  [[nodiscard]] double candidateR(int candidate) const {
    return row_r_[static_cast<std::size_t>(first_row_ + candidate)];
  }
  [[nodiscard]] int fartherBy(int candidate, double lean, int row) const;
  void tabulateLeaning();
  [[nodiscard]] RowRange brightnessRows(int contact) const {
    return {contact - brightness_rows_, contact};
  }
  int gainsOf(const kernels::EvidencePath& path);
  float scoreOf(const SweepReference* references, int count, int beam, int candidate, int slope,
                std::int32_t least, std::int16_t& top);
  void evaluateBeam(const SweepReference* references, int count, int beam, std::int32_t least,
                    float* score, std::int16_t* top);

  PolarGrid grid_;
  int beam_step_ = 1, search_step_ = 1, beams_ = 0, candidates_ = 0, first_row_ = 0,
      support_rows_ = 0;
  float rival_share_ = 0.0F;
  std::int32_t floor_cap_ = 0, prior_ = 0;
  std::int32_t brightness_ = 0;                // most that a surface's may change, 1/32 grey levels
  int brightness_rows_ = 0;                    // above the contact, that tell it
  std::vector<RowRange> beam_rows_;            // current: sweep rows, eight lines
  std::vector<std::int32_t> row_weight_;       // w(row) in 1/256
  std::vector<double> row_r_;                  // of every sweep row, also below the view
  std::vector<std::int32_t> bound_;            // most that a support ending at a row can gain
  std::vector<std::int32_t> potential_;        // sum of what the rows before a row could gain
  std::vector<std::int32_t> gain_;             // most that each row can gain
  std::vector<std::uint16_t> least_vertical_;  // cost of a row
  std::vector<std::uint16_t> vertical_cost_;
  /// fartherBy() of every slope: rows above the contact x candidates.
  std::array<Image<std::int16_t>, lean_slopes.size()> farther_;
  CandidateLines lines_;
};

}  // namespace ipm_mapping::sweep
