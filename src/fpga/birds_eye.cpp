#include "ipm_mapping/fpga/birds_eye.hpp"

#include <cmath>

namespace ipm_mapping::fpga {
namespace {

/// Rule 3's operators with this architecture's formats.
template <int FractionBits>
class Transformation {
 public:
  explicit Transformation(const BirdsEyeWords& words) : raw_(words.raw) {}

  [[nodiscard]] std::optional<BirdsEyePoint> at(int u, int v) const {
    const auto column = formats::Generated::fromRaw(u);
    const auto row = formats::Generated::fromRaw(v);
    const auto d = sum(2, column, row);
    if (d.raw() <= 0) return std::nullopt;
    constexpr int fraction = formats::ViewCoordinate::fraction_bits;
    const auto x = fit<formats::ViewCoordinate>(divide<fraction>(sum(0, column, row), d));
    const auto y = fit<formats::ViewCoordinate>(divide<fraction>(sum(1, column, row), d));
    if (!x || !y) return std::nullopt;
    return BirdsEyePoint{static_cast<int>(x->raw()), static_cast<int>(y->raw())};
  }

 private:
  using Formats = BirdsEyeFormats<FractionBits>;
  [[nodiscard]] auto sum(std::size_t row, formats::Generated u, formats::Generated v) const {
    return Formats::Linear::fromRaw(raw_[3 * row]) * u +
           Formats::Linear::fromRaw(raw_[3 * row + 1]) * v +
           Formats::Offset::fromRaw(raw_[3 * row + 2]);
  }
  std::array<std::int64_t, 9> raw_;
};

template <int FractionBits>
bool roundInto(const Eigen::Matrix3d& matrix, double scale, std::array<std::int64_t, 9>& raw) {
  using Formats = BirdsEyeFormats<FractionBits>;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double value = matrix(static_cast<int>(i / 3), static_cast<int>(i % 3));
    const double rounded = std::round(std::ldexp(value * scale, FractionBits));
    const double highest =
        static_cast<double>(i % 3 == 2 ? Formats::Offset::highest() : Formats::Linear::highest());
    if (!(rounded >= -highest - 1.0 && rounded <= highest)) return false;
    raw[i] = static_cast<std::int64_t>(rounded);
  }
  return true;
}

template <int FractionBits>
void viewWith(const BirdsEyeWords& words, ImageView<const std::uint8_t> eroded,
              ImageView<std::uint8_t> out) {
  const Transformation<FractionBits> transformation(words);
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const auto point = transformation.at(u, v);
      const int ui = point ? (point->x + 32) >> 6 : -1;
      const int vi = point ? (point->y + 32) >> 6 : -1;
      out.at(u, v) = eroded.contains(ui, vi) ? eroded.at(ui, vi) : birds_eye_unseen;
    }
  }
}

}  // namespace

BirdsEyeGeometry BirdsEyeGeometry::over(const GroundView& view, double span) {
  const Intrinsics& k = view.camera.intrinsics();
  BirdsEyeGeometry geometry;
  const Eigen::Vector2d foot = view.cameraFoot();
  geometry.mid_foot = 0.5 * (foot + view.motion.inverse() * foot);
  geometry.metres_per_pixel = span / k.width;
  const double height = k.fx * geometry.metres_per_pixel;
  const double down = height / k.fy, left = height / k.fx;
  Eigen::Matrix3d floor_from_pixel;
  floor_from_pixel << 0, -down, geometry.mid_foot.x() + down * k.cy,  //
      -left, 0, geometry.mid_foot.y() + left * k.cx,                  //
      0, 0, 1;
  geometry.to_view = view.currentFloor().H() * floor_from_pixel / height;
  return geometry;
}

std::optional<BirdsEyeWords> quantiseBirdsEye(const BirdsEyeGeometry& geometry,
                                              BirdsEyePrecision precision) {
  BirdsEyeWords words;
  words.precision = precision;
  for (double scale = 1.0; scale > 1e-6; scale /= 2.0) {
    const bool fits = precision == BirdsEyePrecision::Source14
                          ? roundInto<14>(geometry.to_view, scale, words.raw)
                          : roundInto<20>(geometry.to_view, scale, words.raw);
    if (fits) return words;
  }
  return std::nullopt;
}

std::optional<BirdsEyePoint> birdsEyePoint(const BirdsEyeWords& words, int u, int v) {
  return words.precision == BirdsEyePrecision::Source14 ? Transformation<14>(words).at(u, v)
                                                        : Transformation<20>(words).at(u, v);
}

void birdsEyeView(const BirdsEyeWords& words, ImageView<const std::uint8_t> eroded,
                  ImageView<std::uint8_t> out) {
  if (words.precision == BirdsEyePrecision::Source14) {
    viewWith<14>(words, eroded, out);
  } else {
    viewWith<20>(words, eroded, out);
  }
}

}  // namespace ipm_mapping::fpga
