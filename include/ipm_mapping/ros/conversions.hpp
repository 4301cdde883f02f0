#pragma once
// Messages to core types and back. Nothing here throws: what cannot be used is refused with one
// sentence that names the field.

#include "ipm_mapping/ros/camera_info.hpp"
#include "ipm_mapping/ros/clouds.hpp"
#include "ipm_mapping/ros/images.hpp"
#include "ipm_mapping/ros/scan.hpp"
#include "ipm_mapping/ros/stage_messages.hpp"
