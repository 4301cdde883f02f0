#pragma once
// What stands, lies, hangs and shines in a scene.
//
// Each struct lists its fields once; reading YAML, range checks and the scene's copy in the truth
// file are visitors of that list. Lengths in metres, angles in radians, reflectances and radiances
// linear in 0...1.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::sim {

using Point = Eigen::Vector2d;

enum class Grain { None, Speckle, Clouds, Wood, Fibre, Concrete, Marble };
enum class Pattern { None, Bands, Carton, Books };
enum class ObstacleKind { Box, Cylinder, Cone, Legs, Heap, Cable, Pallet, Shelf };
enum class PaintKind { Line, Patch, Disc };

/// Surface of anything that is not the floor.
struct Material {
  double albedo = 0.4;
  Grain grain = Grain::Speckle;
  double grain_contrast = 0.15;
  double grain_size = 0.5;
  Pattern pattern = Pattern::None;
  double pattern_albedo = 0.8;
  double pattern_period = 0.2;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("albedo", self.albedo, Unit{}, Range{0.0, 1.0}, "mean share of light sent back");
    field("grain", self.grain, "kind of texture");
    field("grain_contrast", self.grain_contrast, Unit{}, Range{0.0, 1.0}, "relative amplitude");
    field("grain_size", self.grain_size, Unit{"m"}, Range{0.01, 10.0}, "repeat of the texture");
    field("pattern", self.pattern, "regular markings over the texture");
    field("pattern_albedo", self.pattern_albedo, Unit{}, Range{0.0, 1.0}, "their reflectance");
    field("pattern_period", self.pattern_period, Unit{"m"}, Range{0.01, 10.0}, "their spacing");
  }
};

/// A place on a moving thing's way: it goes straight from one to the next, and stays where it is
/// before the first and after the last.
struct Waypoint {
  double at = 0.0, x = 0.0, y = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0};
    field("at", self.at, Unit{"s"}, Range{-1e5, 1e5}, "when it is there, after the first frame");
    field("x", self.x, Unit{"m"}, place, "how far it has gone from its x");
    field("y", self.y, Unit{"m"}, place, "how far it has gone from its y");
  }
};

/// How far a thing has gone along its way.
Point goneAlong(const std::vector<Waypoint>& way, double time);

/// Anything standing or lying on the floor; which lengths count depends on the kind.
struct ObstacleSpec {
  ObstacleKind kind = ObstacleKind::Box;
  std::string name;
  double x = 0.0, y = 0.0, z = 0.0, yaw = 0.0;
  double lx = 0.3, ly = 0.3, h = 0.3, r = 0.1, leg = 0.04, back = 0.0;
  std::vector<Point> points;
  std::vector<Waypoint> way;
  Material material;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0}, length{0.001, 50.0}, any{0.0, 50.0};
    field("kind", self.kind, "box, cylinder, cone, legs, heap, cable, pallet or shelf");
    field("name", self.name, "label in the truth file");
    field("x", self.x, Unit{"m"}, place, "centre, forward");
    field("y", self.y, Unit{"m"}, place, "centre, left");
    field("z", self.z, Unit{"m"}, any, "height of the underside; 0 stands on the floor");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "turn about the vertical");
    field("lx", self.lx, Unit{"m"}, length, "length along its own x");
    field("ly", self.ly, Unit{"m"}, length, "length along its own y");
    field("h", self.h, Unit{"m"}, length, "height");
    field("r", self.r, Unit{"m"}, length, "radius");
    field("leg", self.leg, Unit{"m"}, length, "side of a leg's square section");
    field("back", self.back, Unit{"m"}, any, "height of a chair's back above the seat");
    field("points", self.points, "course of a cable");
    field("way", self.way, "where it goes; none: it stands still");
    field("material", self.material, "surface");
  }
};

struct WallSpec {
  Point from = Point::Zero(), to = Point::UnitX();
  double height = 2.6, thickness = 0.12, skirting = 0.07;
  double skirting_albedo = 0.12;
  Material material{0.6, Grain::Clouds, 0.05, 2.0, Pattern::None, 0.8, 0.2};

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("from", self.from, "one end of the centre line");
    field("to", self.to, "the other end");
    field("height", self.height, Unit{"m"}, Range{0.01, 10.0}, "height");
    field("thickness", self.thickness, Unit{"m"}, Range{0.001, 5.0}, "thickness");
    field("skirting", self.skirting, Unit{"m"}, Range{0.0, 1.0}, "height of the skirting board");
    field("skirting_albedo", self.skirting_albedo, Unit{}, Range{0.0, 1.0}, "its reflectance");
    field("material", self.material, "surface");
  }
};

/// Floor covering laid in cells (tiles, boards); cell_x = 0 lays none.
struct FloorSpec {
  double albedo = 0.4;
  Grain grain = Grain::Speckle;
  double grain_contrast = 0.2, grain_size = 0.6;
  double blotch_contrast = 0.05, blotch_size = 3.0;
  double cell_x = 0.0, cell_y = 0.0, stagger = 0.0, yaw = 0.0;
  double gap = 0.004, gap_albedo = 0.12;
  double vary = 0.05;
  double tilt = 0.0;
  double reflection = 0.0, specular = 0.0, shininess = 60.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range share{0.0, 1.0};
    field("albedo", self.albedo, Unit{}, share, "mean share of light sent back");
    field("grain", self.grain, "kind of texture");
    field("grain_contrast", self.grain_contrast, Unit{}, share, "relative amplitude");
    field("grain_size", self.grain_size, Unit{"m"}, Range{0.01, 10.0}, "repeat of the texture");
    field("blotch_contrast", self.blotch_contrast, Unit{}, share, "wear and dirt, amplitude");
    field("blotch_size", self.blotch_size, Unit{"m"}, Range{0.1, 50.0}, "wear and dirt, repeat");
    field("cell_x", self.cell_x, Unit{"m"}, Range{0.0, 10.0}, "tile or board length; 0: no cells");
    field("cell_y", self.cell_y, Unit{"m"}, Range{0.0, 10.0}, "tile or board width");
    field("stagger", self.stagger, Unit{}, share, "random shift of each row, in cells");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "direction in which it is laid");
    field("gap", self.gap, Unit{"m"}, Range{0.0, 0.1}, "grout or joint");
    field("gap_albedo", self.gap_albedo, Unit{}, share, "its reflectance");
    field("vary", self.vary, Unit{}, share, "brightness difference from cell to cell");
    field("tilt", self.tilt, Unit{"rad"}, Range{0.0, 0.05}, "slope difference from cell to cell");
    field("reflection", self.reflection, Unit{}, share, "mirror share seen straight down");
    field("specular", self.specular, Unit{}, Range{0.0, 10.0}, "strength of the lamps' highlights");
    field("shininess", self.shininess, Unit{}, Range{1.0, 5000.0}, "exponent of the highlights");
  }
};

struct PaintSpec {
  PaintKind kind = PaintKind::Line;
  Point from = Point::Zero(), to = Point::UnitX();
  double width = 0.08, x = 0.0, y = 0.0, yaw = 0.0, lx = 0.3, ly = 0.3, r = 0.2;
  double albedo = 0.7, wear = 0.1;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    const Range place{-100.0, 100.0}, length{0.0, 100.0};
    field("kind", self.kind, "line, patch (rectangle) or disc");
    field("from", self.from, "start of a line");
    field("to", self.to, "end of a line");
    field("width", self.width, Unit{"m"}, length, "width of a line");
    field("x", self.x, Unit{"m"}, place, "centre of a patch or disc");
    field("y", self.y, Unit{"m"}, place, "centre of a patch or disc");
    field("yaw", self.yaw, Unit{"rad"}, Range{-7.0, 7.0}, "turn of a patch");
    field("lx", self.lx, Unit{"m"}, length, "length of a patch");
    field("ly", self.ly, Unit{"m"}, length, "width of a patch");
    field("r", self.r, Unit{"m"}, length, "radius of a disc");
    field("albedo", self.albedo, Unit{}, Range{0.0, 1.0}, "reflectance");
    field("wear", self.wear, Unit{}, Range{0.0, 1.0}, "share rubbed off");
  }
};

/// A lamp: a level square panel, or a point where size is 0.
struct LampSpec {
  Eigen::Vector3d at{0.0, 0.0, 2.5};
  double energy = 0.6, size = 0.0;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("at", self.at, "centre");
    field("energy", self.energy, Unit{}, Range{0.0, 100.0}, "light on the floor straight below");
    field("size", self.size, Unit{"m"}, Range{0.0, 5.0}, "side of the panel; 0 casts hard shadows");
  }
};

}  // namespace ipm_mapping::sim

namespace ipm_mapping {
template <>
inline constexpr std::array<const char*, 7> enum_names<sim::Grain>{
    "none", "speckle", "clouds", "wood", "fibre", "concrete", "marble"};
template <>
inline constexpr std::array<const char*, 4> enum_names<sim::Pattern>{"none", "bands", "carton",
                                                                     "books"};
template <>
inline constexpr std::array<const char*, 8> enum_names<sim::ObstacleKind>{
    "box", "cylinder", "cone", "legs", "heap", "cable", "pallet", "shelf"};
template <>
inline constexpr std::array<const char*, 3> enum_names<sim::PaintKind>{"line", "patch", "disc"};
}  // namespace ipm_mapping
