#pragma once
// What each kind of obstacle looks like and where it touches the floor.

#include "ipm_mapping_sim/patch.hpp"

namespace ipm_mapping::sim {

/// The solid of one obstacle; `seed` shapes heaps.
Solid makeSolid(const ObstacleSpec& spec, std::uint64_t seed);

/// A wall with its skirting boards on both sides.
Solid makeWall(const WallSpec& spec, const std::string& name);

/// All obstacles and walls of a scene, in the order of the scene.
std::vector<Solid> makeSolids(const Scene& scene);

/// Floor outlines of a list of solids, in order.
std::vector<Footprint> footprintsOf(const std::vector<Solid>& solids);

}  // namespace ipm_mapping::sim
