// Rules 16 and 17: what comes in from the sensor and what goes out to the processor.
#include <gtest/gtest.h>

#include <sstream>

#include "fpga/support.hpp"
#include "ipm_mapping/fpga/fifo.hpp"
#include "ipm_mapping/fpga/sensor_packets.hpp"

namespace ipm_mapping::fpga {
namespace {

struct Received {
  std::vector<SensorSample> samples;
  PacketFaults faults;
};

Received receive(const std::vector<std::uint8_t>& bits) {
  PacketReceiver receiver;
  Received out;
  SensorSample sample;
  for (const std::uint8_t bit : bits) {
    if (receiver.push(bit != 0, sample)) out.samples.push_back(sample);
  }
  receiver.finish();
  out.faults = receiver.faults();
  return out;
}

std::vector<std::uint8_t> bitsOf(std::initializer_list<int> bits) {
  return {bits.begin(), bits.end()};
}

TEST(SensorPackets, BitsStandOnTheLineInTheStatedOrder) {
  // start, data LSB first, line, frame, stop
  EXPECT_EQ(serialise({{0x05, true, true}}), bitsOf({1, 1, 0, 1, 0, 0, 0, 0, 0, 1, 1, 0}));
  EXPECT_EQ(serialise({{0, false, true}}), bitsOf({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}));
  EXPECT_EQ(serialise({{0, false, false}}), bitsOf({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(SensorPackets, AFrameSurvivesTheLine) {
  test::Generator random(51);
  Image<std::uint8_t> frame;
  test::paintFrame(frame, 40, 30, random);
  std::vector<SensorSample> samples = sampleFrame(frame.view(), 7, 11);
  const auto second = sampleFrame(frame.view(), 7, 11);
  samples.insert(samples.end(), second.begin(), second.end());
  const Received received = receive(serialise(samples));
  EXPECT_EQ(received.faults.total(), 0U);
  ASSERT_EQ(received.samples, samples);
  FrameAssembler assembler(40, 30);
  int frames = 0;
  for (const SensorSample& sample : received.samples) {
    if (!assembler.push(sample)) continue;
    ++frames;
    for (int v = 0; v < 30; ++v) {
      for (int u = 0; u < 40; ++u) ASSERT_EQ(assembler.frame().at(u, v), frame.at(u, v));
    }
  }
  EXPECT_EQ(frames, 2);
  EXPECT_EQ(assembler.badLines() + assembler.badFrames(), 0U);
}

TEST(SensorPackets, EveryMalformationIsCountedByItsKind) {
  const std::vector<SensorSample> pixels(20, {0x0f, true, true});
  const auto broken = [&pixels](std::size_t bit) {
    std::vector<std::uint8_t> bits = serialise(pixels);
    bits[5 * packet_bits + bit] ^= 1;
    return receive(bits).faults;
  };
  EXPECT_EQ(broken(0)[PacketFault::StartBit], 1U);
  EXPECT_EQ(broken(11)[PacketFault::StopBit], 1U);
  EXPECT_EQ(broken(10)[PacketFault::LineWithoutFrame], 1U);
  EXPECT_EQ(broken(9)[PacketFault::DataInBlanking], 1U);
  for (const std::size_t bit : {0U, 9U, 10U, 11U}) EXPECT_EQ(broken(bit).total(), 1U) << bit;
  std::vector<std::uint8_t> cut = serialise(pixels);
  cut.pop_back();
  EXPECT_EQ(receive(cut).faults[PacketFault::Truncated], 1U);
  EXPECT_EQ(receive(cut).samples.size(), 19U);
}

TEST(SensorPackets, ALostBitCostsAFewPacketsAndNoMore) {
  test::Generator random(52);
  std::vector<SensorSample> samples;
  for (int i = 0; i < 400; ++i) {
    samples.push_back({static_cast<std::uint8_t>(test::between(random, 0, 255)), true, true});
  }
  std::vector<std::uint8_t> bits = serialise(samples);
  bits.erase(bits.begin() + 100 * packet_bits + 4);
  const Received received = receive(bits);
  EXPECT_GE(received.faults.total(), 1U);
  EXPECT_GT(received.samples.size(), 370U);
  const std::vector<SensorSample> head(received.samples.begin(), received.samples.begin() + 100);
  const std::vector<SensorSample> tail(received.samples.end() - 200, received.samples.end());
  EXPECT_EQ(head, std::vector<SensorSample>(samples.begin(), samples.begin() + 100));
  EXPECT_EQ(tail, std::vector<SensorSample>(samples.end() - 200, samples.end()));
}

TEST(SensorPackets, FramesWithAMissingPixelAreNotDelivered) {
  test::Generator random(53);
  Image<std::uint8_t> frame;
  test::paintFrame(frame, 16, 8, random);
  std::vector<SensorSample> samples = sampleFrame(frame.view(), 3, 5);
  samples.erase(samples.begin() + 20);
  FrameAssembler assembler(16, 8);
  for (const SensorSample& sample : samples) EXPECT_FALSE(assembler.push(sample));
  EXPECT_EQ(assembler.badLines(), 1U);
  EXPECT_EQ(assembler.badFrames(), 1U);
}

SelectedContacts points(std::initializer_list<FifoPoint> list) {
  SelectedContacts selected;
  int bearing = 3;
  for (const FifoPoint& point : list) selected.push(contactWord(bearing += 7, point.u, point.v));
  return selected;
}

TEST(Fifo, WordsAreLittleEndianWithThirteenZeroBits) {
  std::ostringstream out;
  ASSERT_TRUE(writeFifo(out, points({{0x27f, 0x1df}})));
  const std::string bytes = out.str();
  ASSERT_EQ(bytes.size(), 4U);
  EXPECT_EQ(static_cast<unsigned char>(bytes[0]), 0xdf);
  EXPECT_EQ(static_cast<unsigned char>(bytes[1]), 0xff);
  EXPECT_EQ(static_cast<unsigned char>(bytes[2]), 0x04);
  EXPECT_EQ(bytes[3], 0);
}

TEST(Fifo, ReaderReturnsWhatWasWritten) {
  std::stringstream stream;
  ASSERT_TRUE(writeFifo(stream, points({{0, 0}, {639, 479}, {1, 256}})));
  FifoReader reader(stream);
  EXPECT_EQ(reader.next(), (FifoPoint{0, 0}));
  EXPECT_EQ(reader.next(), (FifoPoint{639, 479}));
  EXPECT_EQ(reader.next(), (FifoPoint{1, 256}));
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
}

TEST(Fifo, ForeignWordsAreCountedAndACutWordIsNoticed) {
  std::stringstream stream;
  stream.write("\x01\x02\x00\x80", 4);
  ASSERT_TRUE(writeFifo(stream, points({{5, 6}})));
  stream.write("\x01\x02", 2);
  FifoReader reader(stream);
  EXPECT_EQ(reader.next(), (FifoPoint{5, 6}));
  EXPECT_EQ(reader.malformed(), 1U);
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.truncated());
}

}  // namespace
}  // namespace ipm_mapping::fpga
