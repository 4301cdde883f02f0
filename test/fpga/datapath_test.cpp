#include "ipm_mapping/fpga/datapath.hpp"

#include <gtest/gtest.h>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/fast_kernels.hpp"

namespace ipm_mapping::fpga {
namespace {

/// First difference between two sets of wires as text; empty when they agree bit for bit.
template <class Pixel>
std::string firstDifference(const char* wire, const Image<Pixel>& a, const Image<Pixel>& b) {
  for (int v = 0; v < a.height(); ++v) {
    for (int u = 0; u < a.width(); ++u) {
      if (a.at(u, v) == b.at(u, v)) continue;
      return std::string(wire) + " at " + std::to_string(u) + ", " + std::to_string(v) + ": " +
             std::to_string(a.at(u, v)) + " and " + std::to_string(b.at(u, v));
    }
  }
  return {};
}

std::string firstDifference(const Wires& a, const Wires& b) {
  for (const std::string& found :
       {firstDifference("difference", a.difference, b.difference),
        firstDifference("gaussian", a.gaussian, b.gaussian),
        firstDifference("mask", a.mask, b.mask), firstDifference("eroded", a.eroded, b.eroded)}) {
    if (!found.empty()) return found;
  }
  for (std::size_t i = 0; i < wire_count; ++i) {
    if (a.results.overflow.counts()[i] != b.results.overflow.counts()[i]) {
      return std::string("overflow ") + wire_names[i] + ": " +
             std::to_string(a.results.overflow.counts()[i]) + " and " +
             std::to_string(b.results.overflow.counts()[i]);
    }
  }
  if (a.results.histogram != b.results.histogram) return "histogram";
  if (a.results.bear != b.results.bear) return "bear";
  if (!(a.results.cor == b.results.cor)) return "cor";
  return a.results == b.results ? "" : "threshold, peaks or selected";
}

class EveryKernelSet : public testing::TestWithParam<const FastKernels*> {};

TEST_P(EveryKernelSet, GivesTheBitsOfTheStagedTwins) {
  test::Generator random(20160000);
  Datapath fast(Engine::Fast, *GetParam());
  Wires expected, actual;
  for (int round = 0; round < 160; ++round) {
    const bool vga = round % 40 == 0;
    const int width = vga ? 640 : static_cast<int>(test::between(random, 1, 150));
    const int height = vga ? 480 : static_cast<int>(test::between(random, 1, 120));
    const OwnedInputs owned = test::randomInputs(width, height, random);
    runAllWires(owned.inputs(), expected);
    ASSERT_TRUE(fast.run(owned.inputs(), actual.prepare(width, height)));
    actual.results = fast.results();
    ASSERT_EQ(firstDifference(expected, actual), "") << "round " << round << '\n'
                                                     << formatParameters(owned.parameters);
  }
}

TEST_P(EveryKernelSet, DoesNotNeedTheWiresThatNobodyAskedFor) {
  test::Generator random(7);
  const OwnedInputs owned = test::randomInputs(160, 120, random);
  Wires all;
  runAllWires(owned.inputs(), all);
  Datapath fast(Engine::Fast, *GetParam());
  ASSERT_TRUE(fast.run(owned.inputs()));
  EXPECT_TRUE(fast.results() == all.results);
}

INSTANTIATE_TEST_SUITE_P(Fast, EveryKernelSet, testing::ValuesIn(supportedKernels()),
                         [](const auto& info) { return std::string(info.param->name); });

}  // namespace
}  // namespace ipm_mapping::fpga
