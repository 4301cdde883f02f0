#include "ipm_mapping/stages/contact_points.hpp"

#include <algorithm>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {

int windowSum(const std::uint8_t* row, int width, int u, int half_width) {
  const int first = std::max(u - half_width, 0), last = std::min(u + half_width, width - 1);
  int sum = 0;
  for (int i = first; i <= last; ++i) sum += row[i] == mask::obstacle;
  return sum;
}

/// State of one run of obstacle pixels: B, S, h and Sc of eq. 5.9-5.16.
struct ContactFinder::Triangle {
  TriangleContact contact;
  int previous;    ///< B: width that the next row may not exceed
  int smallest;    ///< smallest accepted width so far
  int pixels = 0;  ///< obstacle pixels on the line
  int gap = 0;     ///< background pixels since the last of them
  int lowest_row = -1;

  Triangle(int line, int widest) : previous(widest), smallest(widest) { contact.line = line; }

  void add(int a, int u, int v, const LocalizationParameters& parameters) {
    ++pixels;
    gap = 0;
    lowest_row = v;
    if (a > previous) {
      widened(parameters);
      return;
    }
    previous = a;
    contact.surface += a;
    ++contact.height;
    ++contact.score;
    if (!parameters.lowest_minimum || a <= smallest) {
      smallest = std::min(smallest, a);
      contact.u = u;
      contact.v = v;
    }
  }
  /// eq. 5.8 starts anew, eq. 5.16 takes a point off; both reset B to the widest window.
  void widened(const LocalizationParameters& parameters) {
    previous = 2 * parameters.window_half_width + 1;
    if (parameters.method == ContactMethod::Triangle) {
      --contact.score;
    } else {
      contact.score = contact.surface = contact.height = 0;
      smallest = previous;
    }
  }
  [[nodiscard]] bool convincing(const LocalizationParameters& parameters) const {
    return contact.height >= parameters.min_height && contact.score > parameters.score_min &&
           contact.surface > parameters.min_width * contact.height;
  }
};

void ContactFinder::close(Triangle& triangle, bool clipped,
                          const LocalizationParameters& parameters, LineContacts& result) {
  if (triangle.pixels > 0) {
    const bool contact =
        triangle.convincing(parameters) && (!clipped || parameters.clipped_contacts);
    if (contact) {
      result.nearest = static_cast<int>(contacts_.size());
      contacts_.push_back(triangle.contact);
    }
    if (!contact && triangle.pixels >= parameters.min_occupied_pixels)
      result.blocked_row = triangle.lowest_row;
  }
  triangle = Triangle(triangle.contact.line, 2 * parameters.window_half_width + 1);
}

void ContactFinder::follow(const PolarBeam& beam, int line, GrayView obstacle_mask,
                           const LocalizationParameters& parameters, LineContacts& result) {
  const std::int16_t* column = beam.columns(line);
  Triangle triangle(line, 2 * parameters.window_half_width + 1);
  const std::uint8_t* values = beam.values(line);
  for (int v = 0; v < beam.height(); ++v) {
    const std::uint8_t value = values[v];
    const int u = column[v];
    if (value == mask::obstacle) {
      triangle.add(
          windowSum(obstacle_mask.row(v), obstacle_mask.width, u, parameters.window_half_width), u,
          v, parameters);
    } else if (triangle.pixels > 0) {
      const bool clipped = value == mask::unseen;
      if (clipped || ++triangle.gap > parameters.max_gap)
        close(triangle, clipped, parameters, result);
    }
  }
  close(triangle, true, parameters, result);
}

void ContactFinder::find(const PolarBeam& beam, GrayView obstacle_mask,
                         const LocalizationParameters& parameters,
                         std::vector<LineContacts>& lines) {
  contacts_.clear();
  // As many as fit, so that no frame has to ask for memory: every triangle has its rows and the
  // gap that ends it.
  const int most = beam.height() / (parameters.min_height + 1) + 1;
  contacts_.reserve(static_cast<std::size_t>(beam.lines()) * static_cast<std::size_t>(most));
  lines.assign(static_cast<std::size_t>(beam.lines()), LineContacts{});
  for (int i = 0; i < beam.lines(); ++i)
    follow(beam, i, obstacle_mask, parameters, lines[static_cast<std::size_t>(i)]);
}

}  // namespace ipm_mapping
