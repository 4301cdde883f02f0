#pragma once
// The integers that one frame of the datapath is run with: params.txt of rule 18.

#include <cstdint>
#include <string>

#include "ipm_mapping/fpga/formats.hpp"
#include "ipm_mapping/image_view.hpp"
#include "ipm_mapping/parameters/field.hpp"

namespace ipm_mapping::fpga {

using Integer = std::int64_t;

/// Raw register values. The defaults of the registers are those of FpgaParameters; a frame's
/// geometry has none.
struct FrameParameters {
  Integer width = 0, height = 0;
  Integer h11 = 0, h12 = 0, h13 = 0, h21 = 0, h22 = 0, h23 = 0, h31 = 0, h32 = 0, h33 = 0;
  Integer horizon_a = 0, horizon_b = 0, horizon_c = 0, use_horizon = 1;
  Integer fx = 0, fy = 0, cx = 0, cy = 0, k1 = 0, k2 = 0, k3 = 0, r2_max = 0;
  Integer focus_u = 0, focus_v = 0;
  Integer threshold_in = 255, min_threshold = 0;
  Integer score_min = 0, min_height = 0, valley_threshold = 1, bearing_tolerance = 0;
  Integer undistort_current = 1, paper_order = 0;
  Integer method = 1;  ///< 0 score, 1 triangle
  Integer single_bin_peaks = 0, free_space_rule = 0;
  Integer memory_rows = 0;

  /// Visits every field as field(name, value, lowest, highest), in the order of params.txt. The
  /// limits are the width of the field's wire, or what its rule says.
  template <class Self, class Visitor>
  static void fields(Self& self, Visitor&& field);

  bool operator==(const FrameParameters& other) const;
};

/// One frame's inputs: a reference frame I_n, a current frame I_n+1 and the registers.
struct FrameInputs {
  GrayView reference;
  GrayView current;
  FrameParameters parameters;
};

/// Throws ParameterError naming the first field outside its wire (rules 3, 4, 9-14 and 18).
void validate(const FrameParameters& parameters);

/// Whether per-frame code may run: the sizes of rule 13 and of both frames, and a usable focus.
[[nodiscard]] bool runnable(const FrameInputs& inputs);

template <class Self, class Visitor>
void FrameParameters::fields(Self& self, Visitor&& field) {
  using Linear = formats::HomographyLinear;
  using Offset = formats::HomographyOffset;
  using Intrinsic = formats::CameraIntrinsic;
  using Lens = formats::LensCoefficient;
  using Focus = formats::FocusCoordinate;
  const auto wire = [&field](const char* name, auto& value, auto format) {
    field(name, value, Integer{format.lowest()}, Integer{format.highest()});
  };
  field("width", self.width, Integer{1}, Integer{max_width});
  field("height", self.height, Integer{1}, Integer{max_height});
  wire("h11", self.h11, Linear{});
  wire("h12", self.h12, Linear{});
  wire("h13", self.h13, Offset{});
  wire("h21", self.h21, Linear{});
  wire("h22", self.h22, Linear{});
  wire("h23", self.h23, Offset{});
  wire("h31", self.h31, Linear{});
  wire("h32", self.h32, Linear{});
  wire("h33", self.h33, Offset{});
  wire("horizon_a", self.horizon_a, Linear{});
  wire("horizon_b", self.horizon_b, Linear{});
  wire("horizon_c", self.horizon_c, Offset{});
  field("use_horizon", self.use_horizon, Integer{0}, Integer{1});
  field("fx", self.fx, Integer{1}, Integer{Intrinsic::highest()});
  field("fy", self.fy, Integer{1}, Integer{Intrinsic::highest()});
  wire("cx", self.cx, Intrinsic{});
  wire("cy", self.cy, Intrinsic{});
  wire("k1", self.k1, Lens{});
  wire("k2", self.k2, Lens{});
  wire("k3", self.k3, Lens{});
  wire("r2_max", self.r2_max, formats::RadiusSquared{});
  wire("focus_u", self.focus_u, Focus{});
  wire("focus_v", self.focus_v, Focus{});
  wire("threshold_in", self.threshold_in, formats::Pixel{});
  wire("min_threshold", self.min_threshold, formats::Pixel{});
  wire("score_min", self.score_min, formats::ContactHeight{});
  wire("min_height", self.min_height, formats::ContactHeight{});
  field("valley_threshold", self.valley_threshold, Integer{1},
        Integer{formats::ValleyThreshold::highest()});
  field("bearing_tolerance", self.bearing_tolerance, Integer{0}, Integer{line_count - 1});
  field("undistort_current", self.undistort_current, Integer{0}, Integer{1});
  field("paper_order", self.paper_order, Integer{0}, Integer{1});
  field("method", self.method, Integer{0}, Integer{1});
  field("single_bin_peaks", self.single_bin_peaks, Integer{0}, Integer{1});
  field("free_space_rule", self.free_space_rule, Integer{0}, Integer{1});
  const Integer width = self.width > 0 ? Integer{self.width} : Integer{1};
  field("memory_rows", self.memory_rows, Integer{self.height},
        (Integer{1} << address_bits) / width);
}

}  // namespace ipm_mapping::fpga
