#pragma once

#include "ipm_mapping/detector.hpp"
#include "ipm_mapping/geometry/reference_selector.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/stages/undistort_warp.hpp"

namespace ipm_mapping {

/// First link of the chain: raw frame and pose in, difference image out (the source, §3.3, §6.2,
/// §6.4). The caller owns the output buffers, so that they can be a message's.
///
///   if (ipm.select(frame, view) == FrameStatus::Used) ipm.difference(difference, valid);
///   ipm.remember();
class InversePerspectiveMapping {
 public:
  explicit InversePerspectiveMapping(const ReferenceParameters& parameters = {});

  void setCamera(const CameraModel& camera, const CameraPose& T_base_camera);
  void reset();

  /// Chooses the reference for `frame` and fills `view`. `frame` has to outlive the next two calls.
  FrameStatus select(const Frame& frame, GroundView& view);
  /// Writes |warped reference - undistorted current| and its validity (255 or 0), W x H each.
  /// Only after select() answered Used.
  void difference(GrayBuffer difference, GrayBuffer valid);
  /// Keeps the frame given to select() as a reference for later ones.
  void remember();

  /// The two pictures of the last difference(), W x H, undistorted; 0 where not seen.
  [[nodiscard]] GrayView rectified() const { return rectified_.view(); }
  [[nodiscard]] GrayView warped() const { return warped_.view(); }

 private:
  CameraModel camera_;
  CameraPose T_base_camera_ = CameraPose::Identity();
  bool has_camera_ = false;
  ReferenceSelector references_;
  UndistortWarp warp_;
  Frame frame_;
  const StoredFrame* reference_ = nullptr;
  GroundView view_;
  Image<std::uint8_t> rectified_, warped_;
};

}  // namespace ipm_mapping
