#pragma once
// One row of a warp: where to sample the raw picture, and the sampling. Every instruction set gives
// the same bits: the order of the floating-point operations is fixed, everything after it is
// integer arithmetic.

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"

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

/// plumb_bob in single precision.
struct Lens {
  float fx, fy, cx, cy;
  float k1, k2, p1, p2, k3;
  float turning_radius_squared;
  int width, height;
};

/// A row of pixels as rays of the reference camera: (x, y, z) + u (dx, dy, dz), and the inverse
/// depth of their floor points in the current view.
struct RayRow {
  float x, y, z, inverse_depth;
  float dx, dy, dz, d_inverse_depth;
};

/// Exact raw coordinates of every pixel of one row; NaN near or beyond what makes a pixel invalid
/// (a pixel from the picture's border, the turning radius, the horizon).
struct KeyRow {
  std::vector<float> u, v;
};
void mapKeyRow(const RayRow& rays, const Lens& lens, KeyRow& key);

/// Three key rows and their weights for a row between them.
struct KeyRows {
  std::array<const KeyRow*, 3> rows;
  std::array<float, 3> weights;
};

/// Fills a row with the raw pixels that its rays meet through the lens: outside the picture where z
/// or the inverse depth is not positive, beyond the turning radius, or more than half a step
/// outside the picture. Interpolates where all three key rows have coordinates; exact elsewhere,
/// and everywhere without key rows.
void mapRow(const RayRow& rays, const KeyRows* keys, const Lens& lens, const Samples::Row& samples,
            int padded_width);

/// What sampling a row does to the pixels' validity.
enum class Validity : std::uint8_t {
  Set,  ///< 255 where there is a sample, else 0
  And   ///< kept where there is a sample, else 0
};

/// Samples `width` pixels bilinearly: out = grey level, 0 where there is no sample. The grey level
/// is the exact mean of the four pixels, off by less than 1/32 before it is rounded.
/// scratch: 2 * padded width.
void sampleRow(GrayView raw, const Samples::Row& samples, int width, Validity validity,
               std::uint16_t* scratch, std::uint8_t* out, std::uint8_t* valid);

}  // namespace ipm_mapping::kernels
