#pragma once
// Surfaces as grids of vertices: the one shape that every solid of a scene is made of.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "ipm_mapping_sim/scene.hpp"

namespace ipm_mapping::sim {

/// rows x cols vertices, row-major, with normals that point out of the solid and texture
/// coordinates in metres along the surface.
struct Patch {
  int rows = 0, cols = 0;
  std::vector<Eigen::Vector3f> points, normals;
  std::vector<Eigen::Vector2f> coords;
  Material material;

  [[nodiscard]] int triangleCount() const { return 2 * (rows - 1) * (cols - 1); }
  /// Vertex indices of triangle `prim`; two triangles a cell, counter-clockwise from outside.
  [[nodiscard]] Eigen::Vector3i triangle(int prim) const;
};

/// Lower things are no obstacles: paint, rugs, thin cables.
constexpr double kObstacleHeight = 0.015;

/// Outline on the floor of something that stands there: a closed polygon, or an open polyline.
struct Footprint {
  std::string name, kind;
  double height = 0.0;
  bool closed = true;
  std::vector<Point> points;
  std::vector<Waypoint> way{};
};

/// A solid: what the camera sees and what the truth says.
struct Solid {
  std::vector<Patch> patches;
  std::vector<Footprint> footprints;
  std::vector<Waypoint> way{};
};

/// Where a solid's own axes are in the world.
struct Placement {
  double x = 0.0, y = 0.0, z = 0.0, yaw = 0.0;
  [[nodiscard]] Eigen::Vector3d operator()(double px, double py, double pz) const;
  [[nodiscard]] Point operator()(double px, double py) const;
};

/// Rectangle from `corner` along edges u and v (out of the solid: u x v), with sharp edges.
Patch quadPatch(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
                const Material& material);

/// Box [x0, x1] x [y0, y1] x [z0, z1] in the placement's axes: six faces.
void addBox(const Placement& at, const Eigen::AlignedBox3d& box, const Material& material,
            std::vector<Patch>& out);

/// Side of a solid of revolution from radius r0 at z0 to r1 at z1 with `segments` flat sides;
/// the normals are smooth around the axis.
Patch revolvedPatch(const Placement& at, double r0, double z0, double r1, double z1, int segments,
                    const Material& material);

/// Disc of radius r at height z, facing up or down.
enum class Facing { Up, Down };
Patch discPatch(const Placement& at, double r, double z, int segments, const Material& material,
                Facing facing = Facing::Up);

/// Closed polygon with the vertices that revolvedPatch() has at radius r.
std::vector<Point> circlePolygon(const Placement& at, double r, int segments);

}  // namespace ipm_mapping::sim
