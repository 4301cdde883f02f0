#include "ipm_mapping/ros/camera_info.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "ipm_mapping/ros/sentence.hpp"

namespace ipm_mapping {
namespace {

/// One axis of the sensor as the driver cuts and bins it.
struct Axis {
  std::uint32_t size, offset, region, binning;

  [[nodiscard]] std::uint32_t cut() const { return region == 0 ? size - offset : region; }
  [[nodiscard]] bool fits() const {
    return offset < size && std::uint64_t{offset} + cut() <= size && cut() >= step();
  }
  [[nodiscard]] std::uint32_t step() const { return std::max(binning, 1U); }
  [[nodiscard]] int pixels() const { return static_cast<int>(cut() / step()); }
  [[nodiscard]] double focal(double f) const { return f / step(); }
  [[nodiscard]] double centre(double c) const {
    return step() == 1 ? c - offset : (c - offset + 0.5) / step() - 0.5;
  }
};

template <class Array>
void readNumbers(const YAML::Node& node, Array& numbers) {
  const auto values = (node.IsMap() ? node["data"] : node).as<std::vector<double>>();
  if (values.size() != numbers.size()) throw YAML::Exception(node.Mark(), "wrong count of numbers");
  std::copy(values.begin(), values.end(), numbers.begin());
}

/// The first of two names that the file has; an empty node with the first name's error otherwise.
YAML::Node either(const YAML::Node& file, const char* first, const char* second) {
  if (file[first]) return file[first];
  if (file[second]) return file[second];
  throw YAML::Exception(file.Mark(), std::string("neither '") + first + "' nor '" + second + "'");
}

void readInfo(const YAML::Node& file, sensor_msgs::CameraInfo& info) {
  info.width = either(file, "image_width", "width").as<std::uint32_t>();
  info.height = either(file, "image_height", "height").as<std::uint32_t>();
  readNumbers(either(file, "camera_matrix", "K"), info.K);
  info.distortion_model =
      file["distortion_model"] ? file["distortion_model"].as<std::string>() : "plumb_bob";
  const YAML::Node d = either(file, "distortion_coefficients", "D");
  info.D = (d.IsMap() ? d["data"] : d).as<std::vector<double>>();
}

}  // namespace

Refusal toCamera(const sensor_msgs::CameraInfo& info, CameraModel& camera) {
  const Axis u{info.width, info.roi.x_offset, info.roi.width, info.binning_x};
  const Axis v{info.height, info.roi.y_offset, info.roi.height, info.binning_y};
  const bool sized = info.width > 0 && info.height > 0;
  if (sized && !(u.fits() && v.fits()))
    return sentence("camera_info: roi ", info.roi.width, "x", info.roi.height, " at (",
                    info.roi.x_offset, ", ", info.roi.y_offset, ") with binning ", u.step(), "x",
                    v.step(), " does not fit into ", info.width, "x", info.height);
  Intrinsics k{sized ? u.pixels() : static_cast<int>(info.width),
               sized ? v.pixels() : static_cast<int>(info.height),
               u.focal(info.K[0]),
               v.focal(info.K[4]),
               u.centre(info.K[2]),
               v.centre(info.K[5])};
  if (auto error = CameraModel::check(k, info.distortion_model, info.D))
    return "camera_info: " + *error;
  if (info.K[1] != 0.0)
    return sentence("camera_info: K[1] = ", info.K[1], ": skew is not supported");
  camera = CameraModel(k, CameraModel::distortionFrom(info.D));
  return std::nullopt;
}

Refusal checkSize(const CameraModel& camera, int width, int height) {
  if (camera.width() == width && camera.height() == height) return std::nullopt;
  return sentence("image is ", width, "x", height, ", but camera_info describes ", camera.width(),
                  "x", camera.height());
}

Refusal readCalibrationFile(const std::string& path, sensor_msgs::CameraInfo& info) {
  try {
    readInfo(YAML::LoadFile(path), info);
  } catch (const YAML::BadFile&) {
    return sentence("calibration file '", path, "' cannot be opened");
  } catch (const std::exception& error) {
    return sentence("calibration file '", path, "': ", error.what());
  }
  return std::nullopt;
}

}  // namespace ipm_mapping
