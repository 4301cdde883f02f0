// Saving a map over an older one, killed before and after each of its system calls: what is loaded
// then is one of the two maps, never the picture of one at the origin of the other.

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "ipm_mapping/mapping/map_io.hpp"

namespace ipm_mapping {
namespace {

enum class End { Done, Failed, Killed };

/// Runs `work` in a process of its own, which is killed when it has entered or left `calls` system
/// calls, or comes to its end before.
End runAndKill(const std::function<bool()>& work, int calls) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) ::_exit(2);
    ::raise(SIGSTOP);
    ::_exit(work() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  for (int i = 0; WIFSTOPPED(status); ++i) {
    if (i == calls) ::kill(child, SIGKILL);
    ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    ::waitpid(child, &status, 0);
  }
  if (WIFSIGNALED(status)) return End::Killed;
  return WEXITSTATUS(status) == 0 ? End::Done : End::Failed;
}

/// Names and contents of files.
using Files = std::map<std::string, std::string>;

class KilledSave : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "killed_save_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    for (unsigned seed = 0; seed < 3; ++seed) maps_.push_back(randomMap(seed));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// All of one size: a mixture of two would be read without complaint.
  static TrinaryMap randomMap(unsigned seed) {
    TrinaryMap map;
    map.origin_x = -2.0 - seed;
    map.origin_y = 1.0 + seed;
    map.width = 9;
    map.height = 7;
    std::mt19937 random(seed);
    for (int i = 0; i < map.width * map.height; ++i) {
      const std::int8_t values[] = {-1, 0, 100};
      map.cells.push_back(values[random() % 3]);
    }
    return map;
  }

  [[nodiscard]] bool save(std::size_t i) const { return !saveMap(maps_[i], folder_ + "/map"); }
  /// Which of the maps is there; -1 when it is none of them.
  [[nodiscard]] int loaded() const {
    TrinaryMap map;
    if (loadMap(folder_ + "/map.yaml", map)) return -1;
    for (std::size_t i = 0; i < maps_.size(); ++i)
      if (map.cells == maps_[i].cells && map.origin_x == maps_[i].origin_x &&
          map.origin_y == maps_[i].origin_y)
        return static_cast<int>(i);
    return -1;
  }

  /// Without temporary files that nobody reads.
  [[nodiscard]] Files files() const {
    Files found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.path().extension() == ".part") continue;
      std::ostringstream content;
      content << std::ifstream(entry.path(), std::ios::binary).rdbuf();
      found[entry.path().filename().string()] = content.str();
    }
    return found;
  }
  void restore(const Files& files) const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      std::filesystem::remove(entry.path());
    for (const auto& [name, content] : files)
      std::ofstream(folder_ + "/" + name, std::ios::binary) << content;
  }

  /// Saves map `i` over `before`, killed ever later until it comes to its end: every state that
  /// the folder was left in.
  std::set<Files> killEverywhere(const Files& before, int i) {
    std::set<Files> left;
    bool arrived = false;
    for (int calls = 0;; ++calls) {
      restore(before);
      const int old = loaded();
      const End end = runAndKill([&] { return save(static_cast<std::size_t>(i)); }, calls);
      const int now = loaded();
      EXPECT_TRUE(now == i || (now == old && !arrived))
          << "map " << now << " after " << calls << " half calls, where " << old << " was";
      arrived = now == i;
      left.insert(files());
      if (end == End::Killed) continue;
      EXPECT_EQ(end, End::Done) << "cannot save, or must not trace its own child";
      EXPECT_TRUE(arrived);
      return left;
    }
  }

  std::string folder_;
  std::vector<TrinaryMap> maps_;
};

TEST_F(KilledSave, LeavesTheOldMapOrTheNewOne) {
  ASSERT_TRUE(save(0));
  const auto left = killEverywhere(files(), 1);
  EXPECT_GT(left.size(), 3U) << "the kills have to hit it between its files";
  std::set<std::string> names;
  for (const auto& [name, content] : files()) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"map.pgm", "map.yaml"}));
}

TEST_F(KilledSave, TheNextSaveMayBeKilledToo) {
  ASSERT_TRUE(save(0));
  for (const Files& before : killEverywhere(files(), 1)) {
    killEverywhere(before, 2);
    EXPECT_EQ(files().size(), 2U);
  }
}

}  // namespace
}  // namespace ipm_mapping
