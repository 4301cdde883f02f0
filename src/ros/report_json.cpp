#include "ipm_mapping/ros/report_json.hpp"

#include <nlohmann/json.hpp>

#include "ipm_mapping/kernels/simd_target.hpp"
#include "ipm_mapping/parameters/visitors.hpp"

namespace ipm_mapping {
namespace {

using Json = nlohmann::ordered_json;

Json framesJson(const RunReport& report) {
  Json skipped = Json::object();
  for (int i = 0; i < frame_status_count; ++i) {
    const auto status = static_cast<FrameStatus>(i);
    const std::uint64_t n = report.frames[static_cast<std::size_t>(i)];
    if (status != FrameStatus::Used && n > 0) skipped[name(status)] = n;
  }
  for (int i = 0; i < gate_drop_count; ++i) {
    const std::uint64_t n = report.gate_drops[static_cast<std::size_t>(i)];
    if (n > 0) skipped[name(static_cast<GateDrop>(i))] = n;
  }
  if (report.unusable_images > 0) skipped["unusable_image"] = report.unusable_images;
  return {{"read", report.images}, {"used", report.used()}, {"skipped", skipped}};
}

Json stagesJson(const RunReport& report) {
  Json stages = Json::object();
  for (const auto& [stage, statistics] : report.stages)
    stages[stage] = {
        {"median_ms", 1e3 * statistics.median()},
        {"mean_ms", 1e3 * statistics.total() / static_cast<double>(statistics.samples.size())}};
  return stages;
}

Json cameraJson(const RunCamera& camera) {
  const Intrinsics& k = camera.model.intrinsics();
  const Distortion& d = camera.model.distortion();
  const Eigen::Vector3d t = camera.T_base_camera.translation();
  return {{"calibration_from", camera.calibration_source},
          {"pose_from", camera.pose_source},
          {"width", k.width},
          {"height", k.height},
          {"K", {k.fx, k.fy, k.cx, k.cy}},
          {"D", {d.k1, d.k2, d.p1, d.p2, d.k3}},
          {"position_in_base_m", {t.x(), t.y(), t.z()}},
          {"pitch_rad", pitchOf(camera.T_base_camera)}};
}

Json fpgaJson(const FpgaStatistics::Summary& s, double pixel_clock) {
  Json overflow = Json::object();
  for (std::size_t i = 0; i < fpga::wire_count; ++i) overflow[fpga::wire_names[i]] = s.overflow[i];
  return {
      {"frames", s.frames},
      {"fifo_words", s.points},
      {"homography_error_px",
       {{"median", s.median_homography_error}, {"worst", s.worst_homography_error}}},
      {"focus_clamped_frames", s.focus_clamped},
      {"overflow", overflow},
      {"pixel_clock_hz", pixel_clock},
      {"cycles",
       {{"to_first_contact", s.first_contact},
        {"of_frame", s.frame},
        {"after_last_pixel_slowest", s.after_last_pixel}}},
      {"frame_rate_hz", s.frame_rate},
      {"to_map_slowest_s", s.slowest_to_map},
      {"map_rate_slowest_hz",
       {{"in_series", s.slowest_map_rate_in_series}, {"pipelined", s.slowest_map_rate_pipelined}}}};
}

Json calibrationJson(const CalibrationReport& r) {
  const auto value = [](const CalibrationReport::Value& v) {
    return Json{{"stated", v.stated}, {"estimate", v.estimate}, {"sigma", v.sigma}};
  };
  return {{"pairs", r.pairs},
          {"believable", r.believable},
          {"applied", r.applied},
          {"pitch_rad", value(r.pitch)},
          {"roll_rad", value(r.roll)},
          {"yaw_rad", value(r.yaw)},
          {"height_m", value(r.height)},
          {"odometry_scale", value(r.scale)},
          {"odometry_turn_scale", value(r.turn_scale)},
          {"odometry_yaw_rate_rad_s", value(r.yaw_rate)},
          {"readout_s", value(r.readout)},
          {"time_offset_s", value(r.time_offset)},
          {"lens_shading", value(r.shading)},
          {"advice", advice(r)}};
}

template <class T>
Json valueJson(const T& value) {
  if constexpr (std::is_enum_v<T>)
    return parameter_detail::valueText(value);
  else
    return value;
}

Json parametersJson(const Parameters& parameters) {
  Json all = Json::object();
  Parameters::groups(parameters, [&all](const char* group, const auto& fields) {
    forEachField(fields, [&](const char* name, const auto& value, Unit, Range, const char*) {
      all[group][name] = valueJson(value);
    });
  });
  return all;
}

}  // namespace

std::string reportJson(const OfflineRun& run, const BagSource& bag, const RunCamera& camera,
                       const OfflineOptions& options, const std::string& profile,
                       const FpgaStatistics* fpga) {
  const RunReport& report = run.report();
  const MapGeometry& map = run.map().geometry();
  const double per_frame =
      report.used() > 0 ? report.processing_seconds / static_cast<double>(report.used()) : 0.0;
  Json json = {
      {"bag", options.bag},
      {"profile", profile},
      {"topics",
       {{"image", bag.topics().image},
        {"camera_info", bag.topics().camera_info},
        {"odometry", bag.topics().odometry}}},
      {"frames", framesJson(report)},
      {"odometry", report.odometry},
      {"resets", report.resets},
      {"points", report.contacts},
      {"map", {{"width", map.width}, {"height", map.height}, {"resolution_m", map.resolution}}},
      {"simd", kernels::simdTarget()},
      {"stages", stagesJson(report)},
      {"processing_ms_per_used_frame", 1e3 * per_frame},
      {"fps", per_frame > 0.0 ? 1.0 / per_frame : 0.0},
      {"wall_seconds", report.wall_seconds},
      {"camera", cameraJson(camera)},
      {"parameters", parametersJson(options.parameters)}};
  if (const auto calibration = run.detector().calibration())
    json["calibration"] = calibrationJson(*calibration);
  if (fpga != nullptr)
    json["fpga"] = fpgaJson(fpga->summary(), options.parameters.fpga_clock.pixel_clock);
  return json.dump(2) + "\n";
}

}  // namespace ipm_mapping
