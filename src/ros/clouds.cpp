#include "ipm_mapping/ros/clouds.hpp"

#include <sensor_msgs/PointCloud2.h>

#include <cmath>
#include <cstring>
#include <initializer_list>

namespace ipm_mapping {
namespace {

/// Appends float32 points to a message; fields and layout are there from the start.
class CloudWriter {
 public:
  CloudWriter(sensor_msgs::PointCloud2& cloud, std::initializer_list<const char*> fields)
      : cloud_(cloud) {
    cloud.fields.clear();
    for (const char* name : fields) addField(name);
    cloud.point_step = static_cast<std::uint32_t>(cloud.fields.size() * sizeof(float));
    cloud.is_bigendian = 0;
    cloud.is_dense = 1;
    cloud.height = 1;
    cloud.data.clear();
  }
  ~CloudWriter() {
    cloud_.width = static_cast<std::uint32_t>(cloud_.data.size() / cloud_.point_step);
    cloud_.row_step = static_cast<std::uint32_t>(cloud_.data.size());
  }
  CloudWriter(const CloudWriter&) = delete;
  CloudWriter& operator=(const CloudWriter&) = delete;

  void add(std::initializer_list<float> values) {
    const std::size_t end = cloud_.data.size();
    cloud_.data.resize(end + values.size() * sizeof(float));
    std::memcpy(cloud_.data.data() + end, values.begin(), values.size() * sizeof(float));
  }

 private:
  void addField(const char* name) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(cloud_.fields.size() * sizeof(float));
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    cloud_.fields.push_back(field);
  }

  sensor_msgs::PointCloud2& cloud_;
};

bool floorSeen(const Bearing& bearing) {
  return bearing.state != BearingState::Unknown && std::isfinite(bearing.range) &&
         std::isfinite(bearing.angle) && std::isfinite(bearing.near);
}

}  // namespace

void toContactCloud(const Obstacles& obstacles, const OutputParameters& parameters,
                    sensor_msgs::PointCloud2& cloud) {
  CloudWriter writer(cloud, {"x", "y", "z", "intensity"});
  const auto z = static_cast<float>(parameters.contact_z);
  for (const Contact& contact : obstacles.contacts)
    if (contact.p_base.allFinite())
      writer.add({contact.p_base.x(), contact.p_base.y(), z, contact.score});
}

void toFreeCloud(const Obstacles& obstacles, const OutputParameters& parameters,
                 sensor_msgs::PointCloud2& cloud) {
  CloudWriter writer(cloud, {"x", "y", "z"});
  const auto z = static_cast<float>(parameters.contact_z);
  const auto step = static_cast<float>(parameters.free_step);
  const Eigen::Vector2f foot = obstacles.view.cameraFoot().cast<float>();
  for (const Bearing& bearing : obstacles.bearings) {
    if (!floorSeen(bearing)) continue;
    const bool open = bearing.state == BearingState::Free;
    const float end = open ? bearing.range : bearing.range - step;
    const Eigen::Vector2f direction(std::cos(bearing.angle), std::sin(bearing.angle));
    for (int i = 1; bearing.near + step * static_cast<float>(i) <= end; ++i) {
      const Eigen::Vector2f p = foot + (bearing.near + step * static_cast<float>(i)) * direction;
      writer.add({p.x(), p.y(), z});
    }
  }
}

}  // namespace ipm_mapping
