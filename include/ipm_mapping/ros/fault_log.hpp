#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ipm_mapping {

/// What went wrong since the last look: every distinct sentence once, in the order in which they
/// came up, with how often. Of more than `most_sentences` different ones only the number is kept.
class FaultLog {
 public:
  static constexpr std::size_t most_sentences = 16;

  struct Fault {
    std::string sentence;
    std::uint64_t count = 0;
  };

  void add(const std::string& sentence) {
    const auto same = [&](const Fault& fault) { return fault.sentence == sentence; };
    const auto known = std::find_if(faults_.begin(), faults_.end(), same);
    if (known != faults_.end())
      ++known->count;
    else if (faults_.size() < most_sentences)
      faults_.push_back({sentence, 1});
    else
      ++others_;
  }
  void clear() {
    faults_.clear();
    others_ = 0;
  }

  [[nodiscard]] const std::vector<Fault>& faults() const { return faults_; }
  /// How often anything else went wrong.
  [[nodiscard]] std::uint64_t others() const { return others_; }
  /// The sentence that came most often, the earlier one of equals; empty when nothing went wrong.
  [[nodiscard]] std::string commonest() const {
    const auto fewer = [](const Fault& a, const Fault& b) { return a.count < b.count; };
    const auto most = std::max_element(faults_.begin(), faults_.end(), fewer);
    return most == faults_.end() ? std::string() : most->sentence;
  }

 private:
  std::vector<Fault> faults_;
  std::uint64_t others_ = 0;
};

}  // namespace ipm_mapping
