#include "ipm_mapping/io/atomic_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

namespace ipm_mapping {
namespace {

class AtomicFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "atomic_file_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  [[nodiscard]] long files() const {
    return std::distance(std::filesystem::directory_iterator(folder_), {});
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
};

TEST_F(AtomicFile, ReadsBackEveryByteAndReplacesWhatWasThere) {
  std::string all, back;
  for (int i = 0; i < 100000; ++i) all += static_cast<char>(i * 7);
  ASSERT_EQ(writeFileAtomically(path("a"), "old"), std::nullopt);
  ASSERT_EQ(writeFileAtomically(path("a"), all), std::nullopt);
  ASSERT_EQ(readFile(path("a"), back), std::nullopt);
  EXPECT_EQ(back, all);
  EXPECT_EQ(files(), 1);
}

TEST_F(AtomicFile, AReaderThatHoldsTheOldFileKeepsItWhole) {
  ASSERT_EQ(writeFileAtomically(path("a"), "old content"), std::nullopt);
  std::ifstream open_before(path("a"));
  ASSERT_EQ(writeFileAtomically(path("a"), "new"), std::nullopt);
  std::string line;
  std::getline(open_before, line);
  EXPECT_EQ(line, "old content");
}

TEST_F(AtomicFile, HasTheModeOfAnOrdinaryFile) {
  std::ofstream(path("ordinary")) << "x";
  ASSERT_EQ(writeFileAtomically(path("a"), "x"), std::nullopt);
  EXPECT_EQ(std::filesystem::status(path("a")).permissions(),
            std::filesystem::status(path("ordinary")).permissions());
}

TEST_F(AtomicFile, FailuresNameThePathAndLeaveNothingBehind) {
  std::filesystem::create_directory(path("folder"));
  std::string content = "kept";
  for (const std::string& wrong : {path("missing/a"), path("folder")}) {
    const auto error = writeFileAtomically(wrong, "x");
    ASSERT_TRUE(error) << wrong;
    EXPECT_EQ(error->find(wrong + ": "), 0U) << *error;
    EXPECT_TRUE(readFile(wrong, content)) << wrong;
  }
  EXPECT_EQ(content, "kept");
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace ipm_mapping
