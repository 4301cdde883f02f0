#pragma once
// Where a picture is to be sampled: between map and sampling, and the fixed map of a camera.

#include <cstdint>
#include <vector>

namespace ipm_mapping::kernels {

/// Sub-pixel steps of a sample's coordinates, and the mark of a sample outside the picture.
inline constexpr int sample_steps = 128;
inline constexpr std::uint16_t sample_outside = 0xFFFF;

/// Where to sample: for each of `rows` x `width` pixels the upper left of four raw pixels and the
/// way from it in steps of 1/128 px (0 ... 128). Rows are padded to whole blocks, with samples
/// outside.
class Samples {
 public:
  static constexpr int block = 64;  ///< pixels

  struct Row {
    std::int16_t* u;
    std::int16_t* v;
    std::uint16_t* way;  ///< right + 256 down; sample_outside: there is no sample
  };

  void resize(int width, int rows);
  [[nodiscard]] int paddedWidth() const { return padded_; }
  [[nodiscard]] Row row(int v) {
    const auto first = static_cast<std::ptrdiff_t>(v) * padded_;
    return {u_.data() + first, v_.data() + first, way_.data() + first};
  }
  /// Rounds raw coordinates into the sample (u, v) of a row; false where they lie more than half a
  /// step outside the W x H picture.
  static bool put(const Row& row, int u, double u_raw, double v_raw, int W, int H);

 private:
  int padded_ = 0;
  std::vector<std::int16_t> u_, v_;
  std::vector<std::uint16_t> way_;
};

}  // namespace ipm_mapping::kernels
