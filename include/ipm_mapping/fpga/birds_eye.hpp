#pragma once
// Twin of the bird's-eye transformation of the first architecture (the source, §3.5, §6.3): the
// eroded image seen from straight above, by a homography with 14 fraction bits (column 3: 25
// bits), or with the 20 that §7.2.1 finds necessary.

#include <array>
#include <optional>

#include "ipm_mapping/fpga/fixed_point.hpp"
#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/geometry/ground_view.hpp"
#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

/// Formats of a bird's-eye matrix with so many fraction bits: the integer bits of the source's 25
/// bit third column (11) and of the 18-bit coefficients of §6.2.2 at 14 bits (4).
template <int FractionBits>
struct BirdsEyeFormats {
  using Linear = formats::Coefficient<4 + FractionBits, 4>;
  using Offset = formats::Coefficient<11 + FractionBits, 11>;
};

enum class BirdsEyePrecision : std::uint8_t { Source14 = 14, Wide20 = 20 };

/// Values of a pixel of the bird's-eye view.
inline constexpr std::uint8_t birds_eye_unseen = 2;

/// Virtual camera of the real one's K and size over the mid foot point, the current base's forward
/// axis upwards: takes its pixels to those of the current view (eq. 3.35 with equation 3.31 equal
/// to 1). The third row is the depth divided by the virtual camera's height.
struct BirdsEyeGeometry {
  Eigen::Matrix3d to_view = Eigen::Matrix3d::Identity();
  Eigen::Vector2d mid_foot{0, 0};  ///< in base, metres: seen at the principal point
  double metres_per_pixel = 0.0;

  /// `span`: metres across the width of the view.
  static BirdsEyeGeometry over(const GroundView& view, double span);
};

/// Coefficients as raw register values, row-major.
struct BirdsEyeWords {
  BirdsEyePrecision precision = BirdsEyePrecision::Source14;
  std::array<std::int64_t, 9> raw{};
};

/// Rounds to nearest at the largest power of two, not above 1, at which all coefficients fit;
/// nothing when there is none.
[[nodiscard]] std::optional<BirdsEyeWords> quantiseBirdsEye(const BirdsEyeGeometry& geometry,
                                                            BirdsEyePrecision precision);

/// Where an output pixel lies in the current view, 12.6 coordinates (rule 3's division).
struct BirdsEyePoint {
  int x = 0;
  int y = 0;
};
[[nodiscard]] std::optional<BirdsEyePoint> birdsEyePoint(const BirdsEyeWords& words, int u, int v);

/// The eroded image (0 or 1) at the nearest pixel; birds_eye_unseen outside the view.
void birdsEyeView(const BirdsEyeWords& words, ImageView<const std::uint8_t> eroded,
                  ImageView<std::uint8_t> out);

}  // namespace ipm_mapping::fpga
