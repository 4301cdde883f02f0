#include "ipm_mapping/fpga/word_length.hpp"

#include <gtest/gtest.h>

#include "fpga/support.hpp"

namespace ipm_mapping::fpga {
namespace {

struct Scene {
  Image<std::uint8_t> reference, current;
  ExplorerInput input;
};

void makeScene(Scene& scene, int width, int height, unsigned seed) {
  test::Generator random(seed);
  test::paintFrame(scene.reference, width, height, random);
  test::paintFrame(scene.current, width, height, random);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const double f = 525.0 * width / 640.0;
  scene.input.view.camera =
      CameraModel({width, height, f, f + 0.7, 0.5 * (width - 1), 0.5 * (height - 1)},
                  {0.15, -0.3, 0.0, 0.0, 0.1});
  scene.input.view.T_base_camera = cameraPose(0.1, 0.0, 0.3, 0.2 + 0.3 * unit(random));
  scene.input.view.motion = {0.05 + 0.1 * unit(random), 0.0, 0.1 * (unit(random) - 0.5)};
  scene.input.reference = std::as_const(scene.reference).view();
  scene.input.current = std::as_const(scene.current).view();
  scene.input.threshold_in = 40;
}

template <class Pixel>
bool equal(const Image<Pixel>& a, const Image<Pixel>& b) {
  for (int v = 0; v < a.height(); ++v) {
    if (!std::equal(a.row(v), a.row(v) + a.width(), b.row(v))) return false;
  }
  return a.width() == b.width() && a.height() == b.height();
}

TEST(WordLength, TheContractsWidthsGiveTheContractsBits) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Scene scene;
    makeScene(scene, 160, 120, seed);
    const FpgaParameters parameters = seed % 2 ? FpgaParameters{} : FpgaParameters::paper();
    SoftwarePart software(parameters);
    ASSERT_FALSE(software.setCamera(scene.input.view.camera));
    const FrameSetup setup = software.setup(scene.input.view, scene.input.threshold_in);
    ASSERT_EQ(setup.status, SetupStatus::Ok);
    Wires twin, generic;
    runAllWires({scene.input.reference, scene.input.current, setup.parameters}, twin);
    WordLengthDatapath datapath(parameters, WordLengths());
    ASSERT_TRUE(datapath.run(scene.input, generic));
    EXPECT_TRUE(equal(twin.difference, generic.difference));
    EXPECT_TRUE(equal(twin.gaussian, generic.gaussian));
    EXPECT_TRUE(equal(twin.mask, generic.mask));
    EXPECT_TRUE(equal(twin.eroded, generic.eroded));
    EXPECT_EQ(twin.results.threshold_out, generic.results.threshold_out);
    EXPECT_TRUE(twin.results.cor == generic.results.cor);
    EXPECT_TRUE(twin.results.selected == generic.results.selected);
  }
}

TEST(WordLength, LongWordsReproduceTheExactGeometry) {
  Scene scene;
  makeScene(scene, 160, 120, 3);
  const FpgaParameters parameters;
  WordLengthDatapath datapath(parameters, WordLengths::ideal());
  Wires wires;
  ASSERT_TRUE(datapath.run(scene.input, wires));
  const Eigen::Matrix3d G = scene.input.view.G();
  double worst = 0.0;
  for (int v = 30; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector3d g = G * Eigen::Vector3d(u, v, 1);
      const SampledPoint& point = datapath.sampled()[static_cast<std::size_t>(v * 160 + u)];
      double x = 0, y = 0;
      if (!point.valid || !(g.z() > 0)) continue;
      if (!scene.input.view.camera.distortPixel(g.x() / g.z(), g.y() / g.z(), x, y)) continue;
      if (std::abs(x) > 400 || std::abs(y) > 400) continue;
      worst = std::max(worst, std::hypot(point.u - x, point.v - y));
    }
  }
  EXPECT_LT(worst, 0.01);
}

TEST(WordLength, FewerBitsCostPixels) {
  Scene scene;
  makeScene(scene, 160, 120, 5);
  const FpgaParameters parameters;
  for (const auto& [wire, few] :
       {std::pair{ExploredWire::HomographyLinear, 5}, std::pair{ExploredWire::Coordinate, 1},
        std::pair{ExploredWire::Intrinsic, 0}, std::pair{ExploredWire::Lens, 2},
        std::pair{ExploredWire::Normalized, 6}}) {
    const int contract = WordLengths()[wire];
    const auto low = sweepWordLength(scene.input, parameters, wire, few, few);
    const auto usual = sweepWordLength(scene.input, parameters, wire, contract, contract);
    ASSERT_EQ(low.size(), 1U);
    ASSERT_TRUE(low[0].usable && usual[0].usable);
    const auto name = explored_wire_names[static_cast<std::size_t>(wire)];
    EXPECT_GT(low[0].worst_error, usual[0].worst_error) << name;
    EXPECT_GT(low[0].changed_difference, usual[0].changed_difference) << name;
  }
}

TEST(WordLength, KeptGaussianBitsRaiseTheGreyLevelsThatShiftingLoses) {
  Scene scene;
  makeScene(scene, 96, 72, 8);
  const FpgaParameters parameters;
  Wires contract, kept;
  WordLengthDatapath(parameters, WordLengths()).run(scene.input, contract);
  WordLengthDatapath(parameters, WordLengths().with(ExploredWire::GaussianTerm, 4))
      .run(scene.input, kept);
  double lost = 0.0;
  int counted = 0;
  for (int v = 1; v < 71; ++v) {
    for (int u = 1; u < 95; ++u) {
      if (contract.gaussian.at(u, v) & no_correspondence) continue;
      ASSERT_GE(kept.gaussian.at(u, v), contract.gaussian.at(u, v));
      lost += kept.gaussian.at(u, v) - contract.gaussian.at(u, v);
      ++counted;
    }
  }
  EXPECT_NEAR(lost / counted, 3.5, 1.0);
}

TEST(WordLength, WiresAreFoundByName) {
  EXPECT_EQ(exploredWire("lens"), ExploredWire::Lens);
  EXPECT_EQ(exploredWire("nothing"), std::nullopt);
}

TEST(WordLength, CsvHasOneLineAWidth) {
  Scene scene;
  makeScene(scene, 64, 48, 9);
  const auto results = sweepWordLength(scene.input, FpgaParameters{}, ExploredWire::Lens, 9, 11);
  const std::string csv = wordLengthCsv(ExploredWire::Lens, results);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(csv.find("\nlens,10,1,"), std::string::npos);
}

}  // namespace
}  // namespace ipm_mapping::fpga
