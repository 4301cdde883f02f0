#pragma once
// What runs on the processor beside the datapath (§6.2.4, §6.8): from the geometry of a frame
// pair to the registers of one frame (rules 3, 4, 10).

#include <optional>

#include "ipm_mapping/fpga/focus.hpp"
#include "ipm_mapping/fpga/homography_quantiser.hpp"
#include "ipm_mapping/parameters/fpga_parameters.hpp"

namespace ipm_mapping::fpga {

enum class SetupStatus : std::uint8_t { Ok, HomographyUnusable, FocusUnusable };

/// How one frame's registers were found.
struct FrameSetup {
  SetupStatus status = SetupStatus::HomographyUnusable;
  FrameParameters parameters;  ///< valid when the status is Ok
  Focus focus;                 ///< before quantisation
  bool focus_clamped = false;
  double homography_error = 0.0;  ///< px, worst point of the grid
};

class SoftwarePart {
 public:
  explicit SoftwarePart(const FpgaParameters& parameters = {});

  /// Loads the camera's registers. Says which value does not fit, or nothing.
  [[nodiscard]] std::optional<CalibrationError> setCamera(const CameraModel& camera);
  /// Whether the lens has tangential coefficients, which the hardware ignores: worth one warning.
  [[nodiscard]] static bool ignoresTangential(const CameraModel& camera);

  /// Registers for the frame pair of `view`, whose camera is the one of setCamera().
  [[nodiscard]] FrameSetup setup(const GroundView& view, std::uint8_t threshold_in) const;

 private:
  FpgaParameters parameters_;
  FrameParameters registers_;
};

}  // namespace ipm_mapping::fpga
