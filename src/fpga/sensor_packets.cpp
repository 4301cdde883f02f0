#include "ipm_mapping/fpga/sensor_packets.hpp"

#include <numeric>

namespace ipm_mapping::fpga {
namespace {

constexpr int start_bit = 0, first_data_bit = 1, line_bit = 9, frame_bit = 10, stop_bit = 11;
constexpr std::uint64_t packet_mask = (1U << packet_bits) - 1;
constexpr int search_bits = PacketReceiver::lock * packet_bits;

bool bitOf(std::uint64_t bits, int index) { return (bits >> index & 1) != 0; }

bool framed(std::uint64_t packet) { return bitOf(packet, start_bit) && !bitOf(packet, stop_bit); }

SensorSample decode(std::uint64_t packet) {
  return {static_cast<std::uint8_t>(packet >> first_data_bit & 0xff), bitOf(packet, line_bit),
          bitOf(packet, frame_bit)};
}

bool possible(std::uint64_t packet) {
  const SensorSample s = decode(packet);
  return framed(packet) && (!s.line_valid || s.frame_valid) && (s.line_valid || s.pixel == 0);
}

}  // namespace

std::uint16_t encodePacket(const SensorSample& sample) {
  return static_cast<std::uint16_t>(1U << start_bit | unsigned{sample.pixel} << first_data_bit |
                                    unsigned{sample.line_valid} << line_bit |
                                    unsigned{sample.frame_valid} << frame_bit);
}

std::uint64_t PacketFaults::total() const {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

bool PacketReceiver::push(bool bit, SensorSample& sample) {
  if (searching_) {
    search(bit);
    return false;
  }
  window_ |= std::uint64_t{bit} << bits_;
  if (++bits_ < packet_bits) return false;
  const auto packet = static_cast<std::uint16_t>(window_);
  if (framed(packet)) {
    window_ = 0;
    bits_ = 0;
    return accept(packet, sample);
  }
  ++faults_[bitOf(packet, start_bit) ? PacketFault::StopBit : PacketFault::StartBit];
  searching_ = true;
  return false;
}

bool PacketReceiver::accept(std::uint16_t packet, SensorSample& sample) {
  sample = decode(packet);
  if (possible(packet)) return true;
  ++faults_[sample.line_valid ? PacketFault::LineWithoutFrame : PacketFault::DataInBlanking];
  return false;
}

/// Slides over the stream until several possible packets follow each other; they serve as the
/// proof and are lost.
void PacketReceiver::search(bool bit) {
  if (bits_ == search_bits) {
    window_ >>= 1;
    --bits_;
  }
  window_ |= std::uint64_t{bit} << bits_;
  if (++bits_ < search_bits) return;
  for (int packet = 0; packet < lock; ++packet) {
    if (!possible(window_ >> (packet * packet_bits) & packet_mask)) return;
  }
  searching_ = false;
  window_ = 0;
  bits_ = 0;
}

void PacketReceiver::finish() {
  if (!searching_ && bits_ > 0) ++faults_[PacketFault::Truncated];
  searching_ = false;
  window_ = 0;
  bits_ = 0;
}

bool FrameAssembler::push(const SensorSample& sample) {
  if (in_line_ && !sample.line_valid) endLine();
  const bool complete = in_frame_ && !sample.frame_valid && endFrame();
  in_line_ = sample.line_valid;
  in_frame_ = sample.frame_valid;
  if (!sample.line_valid) return complete;
  if (u_ < frame_.width() && v_ < frame_.height()) frame_.at(u_, v_) = sample.pixel;
  ++u_;
  return false;
}

void FrameAssembler::endLine() {
  if (u_ != frame_.width()) {
    ++bad_lines_;
  } else {
    ++v_;
  }
  u_ = 0;
}

bool FrameAssembler::endFrame() {
  const bool complete = v_ == frame_.height();
  if (!complete) ++bad_frames_;
  v_ = 0;
  return complete;
}

std::vector<SensorSample> sampleFrame(const GrayView& frame, int line_blanking,
                                      int frame_blanking) {
  std::vector<SensorSample> samples;
  for (int v = 0; v < frame.height; ++v) {
    for (int u = 0; u < frame.width; ++u) samples.push_back({frame.at(u, v), true, true});
    const bool last = v == frame.height - 1;
    if (!last)
      samples.insert(samples.end(), static_cast<std::size_t>(line_blanking), {0, false, true});
  }
  samples.insert(samples.end(), static_cast<std::size_t>(frame_blanking), {0, false, false});
  return samples;
}

std::vector<std::uint8_t> serialise(const std::vector<SensorSample>& samples) {
  std::vector<std::uint8_t> bits;
  bits.reserve(samples.size() * packet_bits);
  for (const SensorSample& sample : samples) {
    const std::uint16_t packet = encodePacket(sample);
    for (int i = 0; i < packet_bits; ++i) bits.push_back(bitOf(packet, i) ? 1 : 0);
  }
  return bits;
}

}  // namespace ipm_mapping::fpga
