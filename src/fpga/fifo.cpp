#include "ipm_mapping/fpga/fifo.hpp"

#include <array>

namespace ipm_mapping::fpga {
namespace {

constexpr int word_bytes = 4;

}  // namespace

bool writeFifo(std::ostream& out, const SelectedContacts& selected) {
  for (const std::uint32_t contact : selected) {
    const std::uint32_t word = pointWord(contact);
    std::array<char, word_bytes> bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<char>(word >> (8 * i) & 0xff);
    }
    out.write(bytes.data(), word_bytes);
  }
  return static_cast<bool>(out);
}

std::optional<std::uint32_t> FifoReader::word() {
  std::array<char, word_bytes> bytes{};
  in_.read(bytes.data(), word_bytes);
  if (in_.gcount() != word_bytes) {
    truncated_ = truncated_ || in_.gcount() != 0;
    return std::nullopt;
  }
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    word |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  }
  return word;
}

std::optional<FifoPoint> FifoReader::next() {
  while (const auto read = word()) {
    if (*read == pointWord(*read)) return FifoPoint{wordColumn(*read), wordRow(*read)};
    ++malformed_;
  }
  return std::nullopt;
}

}  // namespace ipm_mapping::fpga
