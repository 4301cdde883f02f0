#pragma once

#include <array>
#include <optional>
#include <vector>

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/fpga/datapath.hpp"
#include "ipm_mapping/fpga/software_part.hpp"
#include "ipm_mapping/geometry/reference_selector.hpp"
#include "ipm_mapping/parameters.hpp"

namespace ipm_mapping {

/// The FPGA model as a detector: software part, bit-true datapath, and the points that its FIFO
/// hands back. Bearings without a contact are described from the eroded image.
class FpgaDetector : public Detector {
 public:
  explicit FpgaDetector(const Parameters& parameters);

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera) override;
  void reset() override;
  FrameStatus process(const Frame& frame, Obstacles& obstacles) override;
  [[nodiscard]] const std::vector<StageTime>& stageTimes() const override { return times_; }
  [[nodiscard]] const char* id() const override { return "fpga"; }

  /// Why the camera cannot be represented in the datapath's registers; nothing when it can.
  [[nodiscard]] const std::optional<CalibrationError>& cameraError() const { return camera_error_; }
  /// Registers and wires of the last used frame.
  [[nodiscard]] const fpga::FrameSetup& frameSetup() const { return setup_; }
  [[nodiscard]] const fpga::Results& results() const { return datapath_.results(); }
  [[nodiscard]] ImageView<const fpga::TaggedPixel> gaussian() const { return gaussian_.view(); }
  [[nodiscard]] GrayView eroded() const { return eroded_.view(); }
  /// Eroded image and correspondence as the mask values of the float chain.
  [[nodiscard]] GrayView mask() const { return mask_.view(); }
  /// Whether difference() is kept from the next frame on; the fast engine is quicker without it.
  void keepDifference(bool keep) { keep_difference_ = keep; }
  /// The difference wire of the last used frame; empty when it was not kept.
  [[nodiscard]] ImageView<const fpga::TaggedPixel> difference() const {
    return has_difference_ ? difference_.view() : ImageView<const fpga::TaggedPixel>{};
  }
  /// The reference picture of the last used frame; empty before.
  [[nodiscard]] GrayView reference() const;

 private:
  FrameStatus prepare(const Frame& frame, Obstacles& obstacles);
  void run(const Frame& frame);
  void composeMask();
  void describe(Obstacles& obstacles);
  void layLine(int line);
  [[nodiscard]] Contact contactOf(std::uint32_t word, const GroundProjection& floor) const;

  Parameters parameters_;
  CameraModel camera_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  bool has_camera_ = false;
  std::optional<CalibrationError> camera_error_;
  ReferenceSelector references_;
  const StoredFrame* reference_ = nullptr;
  fpga::SoftwarePart software_;
  fpga::Datapath datapath_;
  fpga::ThresholdRegister threshold_;
  fpga::FrameSetup setup_;
  bool keep_difference_ = false, has_difference_ = false;
  Image<fpga::TaggedPixel> difference_, gaussian_;
  Image<std::uint8_t> eroded_, mask_;
  std::vector<std::int16_t> columns_;  ///< of the line at hand, and the mask's values on it
  std::vector<std::uint8_t> values_;
  std::vector<StageTime> times_;
};

}  // namespace ipm_mapping
