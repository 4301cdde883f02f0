// Times the FPGA model's datapath against OpenCV's nearest-neighbour chain doing the same work,
// in one run on one thread: ratios count, absolute times drift on shared machines.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "ipm_mapping/fpga/datapath.hpp"
#include "ipm_mapping/fpga/fast_kernels.hpp"

namespace {

using namespace ipm_mapping::fpga;  // NOLINT(google-build-using-namespace)
using ipm_mapping::GrayView;

constexpr int width = 640, height = 480;
constexpr int rounds = 200;

/// A camera of 525 px focal length 0.3 m over the floor, pitched down 20 degrees, 10 cm of motion.
struct Scene {
  cv::Mat1b reference, current;
  cv::Matx33d K{525, 0, 319.5, 0, 525, 239.5, 0, 0, 1};
  std::vector<double> D{0.12, -0.25, 0, 0, 0};
  cv::Matx33d G;
  FrameParameters parameters;
};

void setGeometry(Scene& s) {
  const double pitch = 20.0 * CV_PI / 180.0, camera_height = 0.3, motion = 0.1;
  const double c = std::cos(pitch), n = std::sin(pitch);
  const cv::Matx33d pose(0, -1, 0, -n, 0, c * camera_height, c, 0, n * camera_height);
  const cv::Matx33d H = s.K * pose;
  const cv::Matx33d M(1, 0, motion, 0, 1, 0, 0, 0, 1);
  s.G = H * M * H.inv();
  const double scale = std::min(60.0 / std::abs(s.G(0, 0)), 1000.0 / std::abs(s.G(1, 2)));
  const auto linear = [&](int r, int k) { return std::llround(s.G(r, k) * scale * 2048); };
  const auto offset = [&](int r) { return std::llround(s.G(r, 2) * scale * 128); };
  FrameParameters& p = s.parameters;
  p.width = width;
  p.height = height;
  p.h11 = linear(0, 0), p.h12 = linear(0, 1), p.h13 = offset(0);
  p.h21 = linear(1, 0), p.h22 = linear(1, 1), p.h23 = offset(1);
  p.h31 = linear(2, 0), p.h32 = linear(2, 1), p.h33 = offset(2);
  const cv::Matx33d to_floor = (H * M.inv()).inv();
  const double horizon = 60.0 / std::abs(to_floor(2, 1));
  p.horizon_b = std::llround(to_floor(2, 1) * horizon * 2048);
  p.horizon_c = std::llround(to_floor(2, 2) * horizon * 128);
  p.fx = p.fy = 525 * 64, p.cx = 20448, p.cy = 15328;
  p.k1 = std::llround(0.12 * 2048), p.k2 = std::llround(-0.25 * 2048);
  p.r2_max = 68000;
  p.focus_u = 320, p.focus_v = 1682;
  p.threshold_in = 24, p.min_threshold = 6, p.score_min = 4, p.min_height = 5;
  p.bearing_tolerance = 1, p.memory_rows = 819;
}

/// A tiled, noisy floor with upright bars that moved between the frames.
cv::Mat1b paint(int shift, int seed) {
  cv::Mat1b image(height, width);
  cv::RNG random(static_cast<std::uint64_t>(seed));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) image(v, u) = ((u / 40 + v / 30) % 2) ? 120 : 90;
  }
  cv::Mat1b noise(height, width);
  random.fill(noise, cv::RNG::UNIFORM, 0, 12);
  image += noise;
  for (int bar = 0; bar < 5; ++bar) {
    const cv::Rect box(60 + 120 * bar + shift * (bar - 2), 60, 30, 200 + 40 * (bar % 3));
    cv::rectangle(image, box, 20 + 50 * bar, cv::FILLED);
  }
  return image;
}

/// OpenCV's chain with everything fixed worked out beforehand: the peer.
class OpenCvChain {
 public:
  explicit OpenCvChain(const Scene& s) : scene_(s) {
    cv::initUndistortRectifyMap(s.K, s.D, cv::noArray(), s.K, {width, height}, CV_16SC2, map_,
                                weights_);
    map_nearest_ = map_.clone();
    full_ = cv::Mat1b(height, width, 255);
    cv::remap(s.reference, reference_, map_nearest_, cv::noArray(), cv::INTER_NEAREST);
    cv::remap(full_, full_undistorted_, map_nearest_, cv::noArray(), cv::INTER_NEAREST);
  }

  /// The reference was undistorted when it was the current frame: that is not done again.
  int run() {
    constexpr int flags = cv::INTER_NEAREST | cv::WARP_INVERSE_MAP;
    cv::remap(scene_.current, current_, map_nearest_, cv::noArray(), cv::INTER_NEAREST);
    cv::warpPerspective(reference_, warped_, scene_.G, {width, height}, flags);
    cv::warpPerspective(full_undistorted_, valid_, scene_.G, {width, height}, flags);
    cv::absdiff(current_, warped_, difference_);
    cv::bitwise_and(difference_, valid_, difference_);
    cv::GaussianBlur(difference_, blurred_, {3, 3}, 0.8);
    cv::threshold(blurred_, mask_, 0, 1, cv::THRESH_BINARY | cv::THRESH_OTSU);
    cv::erode(mask_, eroded_, cv::Mat());
    return scan();
  }

 private:
  /// The 80 lines with their window sums, straightforwardly.
  int scan() {
    int total = 0;
    for (int line = 0; line < 80; ++line) {
      const double u0 = 8 * line + 4, slope = (320 - u0) / 1682.0;
      int count = 0, smallest = 11, surface = 0, length = 0;
      for (int v = 0; v < height; ++v) {
        const int u = static_cast<int>(u0 + slope * v + 0.5);
        const std::uint8_t* row = eroded_[v];
        if (u < 5 || u >= width - 5 || !row[u]) {
          total += surface > 4 * length && length >= 5;
          smallest = 11, surface = 0, length = 0;
          continue;
        }
        int a = 0;
        for (int k = -5; k <= 5; ++k) a += row[u + k];
        ++count;
        if (a <= smallest) smallest = a, surface += a, ++length;
        else smallest = 11;
      }
      total += count;
    }
    return total;
  }

  const Scene& scene_;
  cv::Mat map_, weights_, map_nearest_;
  cv::Mat1b full_, full_undistorted_, reference_, current_, warped_, valid_, difference_, blurred_;
  cv::Mat1b mask_, eroded_;
};

double medianMs(std::vector<double> samples) {
  std::nth_element(samples.begin(), samples.begin() + samples.size() / 2, samples.end());
  return samples[samples.size() / 2];
}

/// CPU time of this thread: what other processes take is not counted.
double cpuMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double timeOnce(const std::function<void()>& work) {
  const double start = cpuMs();
  work();
  return cpuMs() - start;
}

struct Contestant {
  std::string name;
  std::function<void()> work;
  std::vector<double> samples;
};

}  // namespace

int main() {
  cv::setNumThreads(1);
  Scene scene;
  scene.reference = paint(-4, 1);
  scene.current = paint(4, 2);
  setGeometry(scene);
  const FrameInputs inputs{GrayView(scene.reference.data, width, height),
                           GrayView(scene.current.data, width, height), scene.parameters};
  OpenCvChain peer(scene);
  volatile int sink = 0;
  std::vector<Contestant> contestants{{"opencv_nearest", [&] { sink = peer.run(); }, {}}};
  std::vector<Datapath> datapaths;
  for (const FastKernels* kernels : supportedKernels()) {
    datapaths.emplace_back(Engine::Fast, *kernels);
  }
  for (std::size_t i = 0; i < datapaths.size(); ++i) {
    contestants.push_back({std::string("fpga_") + supportedKernels()[i]->name,
                           [&, i] { datapaths[i].run(inputs); }, {}});
  }
  for (int round = 0; round < rounds; ++round) {
    for (Contestant& c : contestants) c.samples.push_back(timeOnce(c.work));
  }
  const double peer_ms = medianMs(contestants.front().samples);
  std::printf("%-16s %10s %8s\n", "chain", "median ms", "ratio");
  for (const Contestant& c : contestants) {
    const double ms = medianMs(c.samples);
    std::printf("%-16s %10.3f %8.2f\n", c.name.c_str(), ms, peer_ms / ms);
  }
  return sink < 0;
}
