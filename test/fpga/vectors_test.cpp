#include "ipm_mapping/fpga/vectors.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "fpga/support.hpp"

namespace ipm_mapping::fpga {
namespace {

std::string freshDirectory(const char* name) {
  const auto path = std::filesystem::path(testing::TempDir()) / name;
  std::filesystem::remove_all(path);
  return path.string();
}

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string refusal(const std::string& text) {
  try {
    (void)parseParameters(text);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Vectors, ParametersSurviveTheFileForAnyValues) {
  test::Generator random(11);
  for (int round = 0; round < 100; ++round) {
    const FrameParameters p = test::anyParameters(640, 480, random);
    EXPECT_TRUE(parseParameters(formatParameters(p)) == p);
  }
}

TEST(Vectors, EveryParameterIsRefusedByNameWhenMissingOrOutsideItsWire) {
  const FrameParameters good = test::driveParameters(640, 480);
  FrameParameters::fields(good, [&](const char* name, Integer value, Integer low, Integer high) {
    const std::string line = std::string("\n") + name + " = " + std::to_string(value) + "\n";
    const std::string text = "\n" + formatParameters(good);
    EXPECT_NE(refusal(replaced(text, line, "\n")).find(name), std::string::npos);
    for (const Integer wrong : {low - 1, high + 1}) {
      const std::string other = std::string("\n") + name + " = " + std::to_string(wrong) + "\n";
      EXPECT_NE(refusal(replaced(text, line, other)).find(name), std::string::npos) << other;
    }
  });
}

TEST(Vectors, UnknownRepeatedAndMalformedLinesAreRefusedByName) {
  const std::string good = formatParameters(test::driveParameters(640, 480));
  EXPECT_EQ(refusal(good), "accepted");
  EXPECT_NE(refusal(good + "gamma = 3\n").find("unknown name: gamma"), std::string::npos);
  EXPECT_NE(refusal(good + "k1 = 410\n").find("repeated name: k1"), std::string::npos);
  EXPECT_NE(refusal(replaced(good, "fx = 33600", "fx = 33600.5")).find("fx"), std::string::npos);
  EXPECT_NE(refusal(replaced(good, "fx = 33600", "fx =")).find("fx"), std::string::npos);
  EXPECT_NE(refusal(good + "nonsense\n").find("nonsense"), std::string::npos);
  EXPECT_NE(refusal(replaced(good, "focus_v = 1400", "focus_v = 0")).find("focus_v"),
            std::string::npos);
}

TEST(Vectors, DumpReadBackAndDumpedAgainIsTheSame) {
  test::Generator random(12);
  const OwnedInputs owned = test::randomInputs(96, 64, random);
  const std::string first = freshDirectory("fpga_vectors_a");
  const std::string second = freshDirectory("fpga_vectors_b");
  dumpVectors(owned.inputs(), first);
  dumpVectors(readInputs(first).inputs(), second);
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(first)) {
    ++files;
    EXPECT_EQ(contents(entry.path().string()),
              contents(second + "/" + entry.path().filename().string()))
        << entry.path();
  }
  EXPECT_EQ(files, 15);
}

TEST(Vectors, FilesHaveTheDocumentedShape) {
  OwnedInputs owned;
  owned.parameters = test::identityParameters(40, 30);
  owned.reference.resize(40, 30, 10);
  owned.current.resize(40, 30, 10);
  const std::string directory = freshDirectory("fpga_vectors_shape");
  dumpVectors(owned.inputs(), directory);
  const auto file = [&directory](const char* name) { return contents(directory + "/" + name); };
  EXPECT_EQ(file("peaks.txt"), "");
  EXPECT_EQ(file("selected.txt"), "");
  EXPECT_EQ(file("fifo.txt"), "");
  EXPECT_EQ(file("threshold_out.txt"), "255\n");
  EXPECT_EQ(file("cor.txt").substr(0, 10), "0 0000000\n");
  EXPECT_EQ(file("cor.txt").size(), 80U * 10);
  EXPECT_EQ(file("gaussian.txt").substr(0, 4), "100\n");
  EXPECT_EQ(file("difference.txt").size(), 40U * 30 * 4);
  EXPECT_EQ(file("mask.txt").size(), 30U * 41);
  EXPECT_EQ(file("histogram.txt").substr(0, 7), "1064\n0\n");  // 38 * 28 inner pixels
  EXPECT_EQ(file("overflow.txt"),
            "xn 0\nyn 0\nxn_current 0\nyn_current 0\nread_write 0\nbeam_d 0\nbeam_slope 0\n"
            "bear 0\ncontact_s 0\ncontact_h 0\ncontact_score 0\na1 0\na2 0\npeaks 0\n");
}

TEST(Vectors, BadPicturesAreRefusedByFile) {
  test::Generator random(13);
  const OwnedInputs owned = test::randomInputs(32, 24, random);
  const std::string directory = freshDirectory("fpga_vectors_bad");
  const auto refusalOf = [&directory] {
    try {
      (void)readInputs(directory);
    } catch (const VectorError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  writeInputs(owned.inputs(), directory);
  EXPECT_EQ(refusalOf(), "accepted");
  std::ofstream(directory + "/current.pgm") << "P2\n32 24\n255\n";
  EXPECT_NE(refusalOf().find("current.pgm"), std::string::npos);
  std::ofstream(directory + "/current.pgm") << "P5\n32 24\n255\nshort";
  EXPECT_NE(refusalOf().find("current.pgm"), std::string::npos);
  std::ofstream(directory + "/current.pgm") << "P5\n# a comment\n24 32\n255\n"
                                            << std::string(32 * 24, 'x');
  EXPECT_NE(refusalOf().find("size"), std::string::npos);
  std::filesystem::remove(directory + "/current.pgm");
  EXPECT_NE(refusalOf().find("current.pgm"), std::string::npos);
}

TEST(Vectors, PointsGoToTheFifoWithoutTheirBearing) {
  test::Generator random(14);
  Wires wires;
  for (int round = 0; round < 50; ++round) {
    const OwnedInputs owned = test::randomInputs(160, 120, random);
    runAllWires(owned.inputs(), wires);
    for (const std::uint32_t word : wires.results.selected) {
      EXPECT_EQ(pointWord(word) >> 19, 0U);
      EXPECT_EQ(wordColumn(pointWord(word)), wordColumn(word));
      EXPECT_EQ(wordRow(pointWord(word)), wordRow(word));
    }
  }
}

}  // namespace
}  // namespace ipm_mapping::fpga
