#pragma once
// Sensor front end (the source, §7.4.2; rule 17): a serial bit stream of 12-bit packets to pixels
// with hsync and vsync, and back.

#include <array>
#include <cstdint>
#include <vector>

#include "ipm_mapping/image_view.hpp"

namespace ipm_mapping::fpga {

inline constexpr int packet_bits = 12;

/// One clock of the deserialised camera interface.
struct SensorSample {
  std::uint8_t pixel = 0;
  bool line_valid = false;   ///< hsync: high while a line's pixels pass
  bool frame_valid = false;  ///< vsync: high from a frame's first pixel to its last

  bool operator==(const SensorSample& o) const {
    return pixel == o.pixel && line_valid == o.line_valid && frame_valid == o.frame_valid;
  }
};

/// Bit 0 of the result is the first one on the line.
[[nodiscard]] std::uint16_t encodePacket(const SensorSample& sample);

enum class PacketFault : std::uint8_t {
  StartBit,          ///< start bit 0
  StopBit,           ///< stop bit 1
  LineWithoutFrame,  ///< line valid while the frame is not
  DataInBlanking,    ///< data bits in a blanking packet
  Truncated          ///< the stream ended within a packet
};
inline constexpr int packet_fault_count = 5;

struct PacketFaults {
  std::array<std::uint64_t, packet_fault_count> counts{};
  std::uint64_t& operator[](PacketFault fault) { return counts[static_cast<std::size_t>(fault)]; }
  std::uint64_t operator[](PacketFault fault) const {
    return counts[static_cast<std::size_t>(fault)];
  }
  [[nodiscard]] std::uint64_t total() const;
};

/// Finds packets in a bit stream. Well-framed packets with impossible content are dropped; after a
/// framing error the receiver slides bit by bit until `lock` packets in a row fit again.
class PacketReceiver {
 public:
  static constexpr int lock = 3;

  /// Takes one bit; true when `sample` holds a new, well-formed packet.
  bool push(bool bit, SensorSample& sample);
  /// The end of the stream: counts a packet that was cut off.
  void finish();
  [[nodiscard]] const PacketFaults& faults() const { return faults_; }

 private:
  bool accept(std::uint16_t packet, SensorSample& sample);
  void search(bool bit);

  std::uint64_t window_ = 0;  ///< newest bit highest
  int bits_ = 0;              ///< of the current packet, or collected while searching
  bool searching_ = false;
  PacketFaults faults_;
};

/// Pixels into frames. A line or frame of another size is dropped and counted.
class FrameAssembler {
 public:
  FrameAssembler(int width, int height) : frame_(width, height) {}

  /// True when the frame is complete.
  bool push(const SensorSample& sample);
  [[nodiscard]] GrayView frame() const { return frame_.view(); }
  [[nodiscard]] std::uint64_t badLines() const { return bad_lines_; }
  [[nodiscard]] std::uint64_t badFrames() const { return bad_frames_; }

 private:
  void endLine();
  bool endFrame();

  Image<std::uint8_t> frame_;
  int u_ = 0, v_ = 0;
  bool in_line_ = false, in_frame_ = false;
  std::uint64_t bad_lines_ = 0, bad_frames_ = 0;
};

/// A frame as samples: every row followed by line blanking, the last one by frame blanking.
[[nodiscard]] std::vector<SensorSample> sampleFrame(const GrayView& frame, int line_blanking,
                                                    int frame_blanking);
/// Samples as a bit stream, one byte a bit.
[[nodiscard]] std::vector<std::uint8_t> serialise(const std::vector<SensorSample>& samples);

}  // namespace ipm_mapping::fpga
