#include "ipm_mapping/io/atomic_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace ipm_mapping {
namespace {

std::string failure(const std::string& path, int error) {
  return path + ": " + std::strerror(error);
}

/// No other writer, in this process or another, has the same one.
std::string temporaryName(const std::string& path) {
  static std::atomic<unsigned> count{0};
  return path + "." + std::to_string(::getpid()) + "." + std::to_string(count++) + ".part";
}

/// 0 or errno.
int writeAll(int file, const std::string& content) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t n = ::write(file, content.data() + done, content.size() - done);
    if (n < 0 && errno != EINTR) return errno;
    if (n > 0) done += static_cast<std::size_t>(n);
  }
  return ::fsync(file) == 0 ? 0 : errno;
}

/// Makes the rename itself last; not every file system can, and the file is whole either way.
void syncFolder(const std::string& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

std::optional<std::string> writeFileAtomically(const std::string& path,
                                               const std::string& content) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const std::string part = temporaryName(path);
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (file < 0) return failure(path, errno);
  int error = writeAll(file, content);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && std::rename(part.c_str(), path.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(part.c_str());
    return failure(path, error);
  }
  syncFolder(folder.empty() ? "." : folder);
  return std::nullopt;
}

std::optional<std::string> readFile(const std::string& path, std::string& content) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return failure(path, EISDIR);
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) return failure(path, errno != 0 ? errno : EIO);
  std::ostringstream all;
  all << in.rdbuf();
  if (in.bad()) return failure(path, EIO);
  content = all.str();
  return std::nullopt;
}

}  // namespace ipm_mapping
