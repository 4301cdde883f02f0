#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace ipm_mapping {

/// A colour as 0xRRGGBB.
struct Color {
  unsigned rgb = 0;
  [[nodiscard]] cv::Scalar bgr() const {
    return {static_cast<double>(rgb & 0xFFU), static_cast<double>((rgb >> 8U) & 0xFFU),
            static_cast<double>((rgb >> 16U) & 0xFFU)};
  }
};

/// Points of a line or an outline, in pixels of the canvas.
using Polyline = std::vector<Eigen::Vector2d>;

/// A picture to draw people's views on: positions are real pixels, everything is antialiased, and
/// every shape may be translucent. `finer` draws larger and shrinks at the end, for print quality.
class Canvas {
 public:
  enum class Anchor { Left, Center, Right };

  Canvas(int width, int height, Color background, int finer = 1);

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  /// Fills the rectangle from (x, y) with the picture (BGR or grey), pixels as squares or smooth.
  void picture(const cv::Mat& image, double x, double y, double w, double h, bool smooth);
  void line(const Polyline& points, Color color, double thickness, double alpha = 1.0);
  /// All lines as one shape.
  void lines(const std::vector<Polyline>& all, Color color, double thickness, double alpha = 1.0);
  void dashedLine(const Polyline& points, Color color, double thickness, double dash,
                  double alpha = 1.0);
  /// All polygons as one shape: where they overlap they are not darker.
  void fill(const std::vector<Polyline>& polygons, Color color, double alpha = 1.0);
  void rectangle(double x, double y, double w, double h, Color color, double alpha = 1.0);
  void disk(const Eigen::Vector2d& center, double radius, Color color, double alpha = 1.0);
  void ring(const Eigen::Vector2d& center, double radius, Color color, double thickness);
  /// Arrow of `length` from `tail`; heading in radians, counter-clockwise from right.
  void arrow(const Eigen::Vector2d& tail, double heading, double length, Color color,
             double thickness);
  /// `size` is the height of capital letters; `at` is the foot of the text.
  void text(const std::string& words, const Eigen::Vector2d& at, double size, Color color,
            Anchor anchor = Anchor::Left);
  /// As text(), on a dark, translucent ground that keeps it readable on a picture.
  void textOnPicture(const std::string& words, const Eigen::Vector2d& at, double size, Color color,
                     Anchor anchor = Anchor::Left);
  [[nodiscard]] static double textWidth(const std::string& words, double size);

  /// The picture in BGR.
  [[nodiscard]] cv::Mat finish() const;

 private:
  [[nodiscard]] cv::Point fixedPoint(const Eigen::Vector2d& p) const;
  [[nodiscard]] std::vector<cv::Point> fixedPoints(const Polyline& points) const;
  [[nodiscard]] cv::Rect fineRectangle(double x, double y, double w, double h) const;
  [[nodiscard]] int strokeWidth(double thickness) const;
  [[nodiscard]] static double leftOf(const std::string& words, double x, double size,
                                     Anchor anchor);
  /// Draws opaquely, or, for alpha < 1, through a mask.
  template <class Draw>
  void shape(Color color, double alpha, Draw&& draw);

  int width_;
  int height_;
  int finer_;
  cv::Mat pixels_;
  cv::Mat mask_;
};

}  // namespace ipm_mapping
