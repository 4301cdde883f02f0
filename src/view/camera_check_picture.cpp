#include "ipm_mapping/view/camera_check_picture.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping/geometry/ground_homography.hpp"
#include "ipm_mapping/view/canvas.hpp"
#include "ipm_mapping/view/overlay.hpp"

namespace ipm_mapping {
namespace {

constexpr Color panel{0x151C23}, white{0xFFFFFF}, pale{0xC9D4DE};
constexpr Color stated_color{0xFF8A3C}, estimated_color{0x3DDC84};

constexpr int wanted_width = 1280;
constexpr double caption_height = 96.0;
constexpr double grid_step = 0.5, grid_far = 4.0, grid_side = 2.0;  // metres from the camera's foot
constexpr double enlarged_shift = 10.0;

class CheckDrawing {
 public:
  CheckDrawing(GrayView raw, const CameraModel& camera)
      : raw_(raw),
        camera_(camera),
        scale_(std::clamp(wanted_width / std::max(1, raw.width), 1, 4)),
        width_(raw.width * scale_),
        height_(raw.height * scale_),
        canvas_(width_, height_ + static_cast<int>(caption_height), panel) {
    canvas_.picture(rectified(raw, camera), 0, 0, width_, height_, true);
  }

  void pose(const CheckedPose& pose, Color color) {
    const GroundProjection floor(groundHomography(camera_.intrinsics(), pose.T_base_camera));
    canvas_.lines(grid(floor, pose.T_base_camera.translation().head<2>()), color, 1.3, 0.55);
    horizon(floor, color);
  }

  void shifts(const CheckedPose& pose, Color color) {
    std::vector<Polyline> lines;
    for (const sweep::PatchShift& s : pose.shifts) {
      double u = 0.0, v = 0.0;
      if (!camera_.undistortPixel(s.pixel.x(), s.pixel.y(), u, v)) continue;
      const Eigen::Vector2d from = onCanvas({u, v});
      lines.push_back({from, from + enlarged_shift * scale_ * s.shift});
      canvas_.disk(from, 2.5, color);
    }
    canvas_.lines(lines, color, 2.5);
  }

  cv::Mat finish(const CheckedPose& stated, const CheckedPose& estimated,
                 const std::string& facts) {
    canvas_.rectangle(-2, height_, width_ + 4, caption_height + 2, panel);
    line(facts, height_ + 30.0, 12.0, white);
    key(stated.words, height_ + 57.0, stated_color);
    key(estimated.words, height_ + 81.0, estimated_color);
    return canvas_.finish();
  }

 private:
  [[nodiscard]] Eigen::Vector2d onCanvas(const Eigen::Vector2d& pixel) const {
    return (pixel.array() + 0.5) * scale_ - 0.5;
  }
  [[nodiscard]] bool nearPicture(const Eigen::Vector2d& p) const {
    return p.x() > -width_ && p.y() > -height_ && p.x() < 2 * width_ && p.y() < height_;
  }
  /// A straight line on the floor, cut where it leaves the picture.
  [[nodiscard]] Polyline floorLine(const GroundProjection& floor, const Eigen::Vector2d& from,
                                   const Eigen::Vector2d& to) const {
    constexpr int parts = 80;
    Polyline line;
    for (int i = 0; i <= parts; ++i) {
      const auto pixel = floor.pixel(from + (to - from) * i / parts);
      if (!pixel || !nearPicture(onCanvas(*pixel))) continue;
      line.push_back(onCanvas(*pixel));
    }
    return line;
  }
  [[nodiscard]] std::vector<Polyline> grid(const GroundProjection& floor,
                                           const Eigen::Vector2d& foot) const {
    std::vector<Polyline> lines;
    for (double x = grid_step; x <= grid_far; x += grid_step)
      lines.push_back(floorLine(floor, foot + Eigen::Vector2d(x, -grid_side),
                                foot + Eigen::Vector2d(x, grid_side)));
    for (double y = -grid_side; y <= grid_side; y += grid_step)
      lines.push_back(
          floorLine(floor, foot + Eigen::Vector2d(0.1, y), foot + Eigen::Vector2d(grid_far, y)));
    return lines;
  }
  void horizon(const GroundProjection& floor, Color color) {
    const Eigen::Vector3d depth = floor.inverse().row(2);
    if (depth.y() == 0.0) return;
    Polyline line;
    for (const double u : {-0.5, raw_.width - 0.5})
      line.push_back(onCanvas({u, -(depth.x() * u + depth.z()) / depth.y()}));
    canvas_.dashedLine(line, color, 2.5, 16.0);
    if (line.front().y() > 20 && line.front().y() < height_ - 10)
      canvas_.textOnPicture("horizon", line.front() + Eigen::Vector2d(10, -8), 12.0, color);
  }
  void line(const std::string& words, double y, double size, Color color, double x = 16.0) {
    const double room = width_ - x - 16.0, needs = Canvas::textWidth(words, size);
    canvas_.text(words, {x, y}, needs > room ? size * room / needs : size, color);
  }
  void key(const std::string& words, double y, Color color) {
    canvas_.rectangle(16, y - 12, 16, 14, color);
    line(words, y, 11.0, pale, 40.0);
  }

  GrayView raw_;
  const CameraModel& camera_;
  int scale_, width_, height_;
  Canvas canvas_;
};

}  // namespace

cv::Mat drawCameraCheck(GrayView raw, const CameraModel& camera, const CheckedPose& stated,
                        const CheckedPose& estimated, const std::string& facts) {
  if (raw.empty()) return {};
  CheckDrawing drawing(raw, camera);
  drawing.pose(stated, stated_color);
  drawing.pose(estimated, estimated_color);
  drawing.shifts(stated, stated_color);
  drawing.shifts(estimated, estimated_color);
  return drawing.finish(stated, estimated, facts);
}

}  // namespace ipm_mapping
