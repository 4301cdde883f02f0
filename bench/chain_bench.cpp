// The source's chain, whole and stage by stage, on every instruction set of this machine, beside
// the same chain made of OpenCV's functions. One thread.

#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "ipm_mapping/detectors/inverse_perspective_mapping.hpp"
#include "ipm_mapping/detectors/localization.hpp"
#include "ipm_mapping/detectors/segmentation.hpp"
#include "ipm_mapping/parameters.hpp"
#include "support/ray_scene.hpp"

namespace ipm_mapping {
namespace {

/// Two VGA frames 15 cm apart of a floor with three boxes.
struct Pair {
  test::RayScene scene{CameraModel({640, 480, 430, 430, 319.5, 239.5}, {-0.2, 0.05, 0.001, 0, 0}),
                       cameraPose(0.05, 0.0, 0.45, 0.42)};
  SE2 T_odom_reference{0.0, 0.0, 0.0};
  SE2 T_odom_current{0.15, 0.005, 0.03};
  Image<std::uint8_t> reference, current;
  GroundView view;

  Pair() {
    scene.boxes = {{1.1, 1.4, 0.3, 0.6, 0.4}, {1.4, 1.7, -0.5, -0.2, 0.3}, {1.9, 2.2, 0, 0.3, 0.6}};
    reference = scene.render(T_odom_reference);
    current = scene.render(T_odom_current);
    view.camera = scene.camera;
    view.T_base_camera = scene.T_base_camera;
    view.T_odom_base = T_odom_current;
    view.motion = T_odom_reference.inverse() * T_odom_current;
  }
};
const Pair& pair() {
  static const Pair instance;
  return instance;
}
cv::Mat mat(const Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.row(0))};
}

cv::Mat openCv3x3(const Eigen::Matrix3d& m) {
  cv::Mat result(3, 3, CV_64F);
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) result.at<double>(r, c) = m(r, c);
  return result;
}

/// Bearings and the widths of §5.3, pixel by pixel: what a plain program does with the mask.
int plainScan(const PolarBeam& beam, const cv::Mat& mask) {
  int sum = 0;
  for (int i = 0; i < beam.lines(); ++i) {
    for (int v = 0; v < beam.height(); ++v) {
      const int u = beam.columns(i)[v];
      if (u < 0 || mask.at<std::uint8_t>(v, u) == 0) continue;
      ++sum;
      for (int k = std::max(u - 5, 0); k <= std::min(u + 5, mask.cols - 1); ++k)
        sum += mask.at<std::uint8_t>(v, k) != 0;
    }
  }
  return sum;
}

// ---- OpenCV -------------------------------------------------------------------------------------

class OpenCvChain {
 public:
  explicit OpenCvChain(bool tuned) : tuned_(tuned) {
    const Pair& p = pair();
    K_ = openCv3x3(p.view.camera.intrinsics().matrix());
    const Distortion& d = p.view.camera.distortion();
    D_ = (cv::Mat_<double>(1, 5) << d.k1, d.k2, d.p1, d.p2, d.k3);
    G_ = openCv3x3(p.view.G());
    cv::initUndistortRectifyMap(K_, D_, {}, K_, {640, 480}, CV_16SC2, map_, fraction_);
    cv::remap(cv::Mat(480, 640, CV_8U, cv::Scalar(255)), inside_, map_, fraction_,
              cv::INTER_NEAREST);
    beam_.aim(midFootFocus(vanishingPoints(p.view)), 640, 480, 80, Beam::FullView);
  }
  void warp() {
    const Pair& p = pair();
    if (tuned_) {
      cv::remap(mat(p.current), current_, map_, fraction_, cv::INTER_LINEAR);
      cv::remap(mat(p.reference), reference_, map_, fraction_, cv::INTER_LINEAR);
    } else {
      cv::undistort(mat(p.current), current_, K_, D_);
      cv::undistort(mat(p.reference), reference_, K_, D_);
    }
    cv::warpPerspective(reference_, warped_, G_, {640, 480},
                        cv::INTER_LINEAR | cv::WARP_INVERSE_MAP);
    cv::warpPerspective(inside_, valid_, G_, {640, 480}, cv::INTER_NEAREST | cv::WARP_INVERSE_MAP);
    cv::bitwise_and(valid_, inside_, valid_);
  }
  void difference() {
    cv::absdiff(warped_, current_, difference_);
    cv::bitwise_and(difference_, valid_, difference_);
  }
  void segment() {
    cv::GaussianBlur(difference_, blurred_, {3, 3}, 0);
    cv::threshold(blurred_, binary_, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
    cv::bitwise_and(binary_, valid_, binary_);
    cv::erode(binary_, mask_, cv::Mat());
  }
  int scan() { return plainScan(beam_, mask_); }

 private:
  bool tuned_;
  cv::Mat K_, D_, G_, map_, fraction_, inside_;
  cv::Mat current_, reference_, warped_, valid_, difference_, blurred_, binary_, mask_;
  PolarBeam beam_;
};

void openCv(benchmark::State& state, bool tuned) {
  OpenCvChain chain(tuned);
  for (auto _ : state) {
    chain.warp();
    chain.difference();
    chain.segment();
    benchmark::DoNotOptimize(chain.scan());
  }
}
void openCvStage(benchmark::State& state, void (*stage)(OpenCvChain&)) {
  OpenCvChain chain(true);
  chain.warp();
  chain.difference();
  chain.segment();
  for (auto _ : state) stage(chain);
}

// ---- ours ---------------------------------------------------------------------------------------

class Chain {
 public:
  Chain() : ipm_(Parameters{}.reference), difference_(640, 480), valid_(640, 480), mask_(640, 480) {
    const Pair& p = pair();
    ipm_.setCamera(p.view.camera, p.view.T_base_camera);
    ipm_.select({0, 0.0, p.reference.view(), p.T_odom_reference}, view_);
    ipm_.remember();
    status_ = ipm_.select({1, 0.1, p.current.view(), p.T_odom_current}, view_);
  }
  [[nodiscard]] bool ready() const { return status_ == FrameStatus::Used; }
  void difference() { ipm_.difference(difference_.view(), valid_.view()); }
  void segment() { segmentation_.process(difference_.view(), valid_.view(), mask_.view()); }
  void locate() { localization_.process(view_, mask_.view(), obstacles_); }

 private:
  InversePerspectiveMapping ipm_;
  Segmentation segmentation_;
  Localization localization_;
  Image<std::uint8_t> difference_, valid_, mask_;
  GroundView view_;
  Obstacles obstacles_;
  FrameStatus status_;
};

/// Everything after this runs on nothing better than `target`; 0: the best of the machine.
void useTarget(std::int64_t target) {
  hwy::SetSupportedTargetsForTest(0);
  if (target != 0) hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~(target - 1));
}

void ours(benchmark::State& state, std::int64_t target) {
  useTarget(target);
  Chain chain;
  if (!chain.ready()) state.SkipWithError("no reference");
  for (auto _ : state) {
    chain.difference();
    chain.segment();
    chain.locate();
  }
  useTarget(0);
}
void ourStage(benchmark::State& state, std::int64_t target, void (*stage)(Chain&)) {
  useTarget(target);
  Chain chain;
  chain.difference();
  chain.segment();
  chain.locate();
  for (auto _ : state) stage(chain);
  useTarget(0);
}

void registerAll() {
  const auto add = [](const std::string& name, auto function, auto... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), function, arguments...)
        ->Unit(benchmark::kMicrosecond);
  };
  add("whole/opencv_naive", openCv, false);
  add("whole/opencv_tuned", openCv, true);
  using Cv = OpenCvChain;
  add(
      "warp/opencv_tuned", openCvStage, +[](Cv& c) { c.warp(), c.difference(); });
  add(
      "segmentation/opencv_tuned", openCvStage, +[](Cv& c) { c.segment(); });
  add(
      "localization/opencv_tuned", openCvStage, +[](Cv& c) { benchmark::DoNotOptimize(c.scan()); });
  for (std::int64_t rest = hwy::SupportedTargets(); rest != 0; rest &= rest - 1) {
    const std::int64_t target = rest & -rest;
    const std::string name = hwy::TargetName(target);
    add("whole/" + name, ours, target);
    add(
        "warp/" + name, ourStage, target, +[](Chain& c) { c.difference(); });
    add(
        "segmentation/" + name, ourStage, target, +[](Chain& c) { c.segment(); });
    add(
        "localization/" + name, ourStage, target, +[](Chain& c) { c.locate(); });
  }
}

}  // namespace
}  // namespace ipm_mapping

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  ipm_mapping::registerAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
