#pragma once
// Pictures for the tests of the stages: random ones, ones with guarded surroundings, comparisons.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::test {

/// W x H pixels inside a larger buffer: a stage that ignores the stride or writes outside its view
/// is found out.
class Picture {
 public:
  Picture(int width, int height, std::uint8_t value = 0)
      : width_(width), height_(height), pixels_(bufferSize(width, height), guard) {
    for (int v = 0; v < height; ++v) std::fill_n(view().row(v), width, value);
  }
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] GrayBuffer view() { return {pixels_.data() + offset(), width_, height_, stride()}; }
  [[nodiscard]] GrayView view() const {
    return {pixels_.data() + offset(), width_, height_, stride()};
  }
  std::uint8_t& operator()(int u, int v) { return view().at(u, v); }
  std::uint8_t operator()(int u, int v) const { return view().at(u, v); }
  [[nodiscard]] cv::Mat mat() {
    return {height_, width_, CV_8U, view().data, static_cast<std::size_t>(stride())};
  }
  /// True when nothing outside the view was written.
  [[nodiscard]] bool guarded() const {
    const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(pixels_.size());
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const std::ptrdiff_t u = i % stride() - margin, v = i / stride() - margin_rows;
      const bool inside = u >= 0 && v >= 0 && u < width_ && v < height_;
      if (!inside && pixels_[static_cast<std::size_t>(i)] != guard) return false;
    }
    return true;
  }

 private:
  static constexpr std::uint8_t guard = 0xA5;
  static constexpr int margin = 7, margin_rows = 2;
  static std::size_t bufferSize(int width, int height) {
    return static_cast<std::size_t>(width + 2 * margin) *
           static_cast<std::size_t>(height + 2 * margin_rows);
  }
  [[nodiscard]] std::ptrdiff_t stride() const { return width_ + 2 * margin; }
  [[nodiscard]] std::ptrdiff_t offset() const { return margin_rows * stride() + margin; }

  int width_, height_;
  std::vector<std::uint8_t> pixels_;
};

inline int draw(std::mt19937& random, int lowest, int highest) {
  return std::uniform_int_distribution<int>(lowest, highest)(random);
}
inline double draw(std::mt19937& random, double lowest, double highest) {
  return std::uniform_real_distribution<double>(lowest, highest)(random);
}

inline Picture noise(int width, int height, std::mt19937& random, int lowest = 0,
                     int highest = 255) {
  Picture picture(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      picture(u, v) = static_cast<std::uint8_t>(draw(random, lowest, highest));
  return picture;
}

/// 255 with this probability, else 0.
inline Picture speckle(int width, int height, std::mt19937& random, double probability) {
  Picture picture(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) picture(u, v) = draw(random, 0.0, 1.0) < probability ? 255 : 0;
  return picture;
}

/// Equal pixel by pixel; names the first that differs.
inline ::testing::AssertionResult equal(GrayView a, GrayView b) {
  if (!a.sameSize(b)) return ::testing::AssertionFailure() << "sizes differ";
  for (int v = 0; v < a.height; ++v) {
    for (int u = 0; u < a.width; ++u) {
      if (a.at(u, v) != b.at(u, v))
        return ::testing::AssertionFailure() << "pixel (" << u << ", " << v << ") is "
                                             << int{a.at(u, v)} << ", not " << int{b.at(u, v)};
    }
  }
  return ::testing::AssertionSuccess();
}
inline ::testing::AssertionResult equal(const Picture& a, const Picture& b) {
  if (!a.guarded()) return ::testing::AssertionFailure() << "written outside the view";
  return equal(a.view(), b.view());
}

/// Sizes at which borders, tails of wide loops and whole blocks all occur.
inline std::vector<cv::Size> awkwardSizes() {
  std::vector<cv::Size> sizes;
  for (int height = 1; height <= 5; ++height)
    for (int width = 1; width <= 5; ++width) sizes.emplace_back(width, height);
  for (const int width : {15, 16, 17, 31, 33, 63, 64, 65, 127, 128, 129, 321})
    sizes.emplace_back(width, 7);
  sizes.emplace_back(7, 101);
  return sizes;
}

}  // namespace ipm_mapping::test
