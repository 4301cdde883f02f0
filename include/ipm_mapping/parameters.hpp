#pragma once
// Every tunable of the package, with default, unit and range: the only place of a default.
// The structs live in parameters/, one file a subject; field.hpp says how they describe themselves.

#include <string>
#include <vector>

#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"

namespace ipm_mapping {

enum class DetectorKind { Chain };
template <>
inline constexpr std::array<const char*, 1> enum_names<DetectorKind>{"chain"};

/// What finds the obstacles.
struct DetectorParameters {
  DetectorKind kind = DetectorKind::Chain;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("kind", self.kind, "chain: the source's difference, segmentation and localisation");
  }
};

/// One complete set.
struct Parameters {
  DetectorParameters detector;
  CameraParameters camera;
  OdometryParameters odometry;
  ReferenceParameters reference;
  SegmentationParameters segmentation;
  LocalizationParameters localization;
  MapParameters map;
  OutputParameters output;

  /// Calls `group(name, struct)` for every struct, in the order of the documentation.
  template <class Self, class Visitor>
  static void groups(Self& self, Visitor&& group) {
    group("detector", self.detector);
    group("camera", self.camera);
    group("odometry", self.odometry);
    group("reference", self.reference);
    group("segmentation", self.segmentation);
    group("localization", self.localization);
    group("map", self.map);
    group("output", self.output);
  }

  /// The profiles by name: `default` (our best) and `paper` (the source, its errors mended).
  /// Throws ParameterError for any other name.
  [[nodiscard]] static Parameters profile(const std::string& name);
  [[nodiscard]] static const std::vector<std::string>& profileNames();

  /// Throws ParameterError naming the first field outside its range, or the first contradiction.
  void validate() const;
};

}  // namespace ipm_mapping
