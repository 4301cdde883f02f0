// Software part of rule 4: the camera's registers.
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

/// floor(65536 q) of the smallest positive root q of the slope, or the register's end.
/// floor(65536 q) of the turning point q of the lens, or the end of the register (rule 4).
Integer radiusRegister(const CameraModel& camera) {
  constexpr Integer highest = formats::RadiusSquared::highest();
  const double raw = std::floor(65536.0 * camera.turningRadiusSquared());
  return raw < static_cast<double>(highest) ? static_cast<Integer>(raw) : highest;
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
  p.r2_max = radiusRegister(camera);
  return out.error();
}

}  // namespace ipm_mapping::fpga
