#include "ipm_mapping/view/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "ipm_mapping/view/canvas.hpp"

namespace ipm_mapping {
namespace {

constexpr Color panel{0x151C23}, white{0xFFFFFF}, pale{0xC9D4DE}, free_color{0x2FBF71};
constexpr Color blocked_color{0xFFB020}, contact_color{0xF0302B}, horizon_color{0x8FD3FF};
constexpr Color focus_color{0xFF8AD8}, moving_color{0x7A3BFF};

constexpr int wanted_width = 1280;
constexpr double caption_height = 112.0;
constexpr double ring_radii[] = {0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0};

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char text[160];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// Not by this frame itself: held by the detector, or remembered.
bool seenBefore(const Contact& contact) {
  constexpr float moment = 0.01F;  // seconds; a robot that stands sees with ages hardly above 0
  return contact.age > moment;
}

int enlargement(int width) { return std::clamp(wanted_width / std::max(1, width), 1, 4); }

class OverlayDrawing {
 public:
  OverlayDrawing(GrayView raw, const Obstacles& obstacles, const std::string& note)
      : raw_(raw),
        obstacles_(obstacles),
        note_(note),
        floor_(obstacles.view.currentFloor()),
        foot_(obstacles.view.cameraFoot()),
        scale_(enlargement(raw.width)),
        width_(raw.width * scale_),
        height_(raw.height * scale_),
        canvas_(width_, height_ + static_cast<int>(caption_height), panel) {}

  cv::Mat draw() {
    canvas_.picture(rectified(raw_, obstacles_.view.camera), 0, 0, width_, height_, true);
    fillBearings(free_color, 0.30, &OverlayDrawing::freeWedge);
    fillBearings(blocked_color, 0.38, &OverlayDrawing::blockedWedge);
    drawBeam();
    drawHorizon();
    drawRings();
    drawFocus();
    drawContacts();
    drawCaption();
    return canvas_.finish();
  }

 private:
  /// Canvas position of an undistorted pixel: pixel centres stay centres when enlarged.
  [[nodiscard]] Eigen::Vector2d onCanvas(const Eigen::Vector2d& pixel) const {
    return (pixel.array() + 0.5) * scale_ - 0.5;
  }
  [[nodiscard]] std::optional<Eigen::Vector2d> project(double angle, double range) const {
    const auto pixel =
        floor_.pixel(foot_ + range * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (!pixel) return std::nullopt;
    return onCanvas(*pixel);
  }
  [[nodiscard]] bool inPicture(const Eigen::Vector2d& p) const {
    return p.x() >= 0 && p.y() >= 0 && p.x() < width_ && p.y() < height_;
  }

  // --- bearings ----------------------------------------------------------------

  /// Angles half-way to the neighbouring bearings.
  [[nodiscard]] std::pair<double, double> sector(std::size_t i) const {
    const auto& all = obstacles_.bearings;
    const auto angle = [&all](std::size_t k) { return static_cast<double>(all[k].angle); };
    if (all.size() < 2) return {angle(i) + 0.005, angle(i) - 0.005};
    const double left = i > 0 ? 0.5 * (angle(i - 1) - angle(i)) : 0.5 * (angle(0) - angle(1));
    const double right =
        i + 1 < all.size() ? 0.5 * (angle(i + 1) - angle(i)) : 0.5 * (angle(i) - angle(i - 1));
    return {angle(i) + left, angle(i) + right};
  }
  [[nodiscard]] Polyline wedge(std::size_t i, double near, double far) const {
    const auto [left, right] = sector(i);
    Polyline outline;
    for (const auto& [angle, range] : {std::pair{left, near}, std::pair{left, far},
                                       std::pair{right, far}, std::pair{right, near}}) {
      const auto corner = project(angle, range);
      if (!corner) return {};
      outline.push_back(*corner);
    }
    return outline;
  }
  [[nodiscard]] Polyline freeWedge(std::size_t i) const {
    const Bearing& b = obstacles_.bearings[i];
    if (b.state == BearingState::Unknown || !(b.range > b.near)) return {};
    return wedge(i, static_cast<double>(b.near), static_cast<double>(b.range));
  }
  /// From the last floor that was seen up to where the detector looked.
  [[nodiscard]] Polyline blockedWedge(std::size_t i) const {
    const Bearing& b = obstacles_.bearings[i];
    const double from = static_cast<double>(std::max(b.range, b.near));
    if (b.state != BearingState::Blocked || !(obstacles_.max_range > from)) return {};
    return wedge(i, from, obstacles_.max_range);
  }
  void fillBearings(Color color, double alpha,
                    Polyline (OverlayDrawing::*outline)(std::size_t) const) {
    std::vector<Polyline> wedges;
    for (std::size_t i = 0; i < obstacles_.bearings.size(); ++i)
      wedges.push_back((this->*outline)(i));
    canvas_.fill(wedges, color, alpha);
  }
  void drawBeam() {
    std::vector<Polyline> beam;
    for (const Bearing& b : obstacles_.bearings) {
      const auto near = project(static_cast<double>(b.angle), static_cast<double>(b.near));
      const auto far = project(static_cast<double>(b.angle), obstacles_.max_range);
      if (near && far) beam.push_back({*near, *far});
    }
    canvas_.lines(beam, white, 1.0, 0.22);
  }

  // --- what the geometry says ------------------------------------------------------

  void drawRings() {
    for (const double radius : ring_radii) {
      if (radius > 1.001 * obstacles_.max_range) continue;
      Polyline arc;
      for (int degrees = -80; degrees <= 80; ++degrees)
        if (const auto p = project(degrees * M_PI / 180.0, radius)) arc.push_back(*p);
      canvas_.dashedLine(arc, white, 1.5, 9.0, 0.75);
      labelRing(arc, formatted("%g m", radius));
    }
  }
  /// At the ring's rightmost place in the picture.
  void labelRing(const Polyline& arc, const std::string& words) {
    const double room = Canvas::textWidth(words, 12.0) + 14.0;
    for (const Eigen::Vector2d& p : arc)
      if (p.x() < width_ - room && p.x() > 0 && p.y() > 24 && p.y() < height_ - 8) {
        canvas_.textOnPicture(words, p + Eigen::Vector2d(6, -6), 12.0, white);
        return;
      }
  }

  void drawHorizon() {
    const Eigen::Vector3d depth = floor_.inverse().row(2);
    if (depth.y() == 0.0) return;
    const auto at = [&](double u) {
      return onCanvas({u, -(depth.x() * u + depth.z()) / depth.y()});
    };
    const Eigen::Vector2d left = at(-0.5), right = at(raw_.width - 0.5);
    if (!inPicture(left + Eigen::Vector2d(1, 0)) && !inPicture(right - Eigen::Vector2d(1, 0)))
      return;
    canvas_.dashedLine({left, right}, horizon_color, 1.5, 14.0, 0.9);
    canvas_.textOnPicture("horizon", left + Eigen::Vector2d(10, left.y() > 30 ? -8 : 20), 12.0,
                          horizon_color);
  }

  /// Where all the beam's lines meet: a cross inside the picture, an arrow towards it outside.
  void drawFocus() {
    const auto focus = obstacles_.focus.pixel();
    if (!focus) return;
    const Eigen::Vector2d p = onCanvas(*focus);
    if (inPicture(p)) {
      canvas_.line({p - Eigen::Vector2d(12, 0), p + Eigen::Vector2d(12, 0)}, focus_color, 2.0);
      canvas_.line({p - Eigen::Vector2d(0, 12), p + Eigen::Vector2d(0, 12)}, focus_color, 2.0);
      canvas_.textOnPicture("beam's focus", p + Eigen::Vector2d(14, -6), 12.0, focus_color);
      return;
    }
    const Eigen::Vector2d middle(0.5 * width_, 0.5 * height_);
    const Eigen::Vector2d away = p - middle;
    const double reach =
        std::min(0.5 * width_ / std::abs(away.x()), 0.5 * height_ / std::abs(away.y()));
    const Eigen::Vector2d edge = middle + reach * away;
    const Eigen::Vector2d tail = edge - 46.0 * away.normalized();
    canvas_.arrow(tail, std::atan2(-away.y(), away.x()), 40.0, focus_color, 2.5);
    canvas_.textOnPicture(formatted("beam's focus, %.0f px further", (p - edge).norm() / scale_),
                          {std::clamp(tail.x() + 16.0, 8.0, width_ - 280.0),
                           std::clamp(tail.y(), 24.0, height_ - 10.0)},
                          12.0, focus_color);
  }

  void drawContacts() {
    for (const Contact& c : obstacles_.candidates)
      canvas_.ring(onCanvas({static_cast<double>(c.u), static_cast<double>(c.v)}), 4.0,
                   contact_color, 1.0);
    for (const Contact& c : obstacles_.contacts) {
      const Eigen::Vector2d p = onCanvas({static_cast<double>(c.u), static_cast<double>(c.v)});
      drawContact(p, 4.5, c.moving ? moving_color : contact_color, seenBefore(c));
    }
  }
  void drawContact(const Eigen::Vector2d& p, double radius, Color color, bool hollow) {
    canvas_.disk(p, radius + 2.0, white);
    canvas_.disk(p, radius, color);
    if (hollow) canvas_.disk(p, 0.55 * radius, white);
  }

  // --- caption -----------------------------------------------------------------------

  [[nodiscard]] int count(BearingState state) const {
    return static_cast<int>(std::count_if(obstacles_.bearings.begin(), obstacles_.bearings.end(),
                                          [state](const Bearing& b) { return b.state == state; }));
  }
  [[nodiscard]] std::string facts() const {
    const GroundView& view = obstacles_.view;
    std::string words =
        formatted("frame %llu   %.3f s   contacts %d   baseline %.1f cm   turn %.1f deg",
                  static_cast<unsigned long long>(obstacles_.frame), view.stamp,
                  static_cast<int>(obstacles_.contacts.size()), 100.0 * view.motion.distance(),
                  view.motion.theta * 180.0 / M_PI);
    if (obstacles_.threshold >= 0) words += formatted("   threshold %d", obstacles_.threshold);
    if (obstacles_.separability > 0.0F)
      words += formatted("   separability %.2f", static_cast<double>(obstacles_.separability));
    return words;
  }
  double key(double x, double y, Color color, const std::string& words) {
    canvas_.rectangle(x, y - 12, 16, 14, color);
    canvas_.text(words, {x + 24, y}, 11.0, pale);
    return x + 24 + Canvas::textWidth(words, 11.0) + 28;
  }
  double contactKey(double x, double y, bool hollow, const std::string& words) {
    drawContact({x + 7, y - 5}, 5.5, contact_color, hollow);
    canvas_.text(words, {x + 24, y}, 11.0, pale);
    return x + 24 + Canvas::textWidth(words, 11.0) + 28;
  }
  /// One line that is set smaller where the picture is too narrow for it.
  void captionLine(const std::string& words, double y, double size, Color color) {
    const double room = width_ - 32.0, needs = Canvas::textWidth(words, size);
    canvas_.text(words, {16, y}, needs > room ? size * room / needs : size, color);
  }
  void drawCaption() {
    const double top = height_, y = top + 92;
    canvas_.rectangle(-2, top, width_ + 4, caption_height + 2, panel);
    captionLine(facts(), top + 32, 12.0, white);
    captionLine(formatted("bearings: %d free, %d occupied, %d blocked, %d unknown",
                          count(BearingState::Free), count(BearingState::Occupied),
                          count(BearingState::Blocked), count(BearingState::Unknown)) +
                    (note_.empty() ? "" : "   |   " + note_),
                top + 62, 11.0, pale);
    double x = contactKey(16, y, false, "obstacle meets floor");
    const auto& contacts = obstacles_.contacts;
    if (std::any_of(contacts.begin(), contacts.end(), seenBefore))
      x = contactKey(x, y, true, "a moment ago");
    x = key(x, y, free_color, "free floor");
    if (std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.moving; }))
      x = key(x, y, moving_color, "moves");
    x = key(x, y, blocked_color, "obstacle, its foot not in view");
    canvas_.dashedLine({{x, y - 5}, {x + 30, y - 5}}, white, 1.5, 6.0);
    canvas_.text("distance from the camera's foot", {x + 38, y}, 11.0, pale);
  }

  GrayView raw_;
  const Obstacles& obstacles_;
  const std::string& note_;
  GroundProjection floor_;
  Eigen::Vector2d foot_;
  int scale_;
  int width_;
  int height_;
  Canvas canvas_;
};

}  // namespace

cv::Mat rectified(GrayView raw, const CameraModel& camera) {
  const cv::Mat source(raw.height, raw.width, CV_8UC1, const_cast<std::uint8_t*>(raw.data),
                       static_cast<std::size_t>(raw.stride));
  cv::Mat u(raw.height, raw.width, CV_32FC1), v(raw.height, raw.width, CV_32FC1), out;
  for (int row = 0; row < raw.height; ++row)
    for (int column = 0; column < raw.width; ++column) {
      double raw_u = 0.0, raw_v = 0.0;
      if (!camera.distortPixel(column, row, raw_u, raw_v)) raw_u = raw_v = -1e4;
      u.at<float>(row, column) = static_cast<float>(raw_u);
      v.at<float>(row, column) = static_cast<float>(raw_v);
    }
  cv::remap(source, out, u, v, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return out;
}

cv::Mat drawOverlay(GrayView raw, const Obstacles& obstacles, const std::string& note) {
  if (raw.empty()) return {};
  return OverlayDrawing(raw, obstacles, note).draw();
}

}  // namespace ipm_mapping
