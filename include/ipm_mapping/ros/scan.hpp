#pragma once

#include <sensor_msgs/LaserScan.h>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"

namespace ipm_mapping {

/// The bearings as the scan of a laser that sits at the origin of the base frame (header is the
/// caller's). A uniform grid of angles, as many as there are bearings, each cell taking every
/// bearing that reaches into it:
///
/// - the nearest contact in front of range_max is its range;
/// - +Inf (REP-117: nothing up to range_max) where every bearing saw floor that far, to two rows of
///   the picture;
/// - NaN elsewhere: partly seen, blocked by something whose foot is out of view, or unknown. The
///   partly seen floor is in the `free` cloud.
///
/// Never 0 and never range_max, which consumers read in different ways. The base frame rather than
/// one at the camera's foot: every consumer knows it, and nothing has to be added to tf.
void toScan(const Obstacles& obstacles, const OutputParameters& parameters,
            sensor_msgs::LaserScan& scan);

}  // namespace ipm_mapping
