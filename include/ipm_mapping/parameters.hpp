#pragma once
// Every tunable of the package, with default, unit and range: the only place of a default.
// The structs live in parameters/, one file a subject; field.hpp says how they describe themselves.

#include <string>
#include <vector>

#include "ipm_mapping/parameters/birds_eye_parameters.hpp"
#include "ipm_mapping/parameters/calibration_parameters.hpp"
#include "ipm_mapping/parameters/chain_parameters.hpp"
#include "ipm_mapping/parameters/floor_odometry_parameters.hpp"
#include "ipm_mapping/parameters/fpga_parameters.hpp"
#include "ipm_mapping/parameters/map_parameters.hpp"
#include "ipm_mapping/parameters/memory_parameters.hpp"
#include "ipm_mapping/parameters/robot_parameters.hpp"
#include "ipm_mapping/parameters/sweep_parameters.hpp"

namespace ipm_mapping {

enum class DetectorKind { Sweep, Chain, FirstArchitecture, Fpga };
template <>
inline constexpr std::array<const char*, 4> enum_names<DetectorKind>{"sweep", "chain",
                                                                     "first_architecture", "fpga"};

/// What finds the obstacles.
struct DetectorParameters {
  DetectorKind kind = DetectorKind::Sweep;

  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field) {
    field("kind", self.kind,
          "sweep: our own, floor against vertical line; chain: the source's difference, "
          "segmentation and localisation; first_architecture: the "
          "same with a bird's-eye view and radial histograms; fpga: the bit-true model");
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
  BirdsEyeParameters birds_eye;
  sweep::SweepParameters sweep;
  CalibrationParameters calibration;
  FloorOdometryParameters floor_odometry;
  FpgaParameters fpga;
  FpgaClockParameters fpga_clock;
  MemoryParameters memory;
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
    group("birds_eye", self.birds_eye);
    group("sweep", self.sweep);
    group("calibration", self.calibration);
    group("floor_odometry", self.floor_odometry);
    group("fpga", self.fpga);
    group("fpga_clock", self.fpga_clock);
    group("memory", self.memory);
    group("map", self.map);
    group("output", self.output);
  }

  /// The profiles by name: `default` (our best), `paper` (the source, its errors mended) and
  /// `first_architecture` (the same with the bird's-eye view of §3.5).
  /// Throws ParameterError for any other name.
  [[nodiscard]] static Parameters profile(const std::string& name);
  [[nodiscard]] static const std::vector<std::string>& profileNames();

  /// Sets one field from text, as in set("map/resolution", "0.1"); throws ParameterError for an
  /// unknown name or a value that is not of the field's type.
  void set(const std::string& group_and_field, const std::string& text);

  /// Throws ParameterError naming the first field outside its range, or the first contradiction.
  void validate() const;
};

}  // namespace ipm_mapping
