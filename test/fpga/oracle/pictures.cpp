#include <algorithm>
#include <cmath>

#include "generator.hpp"

namespace oracle {
namespace {

using Row = std::array<double, 3>;

size_t pixels(const Inputs& in) { return static_cast<size_t>(in.params.width * in.params.height); }

/// A vertical board at x, seen as [y0, y1] x [0, height] in reference base.
struct Board {
  double x, y0, y1, height;
  int grey;
};

struct World {
  uint64_t seed;
  int contrast;
  std::vector<Board> boards;
};

int floorGrey(const World& world, double x, double y) {
  const auto cell = [](double c) {
    return static_cast<uint64_t>(static_cast<int64_t>(std::floor(c / 0.02)));
  };
  uint64_t hash = cell(x) * 0x9e3779b97f4a7c15ULL ^ cell(y) * 0xc2b2ae3d27d4eb4fULL ^ world.seed;
  hash ^= hash >> 29;
  hash *= 0xbf58476d1ce4e5b9ULL;
  return 110 + static_cast<int>((hash >> 40) % static_cast<uint64_t>(world.contrast));
}

/// Grey of the ray from `eye` (on the floor plan) at `height` in `direction`.
int lookAt(const World& world, const Row& eye, double height, const Row& direction) {
  double nearest = 1e9;
  int grey = direction[2] < 0 ? -1 : 180;
  for (const Board& board : world.boards) {
    const double t = direction[0] == 0 ? -1 : (board.x - eye[0]) / direction[0];
    const double y = eye[1] + t * direction[1], z = height + t * direction[2];
    if (t <= 0 || t >= nearest || y < board.y0 || y > board.y1 || z < 0 || z > board.height)
      continue;
    nearest = t;
    grey = board.grey;
  }
  if (grey >= 0) return grey;
  const double t = -height / direction[2];
  return floorGrey(world, eye[0] + t * direction[0], eye[1] + t * direction[1]);
}

/// Raw pixel to the ideal pinhole's.
Row undistorted(const Camera& camera, int u, int v) {
  const auto fx = static_cast<double>(camera.fx), fy = static_cast<double>(camera.fy);
  const auto cx = static_cast<double>(camera.cx), cy = static_cast<double>(camera.cy);
  const auto k1 = static_cast<double>(camera.k1), k2 = static_cast<double>(camera.k2);
  const double xd = (u - cx) / fx, yd = (v - cy) / fy;
  double x = xd, y = yd;
  for (int n = 0; n < 4; ++n) {
    const double r2 = x * x + y * y, factor = std::max(0.2, 1 + r2 * (k1 + r2 * k2));
    x = xd / factor;
    y = yd / factor;
  }
  return {x * fx + cx, y * fy + cy, 1};
}

void renderView(const World& world, const Camera& camera, const Matrix& to_floor, const Row& eye,
                double height, std::vector<uint8_t>& image) {
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Row p = undistorted(camera, u, v);
      Row q{};
      for (size_t i = 0; i < 3; ++i) {
        q[i] = static_cast<double>(to_floor[i][0]) * p[0] +
               static_cast<double>(to_floor[i][1]) * p[1] + static_cast<double>(to_floor[i][2]);
      }
      const Row direction{q[0] - eye[0] * q[2], q[1] - eye[1] * q[2], -height * q[2]};
      image.push_back(static_cast<uint8_t>(lookAt(world, eye, height, direction)));
    }
  }
}

}  // namespace

void fillFlat(Inputs& in, int reference, int current) {
  in.reference.assign(pixels(in), static_cast<uint8_t>(reference));
  in.current.assign(pixels(in), static_cast<uint8_t>(current));
}

void fillNoise(Inputs& in, Random& random) {
  const int spread = random.pick({2, 10, 60, 256});
  const int lit = random.pick({5, 50, 90, 98, 100});
  fillFlat(in, 0, 0);
  for (uint8_t& pixel : in.reference) pixel = static_cast<uint8_t>(random.in(0, spread - 1));
  for (uint8_t& pixel : in.current) {
    pixel = static_cast<uint8_t>(random.chance(lit) ? random.in(0, 255) : random.in(0, spread - 1));
  }
}

void renderScene(Inputs& in, const Camera& camera, const Motion& motion, Random& random) {
  World world{static_cast<uint64_t>(random.in(0, 1 << 30)), random.pick({3, 10, 40}), {}};
  for (int n = random.in(0, 6); n > 0; --n) {
    const auto x = static_cast<double>(random.real(0.4L, 2.5L));
    const auto y = static_cast<double>(random.real(-0.8L, 0.7L));
    const auto width = static_cast<double>(random.real(0.03L, 0.4L));
    const auto height = static_cast<double>(random.real(0.05L, 0.8L));
    world.boards.push_back(Board{x, y, y + width, height, random.pick({20, 60, 220, 255})});
  }
  const TwoViews views = twoViews(camera, motion);
  const auto height = static_cast<double>(motion.height);
  const Row reference_eye{static_cast<double>(motion.lead), 0, 0};
  const Row current_eye{static_cast<double>(motion.x + motion.lead * std::cos(motion.angle)),
                        static_cast<double>(motion.y + motion.lead * std::sin(motion.angle)), 0};
  in.reference.clear();
  in.current.clear();
  renderView(world, camera, inverse(views.floor_to_reference), reference_eye, height, in.reference);
  renderView(world, camera, inverse(views.floor_to_current), current_eye, height, in.current);
}

void draw(Inputs& in, const Stroke& stroke, int grey, Random& random) {
  const Params& p = in.params;
  const double u0 = 8 * stroke.line + 4;
  const double slope = (p.focus_u - u0) / p.focus_v;
  const int rows = std::max(1, stroke.last - stroke.first);
  for (int v = std::max(0, stroke.first); v <= std::min(stroke.last, p.height - 1); ++v) {
    const double along = static_cast<double>(v - stroke.first) / rows;
    int width =
        static_cast<int>(stroke.top_width + (stroke.bottom_width - stroke.top_width) * along);
    width += random.in(-stroke.jitter, stroke.jitter);
    const int middle = static_cast<int>(std::lround(u0 + std::clamp(slope, -1.0, 1.0) * v));
    for (int u = middle - width / 2; u < middle - width / 2 + width; ++u) {
      if (u >= 0 && u < p.width)
        in.current[static_cast<size_t>(v * p.width + u)] = static_cast<uint8_t>(grey);
    }
  }
}

}  // namespace oracle
