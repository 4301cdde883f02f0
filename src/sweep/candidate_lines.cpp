#include "ipm_mapping/sweep/candidate_lines.hpp"

#include <algorithm>

namespace ipm_mapping::sweep {

void CandidateLines::configure(const PolarGrid& grid, const std::vector<RowRange>& reference_rows,
                               const std::vector<float>& inverse_distance) {
  grid_ = grid;
  candidates_ = static_cast<int>(inverse_distance.size());
  reference_rows_ = commonRows(reference_rows, kernels::beam_lines + 1);
  inverse_distance_ = inverse_distance;
  inverse_distance_.resize(inverse_distance_.size() + kernels::overrun, 1.0F);
  line_position_.resize(inverse_distance_.size());
  row_position_.resize(inverse_distance_.size());
  for (Places& places : places_)
    for (auto* array : {&places.line, &places.shift, &places.line_fraction, &places.row_fraction})
      array->resize(inverse_distance_.size());
}

std::size_t CandidateLines::within(int candidate) const {
  return static_cast<std::size_t>(std::clamp(candidate, 0, candidates_ - 1));
}

void CandidateLines::place(const FootMotion& motion, double azimuth, Places& places) {
  const kernels::FloorRay ray = floorRay(grid_, motion, azimuth, half_beam);
  kernels::rayPositions(ray, inverse_distance_.data(), candidates_, line_position_.data(),
                        row_position_.data());
  kernels::splitPositions(line_position_.data(), candidates_, places.line.data(),
                          places.line_fraction.data());
  kernels::splitPositions(row_position_.data(), candidates_, places.shift.data(),
                          places.row_fraction.data());
}

void CandidateLines::aimBeam(const CurrentView& current, const SweepReference* references,
                             int count, int beam, int first_line) {
  const double azimuth = grid_.azimuth(first_line + half_beam);
  for (std::size_t q = 0; q < static_cast<std::size_t>(std::min(count, max_references)); ++q) {
    place(references[q].motion, azimuth, places_[q]);
    paths_[q].floor = references[q].floor_cost.row(beam);
    kernels::VerticalPath& vertical = paths_[q].vertical;
    vertical.stride = grid_.sweepRows();
    vertical.current = current.grey.row(first_line);
    vertical.weight = current.weight.row(first_line);
    vertical.brighter = 0;
  }
  sums_ = current.sums.empty() ? nullptr : current.sums.row(beam);
}

/// A candidate's vertical line in one reference, on the rows of its support that are seen there.
void CandidateLines::aim(const SweepReference& reference, const Places& places,
                         std::size_t candidate, RowRange support, kernels::EvidencePath& path) {
  const std::int32_t line = places.line[candidate], shift = places.shift[candidate];
  path.begin = path.end = 0;
  if (line < 0 || line >= static_cast<int>(reference_rows_.size())) return;
  const RowRange seen = reference.seen(static_cast<std::size_t>(line), reference_rows_);
  // fine row 2 j + shift and the one after it have to be in view
  path.begin = std::max(support.begin, (seen.begin - shift + 1) >> 1);
  path.end = std::min(support.end, (seen.end - shift) >> 1);
  const int half = shift >> 1;
  const bool odd = (shift & 1) != 0;
  kernels::VerticalPath& vertical = path.vertical;
  vertical.upper = (odd ? reference.odd : reference.even).row(line) + half;
  vertical.lower = (odd ? reference.even : reference.odd).row(line) + half + (odd ? 1 : 0);
  vertical.row_fraction = static_cast<std::int16_t>(places.row_fraction[candidate]);
  vertical.line_fraction = static_cast<std::int16_t>(places.line_fraction[candidate]);
}

/// A candidate's line in every reference.
void CandidateLines::aim(const SweepReference* references, int count, int candidate,
                         RowRange support) {
  const std::size_t c = within(candidate);
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q)
    aim(references[q], places_[q], c, support, paths_[q]);
}

void CandidateLines::allowForBrightness(const SweepReference* references, int count, int candidate,
                                        RowRange patch, std::int32_t most) {
  const std::size_t c = within(candidate);
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q) {
    kernels::EvidencePath& path = paths_[q];
    path.vertical.brighter = 0;
    const RowRange rows = intersection(patch, {path.begin, path.end - 1});
    if (sums_ == nullptr || references[q].sums.empty() || rows.size() < least_patch) continue;
    const Places& places = places_[q];
    const std::int32_t shift = places.shift[c];
    const BeamPatch before{rows.begin,
                           rows.end,
                           places.line[c],
                           places.line_fraction[c],
                           shift >> 1,  // an even row is two fine ones
                           ((shift & 1) * (1 << 15) + places.row_fraction[c]) / 2};
    const float brighter = (static_cast<float>(sums_[rows.end] - sums_[rows.begin]) -
                            sumOf(references[q].sums, before)) /
                           static_cast<float>(kernels::beam_lines * rows.size());
    path.vertical.brighter =
        static_cast<std::int16_t>(std::clamp(static_cast<std::int32_t>(brighter), -most, most));
  }
}

void CandidateLines::fetchBrightness(const SweepReference* references, int count, int candidate,
                                     RowRange patch) const {
  const std::size_t c = within(candidate);
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q) {
    const ImageView<const std::int32_t>& sums = references[q].sums;
    const std::int32_t line = places_[q].line[c], row = places_[q].shift[c] >> 1;
    if (line < 0 || line + 1 >= sums.height) continue;
    for (const std::int32_t* sum : {sums.row(line), sums.row(line + 1)})
      for (const int end : {patch.begin + row, patch.end + row})
        if (end >= 0 && end < sums.width) __builtin_prefetch(sum + end);
  }
}

void CandidateLines::sameBrightness(int count) {
  for (std::size_t q = 0; q < static_cast<std::size_t>(count); ++q) paths_[q].vertical.brighter = 0;
}

}  // namespace ipm_mapping::sweep
