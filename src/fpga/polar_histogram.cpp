#include "ipm_mapping/fpga/polar_histogram.hpp"

#include <algorithm>
#include <cstdlib>

namespace ipm_mapping::fpga {
namespace {

int directionTo(FocusWord focus, int u0) {
  const int sign = (focus.u > u0) - (focus.u < u0);
  return focus.v < 0 ? -sign : sign;
}

}  // namespace

int beamRows(FocusWord focus, int height) {
  return focus.v > 0 ? std::min(height, focus.v + 1) : height;
}

BeamLine::BeamLine(int line, FocusWord focus, OverflowCounters& counters)
    : du_(formats::BeamDelta::fromRaw(std::abs(focus.u - startColumn(line)))),
      dv_(formats::BeamDelta::fromRaw(std::abs(focus.v))),
      direction_(directionTo(focus, startColumn(line))),
      u_(startColumn(line)) {
  error_ = saturate<formats::BeamError>(du_ + du_ - dv_, counters[Wire::BeamD]);
  if (du_.raw() > dv_.raw()) ++counters[Wire::BeamSlope];
}

void BeamLine::step(OverflowCounters& counters) {
  const auto rise = error_ + (du_ + du_);
  if (error_.raw() > 0) {
    u_ += direction_;
    error_ = saturate<formats::BeamError>(rise - (dv_ + dv_), counters[Wire::BeamD]);
  } else {
    error_ = saturate<formats::BeamError>(rise, counters[Wire::BeamD]);
  }
}

void BearingCounter::add(bool pixel, OverflowCounters& counters) {
  if (!pixel) return;
  count_ = saturate<formats::BearingCount>(count_ + Unsigned<1>::fromRaw(1), counters[Wire::Bear]);
}

}  // namespace ipm_mapping::fpga
