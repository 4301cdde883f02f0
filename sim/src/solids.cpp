#include "ipm_mapping_sim/solids.hpp"

#include <algorithm>
#include <cmath>

#include "ipm_mapping_sim/random.hpp"

namespace ipm_mapping::sim {
namespace {

using Box = Eigen::AlignedBox3d;
constexpr int kSegments = 48;

Box boxOf(double x0, double x1, double y0, double y1, double z0, double z1) {
  return {Eigen::Vector3d(x0, y0, z0), Eigen::Vector3d(x1, y1, z1)};
}

const char* kindName(ObstacleKind kind) {
  return enum_names<ObstacleKind>[static_cast<std::size_t>(kind)];
}

Placement placementOf(const ObstacleSpec& s) { return {s.x, s.y, s.z, s.yaw}; }

Footprint rectangle(const ObstacleSpec& s, double cx, double cy, double lx, double ly, double h) {
  const Placement at = placementOf(s);
  const double x = lx / 2, y = ly / 2;
  return {s.name,
          kindName(s.kind),
          h,
          true,
          {at(cx + x, cy + y), at(cx - x, cy + y), at(cx - x, cy - y), at(cx + x, cy - y)}};
}

void addBlock(const ObstacleSpec& s, double cx, double cy, double lx, double ly, double z0,
              double z1, Solid& out) {
  addBox(placementOf(s), boxOf(cx - lx / 2, cx + lx / 2, cy - ly / 2, cy + ly / 2, z0, z1),
         s.material, out.patches);
}

Solid makeBox(const ObstacleSpec& s) {
  Solid solid;
  addBlock(s, 0, 0, s.lx, s.ly, 0, s.h, solid);
  if (s.z == 0.0) solid.footprints.push_back(rectangle(s, 0, 0, s.lx, s.ly, s.h));
  return solid;
}

Solid makeCylinder(const ObstacleSpec& s) {
  const Placement at = placementOf(s);
  Solid solid;
  solid.patches.push_back(revolvedPatch(at, s.r, 0, s.r, s.h, kSegments, s.material));
  solid.patches.push_back(discPatch(at, s.r, s.h, kSegments, s.material));
  if (s.z > 0.0)
    solid.patches.push_back(discPatch(at, s.r, 0, kSegments, s.material, Facing::Down));
  else
    solid.footprints.push_back(
        {s.name, kindName(s.kind), s.h, true, circlePolygon(at, s.r, kSegments)});
  return solid;
}

/// A traffic cone: a square plate, which is what touches the floor, and a truncated cone on it.
Solid makeCone(const ObstacleSpec& s) {
  const Placement at = placementOf(s);
  const double plate = 0.025, side = 2.3 * s.r, tip = 0.18 * s.r;
  Solid solid;
  addBlock(s, 0, 0, side, side, 0, plate, solid);
  for (Patch& patch : solid.patches) patch.material.pattern = Pattern::None;
  solid.patches.push_back(revolvedPatch(at, s.r, plate, tip, s.h, kSegments, s.material));
  solid.patches.push_back(discPatch(at, tip, s.h, kSegments, s.material));
  solid.footprints.push_back(rectangle(s, 0, 0, side, side, s.h));
  return solid;
}

/// Table or chair: a slab on four legs, a chair's back rising from the legs at -x.
Solid makeLegs(const ObstacleSpec& s) {
  const double slab = 0.03, x = (s.lx - s.leg) / 2, y = (s.ly - s.leg) / 2;
  Solid solid;
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      addBlock(s, sx * x, sy * y, s.leg, s.leg, 0, s.h - slab, solid);
      solid.footprints.push_back(rectangle(s, sx * x, sy * y, s.leg, s.leg, s.h));
    }
  }
  addBlock(s, 0, 0, s.lx, s.ly, s.h - slab, s.h, solid);
  if (s.back > 0.0) {
    const double top = s.h + s.back;
    for (const double sy : {-1.0, 1.0}) addBlock(s, -x, sy * y, s.leg, s.leg, s.h, top, solid);
    addBlock(s, -x, 0, 0.6 * s.leg, s.ly - 2 * s.leg, top - 0.35 * s.back, top, solid);
  }
  return solid;
}

/// Smooth periodic bumps around and along a heap, about 1 in amplitude.
class HeapShape {
 public:
  explicit HeapShape(std::uint64_t seed) : random_(seed, Stream::Heap) {
    for (Wave& wave : waves_) {
      wave = {1.0 + std::floor(5.0 * random_.uniform()), 6.0 * random_.uniform(),
              6.3 * random_.uniform(), 0.35 + 0.3 * random_.uniform()};
    }
  }
  [[nodiscard]] double operator()(double angle, double rise) const {
    double sum = 0.0;
    for (const Wave& w : waves_)
      sum += w.size * std::sin(w.turns * angle + w.climb * rise + w.phase);
    return sum;
  }

 private:
  struct Wave {
    double turns = 0, climb = 0, phase = 0, size = 0;
  };
  RandomSequence random_;
  Wave waves_[5];
};

Patch heapPatch(const ObstacleSpec& s, std::uint64_t seed) {
  const Placement at = placementOf(s);
  const HeapShape bumps(seed);
  constexpr int rows = 20, cols = 65;
  Patch patch{rows, cols, {}, {}, {}, s.material};
  for (int i = 0; i < rows; ++i) {
    const double rise = static_cast<double>(i) / (rows - 1), swell = std::cos(0.5 * M_PI * rise);
    for (int j = 0; j < cols; ++j) {
      const double a = 2.0 * M_PI * (j % (cols - 1)) / (cols - 1);
      const double r = std::pow(swell, 0.7) * (1.0 + 0.1 * bumps(a, rise));
      const double z = s.h * std::sin(0.5 * M_PI * rise) * (1.0 + 0.06 * rise * bumps(a, 1.0));
      const double px = 0.5 * s.lx * r * std::cos(a), py = 0.5 * s.ly * r * std::sin(a);
      patch.points.push_back(at(px, py, i == rows - 1 ? s.h : z).cast<float>());
      patch.coords.emplace_back(0.5 * (s.lx + s.ly) * M_PI * j / (cols - 1) / 2.0, s.h * rise);
    }
  }
  return patch;
}

/// Normals of a grid from its neighbours, the seam between the last and the first column closed.
void smoothNormals(Patch& patch) {
  const int cols = patch.cols, around = cols - 1;
  const auto at = [&](int r, int c) {
    return patch.points[static_cast<std::size_t>(r * cols + c)];
  };
  patch.normals.clear();
  for (int r = 0; r < patch.rows; ++r) {
    const int up = std::min(r + 1, patch.rows - 1), down = std::max(r - 1, 0);
    for (int c = 0; c < cols; ++c) {
      const Eigen::Vector3f along = at(r, (c + 1) % around) - at(r, (c + around - 1) % around);
      const Eigen::Vector3f rise = at(up, c) - at(down, c);
      const Eigen::Vector3f normal = along.cross(rise);
      patch.normals.push_back(normal.norm() > 1e-9F ? normal.normalized()
                                                    : Eigen::Vector3f::UnitZ().eval());
    }
  }
}

Solid makeHeap(const ObstacleSpec& s, std::uint64_t seed) {
  Solid solid;
  Patch patch = heapPatch(s, seed);
  smoothNormals(patch);
  Footprint foot{s.name, kindName(s.kind), s.h, true, {}};
  for (int c = 0; c + 1 < patch.cols; ++c) {
    foot.points.emplace_back(patch.points[static_cast<std::size_t>(c)].head<2>().cast<double>());
  }
  solid.footprints.push_back(std::move(foot));
  solid.patches.push_back(std::move(patch));
  return solid;
}

/// A round tube of radius r lying on the floor along the points.
Solid makeCable(const ObstacleSpec& s) {
  constexpr int around = 8;
  const auto n = static_cast<int>(s.points.size());
  if (n < 2) throw ParameterError("scene: cable " + s.name + " needs at least two points");
  Patch patch{n, around + 1, {}, {}, {}, s.material};
  double length = 0.0;
  for (int i = 0; i < n; ++i) {
    const auto& p = s.points[static_cast<std::size_t>(i)];
    const Point before = s.points[static_cast<std::size_t>(std::max(i - 1, 0))];
    const Point after = s.points[static_cast<std::size_t>(std::min(i + 1, n - 1))];
    const Point ahead = (after - before).normalized();
    length += (p - before).norm();
    for (int j = 0; j <= around; ++j) {
      const double a = 2.0 * M_PI * (j % around) / around;
      const Eigen::Vector3d out(ahead.y() * std::cos(a), -ahead.x() * std::cos(a), std::sin(a));
      const Eigen::Vector3d centre(p.x(), p.y(), s.r);
      patch.points.push_back((centre + s.r * out).cast<float>());
      patch.normals.push_back(out.cast<float>());
      patch.coords.emplace_back(2.0 * M_PI * s.r * j / around, length);
    }
  }
  return {{patch}, {{s.name, kindName(s.kind), 2.0 * s.r, false, s.points}}};
}

/// Euro pallet: three skids, nine blocks, a deck of boards; the skids touch the floor.
Solid makePallet(const ObstacleSpec& s) {
  const double skid = 0.1, board = 0.022, h = s.h, y = (s.ly - skid) / 2;
  Solid solid;
  for (const double sy : {-1.0, 0.0, 1.0}) {
    addBlock(s, 0, sy * y, s.lx, skid, 0, board, solid);
    for (const double sx : {-1.0, 0.0, 1.0}) {
      addBlock(s, sx * (s.lx - skid * 1.4) / 2, sy * y, skid * 1.4, skid, board, h - board, solid);
    }
    solid.footprints.push_back(rectangle(s, 0, sy * y, s.lx, skid, h));
  }
  const int boards = 7;
  const double pitch = s.lx / boards;
  for (int i = 0; i < boards; ++i) {
    addBlock(s, (i + 0.5) * pitch - s.lx / 2, 0, 0.72 * pitch, s.ly, h - board, h, solid);
  }
  return solid;
}

/// Storage rack: four posts and boards at a third, two thirds and the top of its height.
Solid makeShelf(const ObstacleSpec& s) {
  const double x = (s.lx - s.leg) / 2, y = (s.ly - s.leg) / 2;
  Solid solid;
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      addBlock(s, sx * x, sy * y, s.leg, s.leg, 0, s.h, solid);
      solid.footprints.push_back(rectangle(s, sx * x, sy * y, s.leg, s.leg, s.h));
    }
  }
  for (const double z : {0.34, 0.67, 1.0}) {
    addBlock(s, 0, 0, s.lx, s.ly, z * s.h - 0.03, z * s.h, solid);
  }
  return solid;
}

Solid makeStill(const ObstacleSpec& spec, std::uint64_t seed) {
  switch (spec.kind) {
    case ObstacleKind::Box:
      return makeBox(spec);
    case ObstacleKind::Cylinder:
      return makeCylinder(spec);
    case ObstacleKind::Cone:
      return makeCone(spec);
    case ObstacleKind::Legs:
      return makeLegs(spec);
    case ObstacleKind::Heap:
      return makeHeap(spec, seed);
    case ObstacleKind::Cable:
      return makeCable(spec);
    case ObstacleKind::Pallet:
      return makePallet(spec);
    case ObstacleKind::Shelf:
      return makeShelf(spec);
  }
  return {};
}

void checkWay(const ObstacleSpec& spec) {
  const auto later = [](const Waypoint& a, const Waypoint& b) { return a.at >= b.at; };
  if (std::adjacent_find(spec.way.begin(), spec.way.end(), later) != spec.way.end())
    throw ParameterError("scene: the way of " + spec.name + " has to be in the order of time");
}

}  // namespace

Solid makeSolid(const ObstacleSpec& spec, std::uint64_t seed) {
  checkWay(spec);
  Solid solid = makeStill(spec, seed);
  solid.way = spec.way;
  for (Footprint& footprint : solid.footprints) footprint.way = spec.way;
  return solid;
}

Solid makeWall(const WallSpec& spec, const std::string& name) {
  const Point along = spec.to - spec.from;
  const Placement at{spec.from.x(), spec.from.y(), 0.0, std::atan2(along.y(), along.x())};
  const double length = along.norm(), half = spec.thickness / 2;
  const double proud = spec.skirting > 0.0 ? half + 0.012 : half;
  Solid solid;
  addBox(at, boxOf(0, length, -half, half, 0, spec.height), spec.material, solid.patches);
  if (spec.skirting > 0.0) {
    Material board = spec.material;
    board.albedo = spec.skirting_albedo;
    board.pattern = Pattern::None;
    addBox(at, boxOf(0, length, -proud, proud, 0, spec.skirting), board, solid.patches);
  }
  solid.footprints.push_back(
      {name,
       "wall",
       spec.height,
       true,
       {at(length, proud), at(0, proud), at(0, -proud), at(length, -proud)}});
  return solid;
}

std::vector<Solid> makeSolids(const Scene& scene) {
  std::vector<Solid> solids;
  const auto seed = static_cast<std::uint64_t>(scene.seed);
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    solids.push_back(makeSolid(scene.obstacles[i], hashOf(seed, i)));
  }
  for (std::size_t i = 0; i < scene.walls.size(); ++i) {
    solids.push_back(makeWall(scene.walls[i], "wall" + std::to_string(i)));
  }
  return solids;
}

std::vector<Footprint> footprintsOf(const std::vector<Solid>& solids) {
  std::vector<Footprint> all;
  for (const Solid& solid : solids) {
    all.insert(all.end(), solid.footprints.begin(), solid.footprints.end());
  }
  return all;
}

}  // namespace ipm_mapping::sim
