#include "ipm_mapping/view/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ipm_mapping {
namespace {

constexpr int font = cv::FONT_HERSHEY_SIMPLEX;
constexpr double capital_height = 21.0;  // of the font at scale 1
constexpr int shift = 4;                 // binary places of OpenCV's drawing coordinates
constexpr double farthest = 1e5;         // OpenCV's coordinates are ints

double scaleOf(double size) { return size / capital_height; }

}  // namespace

Canvas::Canvas(int width, int height, Color background, int finer)
    : width_(width),
      height_(height),
      finer_(finer),
      pixels_(height * finer, width * finer, CV_8UC3, background.bgr()) {}

cv::Point Canvas::fixedPoint(const Eigen::Vector2d& p) const {
  const auto place = [this](double value) {
    const double fine = std::clamp(value, -farthest, farthest) * finer_ + 0.5 * (finer_ - 1);
    return static_cast<int>(std::lround(fine * (1 << shift)));
  };
  return {place(p.x()), place(p.y())};
}

std::vector<cv::Point> Canvas::fixedPoints(const Polyline& points) const {
  std::vector<cv::Point> fixed;
  for (const Eigen::Vector2d& p : points) fixed.push_back(fixedPoint(p));
  return fixed;
}

int Canvas::strokeWidth(double thickness) const {
  return std::max(1, static_cast<int>(std::lround(thickness * finer_)));
}

template <class Draw>
void Canvas::shape(Color color, double alpha, Draw&& draw) {
  if (alpha >= 1.0) {
    draw(pixels_, color.bgr());
    return;
  }
  mask_.create(pixels_.size(), CV_8UC1);
  mask_.setTo(0);
  draw(mask_, cv::Scalar(255.0 * alpha));
  const cv::Rect used = cv::boundingRect(mask_);
  const cv::Scalar bgr = color.bgr();
  for (int v = used.y; v < used.y + used.height; ++v) {
    const std::uint8_t* cover = mask_.ptr<std::uint8_t>(v);
    auto* row = pixels_.ptr<cv::Vec3b>(v);
    for (int u = used.x; u < used.x + used.width; ++u) {
      if (cover[u] == 0) continue;
      const double a = cover[u] / 255.0;
      for (int c = 0; c < 3; ++c)
        row[u][c] = cv::saturate_cast<std::uint8_t>((1.0 - a) * row[u][c] + a * bgr[c]);
    }
  }
}

void Canvas::picture(const cv::Mat& image, double x, double y, double w, double h, bool smooth) {
  const cv::Rect place = fineRectangle(x, y, w, h);
  const cv::Rect inside = place & cv::Rect(0, 0, pixels_.cols, pixels_.rows);
  if (inside.empty() || image.empty()) return;
  cv::Mat bgr, scaled;
  if (image.channels() == 1)
    cv::cvtColor(image, bgr, cv::COLOR_GRAY2BGR);
  else
    bgr = image;
  cv::resize(bgr, scaled, place.size(), 0, 0, smooth ? cv::INTER_CUBIC : cv::INTER_NEAREST);
  scaled(inside - place.tl()).copyTo(pixels_(inside));
}

void Canvas::line(const Polyline& points, Color color, double thickness, double alpha) {
  lines({points}, color, thickness, alpha);
}

void Canvas::lines(const std::vector<Polyline>& all, Color color, double thickness, double alpha) {
  shape(color, alpha, [&](cv::Mat& on, const cv::Scalar& value) {
    for (const Polyline& points : all)
      if (points.size() > 1)
        cv::polylines(on, fixedPoints(points), false, value, strokeWidth(thickness), cv::LINE_AA,
                      shift);
  });
}

void Canvas::dashedLine(const Polyline& points, Color color, double thickness, double dash,
                        double alpha) {
  std::vector<Polyline> dashes;
  double walked = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d step = points[i] - points[i - 1];
    const double length = step.norm();
    if (!(length > 0.0) || length > farthest) continue;
    for (double at = 0.0; at < length;) {
      const double phase = std::fmod(walked + at, 2.0 * dash);
      const double left = std::min(length - at, (phase < dash ? dash : 2.0 * dash) - phase + 1e-9);
      if (phase < dash)
        dashes.push_back(
            {points[i - 1] + step * (at / length), points[i - 1] + step * ((at + left) / length)});
      at += left;
    }
    walked += length;
  }
  lines(dashes, color, thickness, alpha);
}

void Canvas::fill(const std::vector<Polyline>& polygons, Color color, double alpha) {
  shape(color, alpha, [&](cv::Mat& on, const cv::Scalar& value) {
    for (const Polyline& polygon : polygons) {
      if (polygon.size() < 3) continue;
      const std::vector<std::vector<cv::Point>> one{fixedPoints(polygon)};
      cv::fillPoly(on, one, value, alpha < 1.0 ? cv::LINE_8 : cv::LINE_AA, shift);
    }
  });
}

cv::Rect Canvas::fineRectangle(double x, double y, double w, double h) const {
  const auto fine = [this](double value) {
    return static_cast<int>(std::lround(std::clamp(value, -farthest, farthest) * finer_));
  };
  const cv::Point corner(fine(x), fine(y));
  return {corner, cv::Point(fine(x + w), fine(y + h))};
}

void Canvas::rectangle(double x, double y, double w, double h, Color color, double alpha) {
  const cv::Rect place = fineRectangle(x, y, w, h);
  shape(color, alpha, [&](cv::Mat& on, const cv::Scalar& value) {
    cv::rectangle(on, place & cv::Rect({0, 0}, on.size()), value, cv::FILLED);
  });
}

void Canvas::disk(const Eigen::Vector2d& center, double radius, Color color, double alpha) {
  shape(color, alpha, [&](cv::Mat& on, const cv::Scalar& value) {
    cv::circle(on, fixedPoint(center),
               static_cast<int>(std::lround(radius * finer_ * (1 << shift))), value, cv::FILLED,
               cv::LINE_AA, shift);
  });
}

void Canvas::ring(const Eigen::Vector2d& center, double radius, Color color, double thickness) {
  cv::circle(pixels_, fixedPoint(center),
             static_cast<int>(std::lround(radius * finer_ * (1 << shift))), color.bgr(),
             strokeWidth(thickness), cv::LINE_AA, shift);
}

void Canvas::arrow(const Eigen::Vector2d& tail, double heading, double length, Color color,
                   double thickness) {
  const Eigen::Vector2d ahead(std::cos(heading), -std::sin(heading));
  const Eigen::Vector2d side(-ahead.y(), ahead.x());
  const Eigen::Vector2d tip = tail + length * ahead;
  const double head = std::max(0.45 * length, 2.5 * thickness);
  const Eigen::Vector2d neck = tip - head * ahead;
  line({tail, neck}, color, thickness);
  fill({{tip, neck + 0.5 * head * side, neck - 0.5 * head * side}}, color);
}

double Canvas::textWidth(const std::string& words, double size) {
  return cv::getTextSize(words, font, scaleOf(size) * 8.0, 1, nullptr).width / 8.0;
}

double Canvas::leftOf(const std::string& words, double x, double size, Anchor anchor) {
  const double width = textWidth(words, size);
  if (anchor == Anchor::Left) return x;
  return anchor == Anchor::Center ? x - 0.5 * width : x - width;
}

void Canvas::text(const std::string& words, const Eigen::Vector2d& at, double size, Color color,
                  Anchor anchor) {
  const cv::Point foot(static_cast<int>(std::lround(leftOf(words, at.x(), size, anchor) * finer_)),
                       static_cast<int>(std::lround(at.y() * finer_)));
  cv::putText(pixels_, words, foot, font, scaleOf(size) * finer_, color.bgr(),
              strokeWidth(size / 9.0), cv::LINE_AA);
}

void Canvas::textOnPicture(const std::string& words, const Eigen::Vector2d& at, double size,
                           Color color, Anchor anchor) {
  const double left = leftOf(words, at.x(), size, anchor), pad = 0.5 * size;
  rectangle(left - pad, at.y() - size - pad, textWidth(words, size) + 2.0 * pad, size + 2.0 * pad,
            {0x101418}, 0.55);
  text(words, at, size, color, anchor);
}

cv::Mat Canvas::finish() const {
  if (finer_ == 1) return pixels_.clone();
  cv::Mat shrunk;
  cv::resize(pixels_, shrunk, {width_, height_}, 0, 0, cv::INTER_AREA);
  return shrunk;
}

}  // namespace ipm_mapping
