#include "ipm_mapping/view/side_by_side.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ipm_mapping/view/canvas.hpp"

namespace ipm_mapping {
namespace {

constexpr Color ground{0x151C23}, words{0xFFFFFF}, ring_color{0x2FBF71}, disk_color{0xE040C0};

/// Lengths as shares of a panel's height.
constexpr double caption_share = 0.08, text_share = 0.036, gap_share = 0.02;

std::uint8_t scaled(int difference, int gain) {
  return static_cast<std::uint8_t>(std::min(255, difference * gain));
}

}  // namespace

cv::Mat sideBySide(const std::vector<Panel>& panels) {
  if (panels.empty()) return {};
  const double height = panels.front().picture.rows;
  const double gap = gap_share * height, caption = caption_share * height;
  double width = gap * static_cast<double>(panels.size() - 1);
  for (const Panel& panel : panels) width += panel.picture.cols;
  Canvas canvas(static_cast<int>(std::ceil(width)), static_cast<int>(std::ceil(height + caption)),
                ground);
  double x = 0.0;
  for (const Panel& panel : panels) {
    const double text = std::min(text_share * height,
                                 text_share * height * panel.picture.cols /
                                     Canvas::textWidth(panel.caption, text_share * height) * 0.96);
    canvas.picture(panel.picture, x, caption, panel.picture.cols, height, false);
    canvas.text(panel.caption, {x + gap, 0.5 * (caption + text)}, text, words);
    x += panel.picture.cols + gap;
  }
  return canvas.finish();
}

cv::Mat amplified(GrayView picture, int gain) {
  cv::Mat out(picture.height, picture.width, CV_8UC1);
  for (int v = 0; v < picture.height; ++v)
    std::transform(picture.row(v), picture.row(v) + picture.width, out.ptr(v),
                   [gain](std::uint8_t grey) { return scaled(grey, gain); });
  return out;
}

cv::Mat differenceOf(GrayView a, GrayView b, int gain) {
  cv::Mat out(a.height, a.width, CV_8UC3);
  for (int v = 0; v < a.height; ++v)
    for (int u = 0; u < a.width; ++u) {
      const int more = a.at(u, v) - b.at(u, v);
      const std::uint8_t only_a = scaled(std::max(more, 0), gain);
      const std::uint8_t only_b = scaled(std::max(-more, 0), gain);
      out.at<cv::Vec3b>(v, u) = {only_b, only_a, only_b};
    }
  return out;
}

void markContacts(const std::vector<Contact>& contacts, ContactMark mark, double radius,
                  cv::Mat& picture) {
  Canvas canvas(picture.cols, picture.rows, ground);
  canvas.picture(picture, 0, 0, picture.cols, picture.rows, false);
  for (const Contact& contact : contacts) {
    const Eigen::Vector2d at(contact.u, contact.v);
    if (mark == ContactMark::Ring)
      canvas.ring(at, radius, ring_color, 0.3 * radius);
    else
      canvas.disk(at, 0.5 * radius, disk_color);
  }
  picture = canvas.finish();
}

}  // namespace ipm_mapping
