#include "ipm_mapping/view/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ipm_mapping/view/canvas.hpp"

namespace ipm_mapping {
namespace {

constexpr Color paper{0xFFFFFF}, ink{0x22303C}, faint_ink{0x6B7885};
constexpr Color unknown_color{0xE4E8EC}, free_color{0xFFFFFF}, occupied_color{0x263645};
constexpr Color grid_color{0x9FB1C2}, path_color{0x2F7FD6}, start_color{0x2E9E5B};
constexpr Color end_color{0xE08A00}, truth_color{0xE0312F};

constexpr double margin = 64.0;        // pixels around the map
constexpr double title_height = 56.0;  // above it
constexpr double legend_height = 112.0;
constexpr double content_margin = 0.4;  // metres around what is known
constexpr int wanted_size = 1100;       // pixels of the map's longer side
constexpr int smallest_width = 640;

/// Part of the floor that is shown, metres.
struct Window {
  double left = 0, right = 0, bottom = 0, top = 0;
  bool any = false;

  void add(double x, double y) {
    left = any ? std::min(left, x) : x;
    right = any ? std::max(right, x) : x;
    bottom = any ? std::min(bottom, y) : y;
    top = any ? std::max(top, y) : y;
    any = true;
  }
};

std::int8_t cellAt(const TrinaryMap& map, int x, int y) {
  return map.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) +
                   static_cast<std::size_t>(x)];
}

/// Everything known and the trajectory, with a margin, in whole cells.
Window contentOf(const TrinaryMap& map, const MapAnnotations& annotations) {
  Window window;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      if (cellAt(map, x, y) < 0) continue;
      window.add(map.origin_x + x * map.resolution, map.origin_y + y * map.resolution);
      window.add(map.origin_x + (x + 1) * map.resolution, map.origin_y + (y + 1) * map.resolution);
    }
  for (const SE2& pose : annotations.trajectory)
    if (pose.finite()) window.add(pose.x, pose.y);
  if (!window.any) window.add(0.0, 0.0);
  const auto whole = [&map](double value, bool up) {
    const double cells = value / map.resolution;
    return map.resolution * (up ? std::ceil(cells - 1e-6) : std::floor(cells + 1e-6));
  };
  return {whole(window.left - content_margin, false), whole(window.right + content_margin, true),
          whole(window.bottom - content_margin, false), whole(window.top + content_margin, true),
          true};
}

/// 1, 2 or 5 times a power of ten, not above `length`.
double roundLength(double length) {
  const double decade = std::pow(10.0, std::floor(std::log10(length)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= length) return factor * decade;
  return decade;
}

std::string metres(double value, const char* unit) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g%s", std::abs(value) < 1e-9 ? 0.0 : value, unit);
  return text;
}

/// Draws one map; members are the shared geometry.
class MapDrawing {
 public:
  MapDrawing(const TrinaryMap& map, const MapAnnotations& annotations)
      : map_(map),
        annotations_(annotations),
        window_(contentOf(map, annotations)),
        scale_(pixelsPerMetre()),
        map_width_((window_.right - window_.left) * scale_),
        map_height_((window_.top - window_.bottom) * scale_),
        left_(0.5 * (pictureWidth() - map_width_)),
        canvas_(pictureWidth(),
                static_cast<int>(std::lround(title_height + map_height_ + legend_height)), paper,
                2) {}

  cv::Mat draw() {
    drawCells();
    drawGrid();
    drawTruth();
    drawTrajectory();
    coverMargins();
    drawFrame();
    drawLabels();
    drawScaleBar();
    drawLegend();
    return canvas_.finish();
  }

 private:
  [[nodiscard]] double pixelsPerMetre() const {
    const double longer =
        std::max(window_.right - window_.left, window_.top - window_.bottom) / map_.resolution;
    return std::clamp(std::floor(wanted_size / longer), 1.0, 24.0) / map_.resolution;
  }
  [[nodiscard]] int pictureWidth() const {
    return std::max(smallest_width, static_cast<int>(std::lround(map_width_ + 2.0 * margin)));
  }
  [[nodiscard]] Eigen::Vector2d pixel(double x, double y) const {
    return {left_ + (x - window_.left) * scale_ - 0.5,
            title_height + (window_.top - y) * scale_ - 0.5};
  }

  void drawCells() {
    cv::Mat cells(std::max(1, map_.height), std::max(1, map_.width), CV_8UC3, unknown_color.bgr());
    const auto colorOf = [](std::int8_t value) {
      const cv::Scalar c = (value == 100 ? occupied_color
                            : value == 0 ? free_color
                                         : unknown_color)
                               .bgr();
      return cv::Vec3b(cv::saturate_cast<std::uint8_t>(c[0]), cv::saturate_cast<std::uint8_t>(c[1]),
                       cv::saturate_cast<std::uint8_t>(c[2]));
    };
    for (int y = 0; y < map_.height; ++y)
      for (int x = 0; x < map_.width; ++x)
        cells.at<cv::Vec3b>(map_.height - 1 - y, x) = colorOf(cellAt(map_, x, y));
    canvas_.rectangle(left_, title_height, map_width_, map_height_, unknown_color);
    canvas_.picture(
        cells, left_ + (map_.origin_x - window_.left) * scale_,
        title_height + (window_.top - map_.origin_y - map_.height * map_.resolution) * scale_,
        map_.width * map_.resolution * scale_, map_.height * map_.resolution * scale_, false);
  }

  /// Every metre, or every 2, 5, 10 ... where metres would be closer than 50 pixels.
  [[nodiscard]] static std::vector<double> ticks(double from, double to, double scale) {
    const double step = std::max(1.0, roundLength(2.0 * 50.0 / scale));
    std::vector<double> all;
    for (double at = std::ceil(from / step) * step; at <= to; at += step) all.push_back(at);
    return all;
  }

  void drawGrid() {
    std::vector<Polyline> grid;
    for (const double x : ticks(window_.left, window_.right, scale_))
      grid.push_back({pixel(x, window_.bottom), pixel(x, window_.top)});
    for (const double y : ticks(window_.bottom, window_.top, scale_))
      grid.push_back({pixel(window_.left, y), pixel(window_.right, y)});
    canvas_.lines(grid, grid_color, 1.0, 0.45);
  }

  void drawLabels() {
    for (const double x : ticks(window_.left, window_.right, scale_))
      canvas_.text(metres(x, ""), pixel(x, window_.bottom) + Eigen::Vector2d(0, 20), 9.5, faint_ink,
                   Canvas::Anchor::Center);
    for (const double y : ticks(window_.bottom, window_.top, scale_))
      canvas_.text(metres(y, ""), pixel(window_.left, y) + Eigen::Vector2d(-8, 4), 9.5, faint_ink,
                   Canvas::Anchor::Right);
    canvas_.text("x [m]", pixel(window_.right, window_.bottom) + Eigen::Vector2d(8, 20), 9.5,
                 faint_ink);
    canvas_.text("y [m]", pixel(window_.left, window_.top) + Eigen::Vector2d(-8, -8), 9.5,
                 faint_ink, Canvas::Anchor::Right);
    canvas_.text(annotations_.title, {left_, 32}, 14.0, ink);
  }

  void drawTruth() {
    for (const Outline& outline : annotations_.truth) {
      Polyline line;
      for (const Eigen::Vector2d& p : outline.points) line.push_back(pixel(p.x(), p.y()));
      if (outline.closed && !line.empty()) line.push_back(line.front());
      canvas_.line(line, truth_color, 2.0);
    }
  }

  void drawTrajectory() {
    Polyline path;
    const SE2 *first = nullptr, *last = nullptr;
    for (const SE2& pose : annotations_.trajectory) {
      if (!pose.finite()) continue;
      path.push_back(pixel(pose.x, pose.y));
      if (first == nullptr) first = &pose;
      last = &pose;
    }
    if (first == nullptr) return;
    canvas_.line(path, paper, 5.0);
    canvas_.line(path, path_color, 2.5);
    drawPose(*first, start_color);
    drawPose(*last, end_color);
  }
  void drawPose(const SE2& pose, Color color) {
    const Eigen::Vector2d at = pixel(pose.x, pose.y);
    canvas_.arrow(at, pose.theta, 32.0, paper, 7.0);
    canvas_.disk(at, 9.5, paper);
    canvas_.arrow(at, pose.theta, 28.0, color, 3.5);
    canvas_.disk(at, 7.5, color);
  }

  /// What was drawn across the map's edge is wiped off again.
  void coverMargins() {
    const double below = title_height + map_height_;
    const double w = canvas_.width() + 4.0, h = canvas_.height() + 4.0;
    canvas_.rectangle(-2, -2, w, title_height + 2, paper);
    canvas_.rectangle(-2, below, w, h - below, paper);
    canvas_.rectangle(-2, -2, left_ + 2, h, paper);
    canvas_.rectangle(left_ + map_width_, -2, w, h, paper);
  }

  void drawFrame() {
    const double right = left_ + map_width_ - 0.5, below = title_height + map_height_ - 0.5;
    canvas_.line({{left_ - 0.5, title_height - 0.5},
                  {right, title_height - 0.5},
                  {right, below},
                  {left_ - 0.5, below},
                  {left_ - 0.5, title_height - 0.5}},
                 grid_color, 1.0);
  }

  void drawScaleBar() {
    const double length = roundLength(0.3 * (window_.right - window_.left));
    const double right = left_ + map_width_, y = legendTop() + 18;
    const double left = right - length * scale_;
    canvas_.line({{left, y - 6}, {left, y}, {right, y}, {right, y - 6}}, ink, 2.0);
    canvas_.text(metres(length, " m"), {0.5 * (left + right), y + 20}, 10.0, ink,
                 Canvas::Anchor::Center);
  }

  [[nodiscard]] double legendTop() const { return title_height + map_height_ + 42.0; }

  double swatch(double x, double y, Color color, const char* words) {
    canvas_.rectangle(x, y - 12, 16, 16, grid_color);
    canvas_.rectangle(x + 1, y - 11, 14, 14, color);
    canvas_.text(words, {x + 24, y + 1}, 10.0, ink);
    return x + 24 + Canvas::textWidth(words, 10.0) + 26;
  }
  double stroke(double x, double y, Color color, const char* words) {
    canvas_.line({{x, y - 4}, {x + 24, y - 4}}, color, 2.5);
    canvas_.text(words, {x + 32, y + 1}, 10.0, ink);
    return x + 32 + Canvas::textWidth(words, 10.0) + 26;
  }
  double pose(double x, double y, Color color, const char* words) {
    canvas_.arrow({x + 5, y - 4}, 0.0, 19.0, color, 2.5);
    canvas_.disk({x + 5, y - 4}, 5.0, color);
    canvas_.text(words, {x + 32, y + 1}, 10.0, ink);
    return x + 32 + Canvas::textWidth(words, 10.0) + 26;
  }

  void drawLegend() {
    const double y = legendTop() + 14;
    double x = swatch(left_, y, occupied_color, "obstacle");
    x = swatch(x, y, free_color, "free floor");
    swatch(x, y, unknown_color, "unknown");
    x = left_;
    if (!annotations_.trajectory.empty()) {
      x = stroke(x, y + 28, path_color, "robot's path");
      x = pose(x, y + 28, start_color, "start");
      x = pose(x, y + 28, end_color, "end");
    }
    if (!annotations_.truth.empty()) stroke(x, y + 28, truth_color, "true outlines");
  }

  const TrinaryMap& map_;
  const MapAnnotations& annotations_;
  Window window_;
  double scale_;
  double map_width_;
  double map_height_;
  double left_;
  Canvas canvas_;
};

}  // namespace

cv::Mat drawMap(const TrinaryMap& map, const MapAnnotations& annotations) {
  return MapDrawing(map, annotations).draw();
}

}  // namespace ipm_mapping
