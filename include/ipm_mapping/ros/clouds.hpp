#pragma once

#include <sensor_msgs/PointCloud2.h>

#include "ipm_mapping/obstacles.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"

namespace ipm_mapping {

/// Selected contacts as points x y z intensity (float32) in the base frame; z is `contact_z`,
/// intensity the contact's score. The fields are there even when there is no point. The header is
/// the caller's.
void toContactCloud(const Obstacles& obstacles, const OutputParameters& parameters,
                    sensor_msgs::PointCloud2& cloud);

/// Points x y z every `free_step` along the part of each bearing over which floor was seen, for
/// consumers that clear the line of sight to them and mark nothing. A step is kept from whatever
/// ends the free floor.
void toFreeCloud(const Obstacles& obstacles, const OutputParameters& parameters,
                 sensor_msgs::PointCloud2& cloud);

}  // namespace ipm_mapping
