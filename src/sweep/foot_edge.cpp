#include "ipm_mapping/sweep/foot_edge.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/sweep/contact_edge.hpp"

namespace ipm_mapping::sweep {

namespace {

/// Where a parabola through three neighbours is highest, from the middle one; 0 where that is not
/// the highest of them.
float vertex(float before, float middle, float after) {
  const float bend = before - 2.0F * middle + after;
  if (!(bend < -1e-3F && middle >= before && middle >= after)) return 0.0F;
  return 0.5F * (before - after) / bend;
}

}  // namespace

void FootEdge::configure(const VerticalSweep& sweep, const FreeFloorParameters& free_floor,
                         const FootParameters& parameters) {
  free_floor_ = free_floor;
  parameters_ = parameters;
  plain_edge_.configure(sweep, free_floor, parameters);
}

float FootEdge::contrastAt(const ComparedFrame& frame, int beam, const BeamChoice& choice) {
  const RowRange seen = frame.sweep.rows(beam);
  const int centre = static_cast<int>(std::lround(frame.sweep.sweepRow(choice.candidate)));
  float strongest = 0.0F;
  for (int row = centre - 1; row <= centre + 1; ++row) {
    if (row <= seen.begin || row + 1 >= seen.end) continue;
    const float g = edgeContrast(frame.current, frame.sweep.firstLine(beam), row);
    if (std::abs(g) > std::abs(strongest)) strongest = g;
  }
  return strongest;
}

float FootEdge::sharpest(const ComparedFrame& frame, int beam, int candidate) {
  const int row = static_cast<int>(frame.sweep.sweepRow(candidate));
  const auto at = [&](int j) {
    return std::abs(edgeContrast(frame.current, frame.sweep.firstLine(beam), j));
  };
  return static_cast<float>(candidate) + vertex(at(row - 1), at(row), at(row + 1));
}

bool FootEdge::floorInFront(const ComparedFrame& frame, int beam, int row) const {
  const int end = frame.sweep.rows(beam).end;
  for (int from = row + PlainEdge::edge_rows; from < end; from += free_floor_.free_window) {
    int sum = 0, number = 0;
    for (int q = 0; q < frame.count; ++q) {
      const std::uint16_t* cost = frame.references[q].floor_cost.row(beam);
      for (int j = from; j < std::min(end, from + free_floor_.free_window); ++j) {
        if (cost[j] == kernels::no_cost) continue;
        sum += cost[j];
        ++number;
      }
    }
    if (sum > parameters_.foot_floor_cost * kernels::cost_unit * number) return false;
  }
  return true;
}

/// Floor in front, and behind the edge nothing that only floor explains.
bool FootEdge::mayStand(const ComparedFrame& frame, int beam, int candidate) const {
  const int row = static_cast<int>(frame.sweep.sweepRow(candidate));
  if (!floorInFront(frame, beam, row)) return false;
  frame.sweep.aimBeam(frame.current, frame.references, frame.count, beam);
  return plain_edge_.mayStand(frame.references, frame.count, frame.sweep, beam, candidate);
}

BeamChoice FootEdge::find(const ComparedFrame& frame, const KnownFoot& known, int beam,
                          double expected) const {
  BeamChoice foot;
  const int first_row = static_cast<int>(frame.sweep.sweepRow(0.0));
  const RowRange seen = frame.sweep.rows(beam);
  const int centre = static_cast<int>(std::lround(expected));
  const int from = centre - parameters_.foot_window, to = centre + parameters_.foot_window;
  if (from < 0 || to >= frame.sweep.candidates() || first_row + from - 2 < seen.begin ||
      first_row + to + 2 >= seen.end)
    return foot;
  const auto along = [&](int candidate) {
    return edgeContrast(frame.current, frame.sweep.firstLine(beam), first_row + candidate) /
           known.contrast;
  };
  int best = from;
  float most = along(from);
  for (int c = from + 1; c <= to; ++c) {
    const float share = along(c);
    if (share > most) most = share, best = c;
  }
  const auto least = static_cast<float>(parameters_.foot_share);
  if (most < least || most * least > 1.0F || !mayStand(frame, beam, best)) return foot;
  foot.candidate = static_cast<float>(best) + vertex(along(best - 1), most, along(best + 1));
  foot.score = static_cast<float>(parameters_.foot_score) * known.score;
  foot.by_edge = true;
  foot.top = first_row + best - known.support;
  return foot;
}

}  // namespace ipm_mapping::sweep
