#include "ipm_mapping/ros/fpga_messages.hpp"

#include <cmath>

#include "ipm_mapping/fpga/cycles.hpp"

namespace ipm_mapping {
namespace {

NamedInteger named(const char* name, std::int64_t value) {
  NamedInteger message;
  message.name = name;
  message.value = value;
  return message;
}

void fillRegisters(const fpga::FrameSetup& setup, FpgaReport& message) {
  fpga::FrameParameters::fields(setup.parameters,
                                [&](const char* name, const fpga::Integer& value, auto, auto) {
                                  message.registers.push_back(named(name, value));
                                });
  message.homography_error_px = setup.homography_error;
  message.focus_clamped = setup.focus_clamped;
}

void fillResults(const fpga::FrameSetup& setup, const fpga::Results& results, FpgaReport& message) {
  const auto threshold_in = static_cast<int>(setup.parameters.threshold_in);
  message.threshold_in = static_cast<std::uint8_t>(threshold_in);
  message.threshold_out = results.threshold_out;
  message.mask_threshold = static_cast<std::uint8_t>(
      fpga::maskThreshold(threshold_in, static_cast<int>(setup.parameters.min_threshold)));
  for (std::size_t i = 0; i < fpga::wire_count; ++i)
    message.overflow.push_back(
        named(fpga::wire_names[i], static_cast<std::int64_t>(results.overflow.counts()[i])));
}

void fillCycles(const fpga::FrameParameters& p, const fpga::Results& results,
                const FpgaClockParameters& clock, FpgaReport& message) {
  const auto activity = fpga::activityOf(results, static_cast<int>(p.min_height));
  message.peaks = static_cast<std::uint16_t>(activity.peaks);
  message.obstacles = static_cast<std::uint16_t>(activity.obstacles);
  message.points = static_cast<std::uint16_t>(activity.points);
  const int width = static_cast<int>(p.width), height = static_cast<int>(p.height);
  const auto timing = fpga::frameTiming(clock, width, height, activity);
  const fpga::StreamShape shape{width, height, clock.line_blanking, clock.frame_blanking};
  message.pixel_clock = clock.pixel_clock;
  message.cycles_to_first_contact = timing.first_contact;
  message.cycles_of_frame = shape.frame();
  message.cycles_to_last_point = shape.frame() + timing.after_last_pixel;
  message.cycles_to_map = std::llround(timing.to_map * clock.pixel_clock);
  message.otsu_hidden = timing.otsu_hidden;
  message.frame_rate = timing.frame_rate;
  message.map_rate_in_series = timing.map_rate_in_series;
  message.map_rate_pipelined = timing.map_rate_pipelined;
}

}  // namespace

void splitTagged(ImageView<const fpga::TaggedPixel> wire, GrayBuffer grey, GrayBuffer valid) {
  for (int v = 0; v < wire.height; ++v) {
    const fpga::TaggedPixel* in = wire.row(v);
    std::uint8_t* levels = grey.row(v);
    std::uint8_t* seen = valid.row(v);
    for (int u = 0; u < wire.width; ++u) {
      const bool tagged = (in[u] & fpga::no_correspondence) != 0;
      levels[u] = static_cast<std::uint8_t>(tagged ? 0 : in[u]);
      seen[u] = static_cast<std::uint8_t>(tagged ? 0 : 255);
    }
  }
}

void toMessage(const FpgaDetector& detector, const FpgaClockParameters& clock,
               FpgaReport& message) {
  const fpga::FrameSetup& setup = detector.frameSetup();
  message.registers.clear();
  message.overflow.clear();
  fillRegisters(setup, message);
  fillResults(setup, detector.results(), message);
  fillCycles(setup.parameters, detector.results(), clock, message);
}

}  // namespace ipm_mapping
