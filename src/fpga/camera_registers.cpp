// Software part of rule 4: the camera's registers.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "ipm_mapping/fpga/homography_quantiser.hpp"

namespace ipm_mapping::fpga {
namespace {

/// Rounds into a register; reports a value that does not fit.
class RegisterWriter {
 public:
  template <class Format>
  void write(const char* name, double value, Format, Integer lowest, Integer& out) {
    const double raw = std::round(std::ldexp(value, Format::fraction_bits));
    const auto highest = static_cast<double>(Format::highest());
    if (raw >= static_cast<double>(lowest) && raw <= highest) {
      out = static_cast<Integer>(raw);
    } else if (!error_) {
      std::ostringstream text;
      text << name << " = " << value << " does not fit its register: "
           << std::ldexp(static_cast<double>(lowest), -Format::fraction_bits) << " ... "
           << std::ldexp(highest, -Format::fraction_bits);
      error_ = text.str();
    }
  }
  [[nodiscard]] const std::optional<CalibrationError>& error() const { return error_; }

 private:
  std::optional<CalibrationError> error_;
};

/// Slope of r (1 + k1 r^2 + k2 r^4 + k3 r^6) at r^2 = q.
double slope(const Distortion& d, double q) {
  return 1.0 + q * (3.0 * d.k1 + q * (5.0 * d.k2 + q * 7.0 * d.k3));
}

/// Where the slope has its own extremes, inside the register's range, in rising order.
std::array<double, 3> monotoneEnds(const Distortion& d, double end) {
  const double a = 21.0 * d.k3, b = 10.0 * d.k2, c = 3.0 * d.k1;
  std::array<double, 3> ends{end, end, end};
  const auto add = [&ends, end](std::size_t i, double q) {
    if (q > 0.0 && q < end) ends[i] = q;
  };
  if (a == 0.0) {
    if (b != 0.0) add(0, -c / b);
  } else if (const double square = b * b - 4.0 * a * c; square >= 0.0) {
    const double t = -0.5 * (b + std::copysign(std::sqrt(square), b));
    add(0, t / a);
    if (t != 0.0) add(1, c / t);
  }
  std::sort(ends.begin(), ends.end());
  return ends;
}

/// floor(65536 q) of the smallest positive root q of the slope, or the register's end.
Integer radiusRegister(const Distortion& d) {
  constexpr Integer highest = formats::RadiusSquared::highest();
  double low = 0.0;
  for (double high : monotoneEnds(d, static_cast<double>(highest + 1) / 65536.0)) {
    if (slope(d, high) > 0.0) {
      low = high;
      continue;
    }
    for (double middle = 0.5 * (low + high); middle > low && middle < high;
         middle = 0.5 * (low + high)) {
      (slope(d, middle) > 0.0 ? low : high) = middle;
    }
    return std::min(static_cast<Integer>(std::floor(65536.0 * high)), highest);
  }
  return highest;
}

}  // namespace

std::optional<CalibrationError> quantiseCamera(const CameraModel& camera, FrameParameters& p) {
  const Intrinsics& i = camera.intrinsics();
  const Distortion& d = camera.distortion();
  if (i.width < 1 || i.width > max_width || i.height < 1 || i.height > max_height) {
    return CalibrationError("image of " + std::to_string(i.width) + " x " +
                            std::to_string(i.height) + ": the datapath holds up to 640 x 480");
  }
  p.width = i.width;
  p.height = i.height;
  RegisterWriter out;
  const formats::CameraIntrinsic intrinsic{};
  const formats::LensCoefficient lens{};
  out.write("fx", i.fx, intrinsic, 1, p.fx);
  out.write("fy", i.fy, intrinsic, 1, p.fy);
  out.write("cx", i.cx, intrinsic, 0, p.cx);
  out.write("cy", i.cy, intrinsic, 0, p.cy);
  out.write("k1", d.k1, lens, lens.lowest(), p.k1);
  out.write("k2", d.k2, lens, lens.lowest(), p.k2);
  out.write("k3", d.k3, lens, lens.lowest(), p.k3);
  p.r2_max = radiusRegister(d);
  return out.error();
}

}  // namespace ipm_mapping::fpga
