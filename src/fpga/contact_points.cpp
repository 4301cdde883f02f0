#include "ipm_mapping/fpga/contact_points.hpp"

namespace ipm_mapping::fpga {
namespace {

constexpr Integer window_width = 2 * window_half_width + 1;

}  // namespace

ContactMachine::ContactMachine(int line, const FrameParameters& p)
    : line_(line),
      method_(static_cast<TriangleMethod>(p.method)),
      score_min_(p.score_min),
      min_height_(p.min_height) {
  reset();
}

void ContactMachine::row(bool pixel, int u, int v, int window_sum, OverflowCounters& counters) {
  if (!pixel) {
    finish();
    return;
  }
  const auto a = formats::WindowSum::fromRaw(window_sum);
  if (a.raw() <= smallest_.raw()) {
    narrow(u, v, a, counters);
  } else {
    widenOut(counters);
  }
}

/// a <= B: the triangle goes on.
void ContactMachine::narrow(int u, int v, formats::WindowSum a, OverflowCounters& counters) {
  const auto one = Unsigned<1>::fromRaw(1);
  smallest_ = a;
  surface_ = saturate<formats::ContactSurface>(surface_ + a, counters[Wire::ContactS]);
  height_ = saturate<formats::ContactHeight>(height_ + one, counters[Wire::ContactH]);
  score_ = saturate<formats::ContactScore>(score_ + one, counters[Wire::ContactScore]);
  u_ = u;
  v_ = v;
}

/// a > B: the shape widens again.
void ContactMachine::widenOut(OverflowCounters& counters) {
  smallest_ = formats::WindowSum::fromRaw(window_width);
  if (method_ == TriangleMethod::Triangle) {
    score_ = saturate<formats::ContactScore>(score_ - Unsigned<1>::fromRaw(1),
                                             counters[Wire::ContactScore]);
  } else {
    score_ = {};
    surface_ = {};
    height_ = {};
  }
}

void ContactMachine::finish() {
  const bool wide = surface_.raw() > 4 * height_.raw();
  if (score_.raw() > score_min_ && wide && height_.raw() >= min_height_) {
    contact_ = {true, contactWord(line_, u_, v_)};
  }
  reset();
}

void ContactMachine::reset() {
  smallest_ = formats::WindowSum::fromRaw(window_width);
  score_ = {};
  surface_ = {};
  height_ = {};
}

int windowSum(ImageView<const std::uint8_t> eroded, int u, int v) {
  int sum = 0;
  for (int k = -window_half_width; k <= window_half_width; ++k) sum += obstacleAt(eroded, u + k, v);
  return sum;
}

void localize(ImageView<const std::uint8_t> eroded, const FrameParameters& p, PolarHistogram& bear,
              Contacts& cor, OverflowCounters& counters) {
  const FocusWord focus{static_cast<int>(p.focus_u), static_cast<int>(p.focus_v)};
  const int rows = beamRows(focus, eroded.height);
  for (int line = 0; line < line_count; ++line) {
    BeamLine beam(line, focus, counters);
    BearingCounter count;
    ContactMachine machine(line, p);
    for (int v = 0; v < rows; ++v) {
      const int u = beam.column();
      const bool pixel = obstacleAt(eroded, u, v);
      count.add(pixel, counters);
      machine.row(pixel, u, v, windowSum(eroded, u, v), counters);
      beam.step(counters);
    }
    machine.finish();
    bear[static_cast<std::size_t>(line)] = count.value();
    cor[static_cast<std::size_t>(line)] = machine.contact();
  }
}

}  // namespace ipm_mapping::fpga
