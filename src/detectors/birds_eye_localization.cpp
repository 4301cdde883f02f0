#include "ipm_mapping/detectors/birds_eye_localization.hpp"

#include <algorithm>
#include <cmath>

namespace ipm_mapping {
namespace {

/// Azimuths of the rays through the picture's border, in base axes.
struct FieldOfView {
  double left = -M_PI;
  double right = M_PI;
};
FieldOfView fieldOfView(const CameraModel& camera, const CameraPose& T_base_camera) {
  const Intrinsics& k = camera.intrinsics();
  FieldOfView field;
  for (int v = 0; v < k.height; ++v) {
    for (const int u : {0, k.width - 1}) {
      const Eigen::Vector3d ray =
          T_base_camera.linear() * Eigen::Vector3d((u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0);
      if (ray.z() >= 0.0 || ray.x() <= 0.0) continue;
      const double azimuth = std::atan2(ray.y(), ray.x());
      field.left = std::max(field.left, azimuth);
      field.right = std::min(field.right, azimuth);
    }
  }
  if (!(field.left > field.right)) return {0.5, -0.5};
  return field;
}

}  // namespace

void BirdsEyeLocalization::prepare(const GroundView& view) {
  if (view.camera == camera_ && view.T_base_camera.isApprox(T_base_camera_, 1e-12) &&
      grid_.bins() > 0)
    return;
  camera_ = view.camera;
  T_base_camera_ = view.T_base_camera;
  const FieldOfView field = fieldOfView(camera_, T_base_camera_);
  grid_ = PolarGrid(camera_.intrinsics(), parameters_.n_bins, field.left, field.right);
  birds_eye_mask_.resize(camera_.width(), camera_.height());
}

void BirdsEyeLocalization::describeBearings(const BirdsEye& birds_eye, const GroundView& view,
                                            Obstacles& obstacles) {
  // The radii count from the mid foot point, a bearing's range from the camera's: half a baseline.
  const double shift = (birds_eye.mid_foot - view.cameraFoot()).x();
  for (int bin = 0; bin < grid_.bins(); ++bin) {
    const SeenRun run = seenRun(counts_, grid_.radii(), bin);
    Bearing bearing;
    bearing.angle = static_cast<float>(grid_.angle(bin));
    if (run.first >= 0) {
      const double far =
          std::min(run.last * birds_eye.metres_per_pixel + shift, obstacles.max_range);
      bearing.near = static_cast<float>(std::max(run.first * birds_eye.metres_per_pixel, 0.0));
      bearing.range = static_cast<float>(far);
      bearing.state = BearingState::Free;
      bearing.density = static_cast<float>(counts_.bear[static_cast<std::size_t>(bin)]) /
                        static_cast<float>(std::max(run.last - run.first + 1, 1));
    }
    obstacles.bearings.push_back(bearing);
  }
}

void BirdsEyeLocalization::addContact(const BirdsEye& birds_eye, const GroundView& view,
                                      const Peak& peak, Obstacles& obstacles) {
  const Sector sector = sectorOf(counts_.bear, peak, parameters_.sector_share);
  const int radius = firstRadius(counts_, grid_.radii(), sector, parameters_.radial_threshold);
  if (radius < 0) return;
  const double angle = grid_.angle(peak.bearing), range = radius * birds_eye.metres_per_pixel;
  const Eigen::Vector2d p =
      birds_eye.mid_foot + range * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto pixel = view.currentFloor().pixel(p);
  if (!pixel || p.norm() > obstacles.max_range) return;
  Contact contact;
  contact.bearing = peak.bearing;
  contact.u = static_cast<float>(pixel->x());
  contact.v = static_cast<float>(pixel->y());
  contact.p_base = p.cast<float>();
  contact.score = static_cast<float>(peak.amplitude);
  obstacles.candidates.push_back(contact);
  obstacles.contacts.push_back(contact);
  const auto distance = static_cast<float>((p - view.cameraFoot()).norm());
  for (int bin = sector.first; bin <= sector.last; ++bin) {
    Bearing& bearing = obstacles.bearings[static_cast<std::size_t>(bin)];
    if (bearing.state == BearingState::Occupied && bearing.range < distance) continue;
    bearing.state = BearingState::Occupied;
    bearing.range = distance;
  }
}

FrameStatus BirdsEyeLocalization::process(const GroundView& view, GrayView obstacle_mask,
                                          Obstacles& obstacles) {
  obstacles.bearings.clear();
  obstacles.contacts.clear();
  obstacles.candidates.clear();
  obstacles.view = view;
  obstacles.max_range = effectiveMaxRange(localization_.max_range, view.camera, view.T_base_camera);
  obstacles.focus = midFootFocus(vanishingPoints(view));
  prepare(view);

  const BirdsEye birds_eye = BirdsEye::over(view, parameters_.span);  // eq. 3.35
  birdsEyeView(birds_eye, obstacle_mask, birds_eye_mask_.view());
  grid_.count(birds_eye_mask_.view(), counts_);                     // §3.6
  findPeaks(counts_.bear, localization_.single_bin_peaks, peaks_);  // §3.7
  groupPeaks(counts_.bear, localization_.free_space_rule, localization_.valley_threshold, peaks_);
  describeBearings(birds_eye, view, obstacles);
  for (const Peak& peak : peaks_) addContact(birds_eye, view, peak, obstacles);  // §3.8
  return FrameStatus::Used;
}

}  // namespace ipm_mapping
