#include "ipm_mapping/fpga/software_part.hpp"

#include <algorithm>

#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping::fpga {
namespace {

void loadRegisters(const FpgaParameters& parameters, FrameParameters& p) {
  p.use_horizon = parameters.use_horizon;
  p.min_threshold = parameters.min_threshold;
  p.score_min = parameters.score_min;
  p.min_height = parameters.min_height;
  p.valley_threshold = parameters.valley_threshold;
  p.bearing_tolerance = parameters.bearing_tolerance;
  p.undistort_current = parameters.undistort_current;
  p.paper_order = parameters.paper_order;
  p.method = parameters.method == ContactMethod::Triangle;
  p.single_bin_peaks = parameters.single_bin_peaks;
  p.free_space_rule = parameters.free_space_rule == FreeSpaceRule::Printed;
}

void loadHomography(const HomographyWords& h, FrameParameters& p) {
  p.h11 = h[0], p.h12 = h[1], p.h13 = h[2];
  p.h21 = h[3], p.h22 = h[4], p.h23 = h[5];
  p.h31 = h[6], p.h32 = h[7], p.h33 = h[8];
}

}  // namespace

SoftwarePart::SoftwarePart(const FpgaParameters& parameters) : parameters_(parameters) {
  validateFields("fpga", parameters);
  loadRegisters(parameters, registers_);
}

std::optional<CalibrationError> SoftwarePart::setCamera(const CameraModel& camera) {
  const auto error = quantiseCamera(camera, registers_);
  if (error) return error;
  const Integer addressable = (Integer{1} << address_bits) / registers_.width;
  registers_.memory_rows =
      std::clamp(Integer{parameters_.memory_rows}, registers_.height, addressable);
  return std::nullopt;
}

bool SoftwarePart::ignoresTangential(const CameraModel& camera) {
  return camera.distortion().p1 != 0.0 || camera.distortion().p2 != 0.0;
}

FrameSetup SoftwarePart::setup(const GroundView& view, std::uint8_t threshold_in) const {
  FrameSetup out;
  out.parameters = registers_;
  out.parameters.threshold_in = threshold_in;
  const auto homography = quantiseHomography(view);
  if (!homography) return out;
  out.homography_error = homography->worst_error;
  loadHomography(homography->words, out.parameters);
  const auto horizon = quantiseHorizon(view);
  out.parameters.horizon_a = horizon[0];
  out.parameters.horizon_b = horizon[1];
  out.parameters.horizon_c = horizon[2];
  const VanishingPoints points = vanishingPoints(view);
  out.focus = parameters_.mean_pixel_focus ? meanPixelFocus(points) : midFootFocus(points);
  const QuantisedFocus focus = quantiseFocus(out.focus, view.camera.width(), view.camera.height());
  out.status = focus.usable ? SetupStatus::Ok : SetupStatus::FocusUnusable;
  out.focus_clamped = focus.clamped;
  out.parameters.focus_u = focus.word.u;
  out.parameters.focus_v = focus.word.v;
  return out;
}

}  // namespace ipm_mapping::fpga
