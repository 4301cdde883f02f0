#include "ipm_mapping/detectors/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "ipm_mapping/stages/obstacle_mask.hpp"

namespace ipm_mapping {
namespace {

class Counter {
 public:
  void add(bool seen_a, bool seen_b, int a, int b) {
    if (seen_a != seen_b) ++result_.seen_once;
    if (!seen_a || !seen_b) return;
    const int difference = std::abs(a - b);
    ++result_.compared;
    result_.changed += difference != 0;
    result_.max = std::max(result_.max, difference);
    sum_ += static_cast<std::uint64_t>(difference);
  }
  [[nodiscard]] PictureComparison result() const {
    PictureComparison result = result_;
    if (result.compared > 0)
      result.mean = static_cast<double>(sum_) / static_cast<double>(result.compared);
    return result;
  }

 private:
  PictureComparison result_;
  std::uint64_t sum_ = 0;
};

PictureComparison otherSize() {
  PictureComparison result;
  result.same_size = false;
  return result;
}

/// Distances from each point of `from` to the nearest one of `to`.
void addNearest(const std::vector<Contact>& from, const std::vector<Contact>& to,
                PointComparison& result) {
  for (const Contact& contact : from) {
    float nearest = std::numeric_limits<float>::infinity();
    for (const Contact& other : to)
      nearest = std::min(nearest, (contact.p_base - other.p_base).norm());
    result.mean_distance += static_cast<double>(nearest);
    result.max_distance = std::max(result.max_distance, static_cast<double>(nearest));
  }
}

}  // namespace

PictureComparison compareDifferences(GrayView a, GrayView valid_a, GrayView b, GrayView valid_b) {
  if (!a.sameSize(b) || !a.sameSize(valid_a) || !b.sameSize(valid_b)) return otherSize();
  Counter counter;
  for (int v = 0; v < a.height; ++v)
    for (int u = 0; u < a.width; ++u)
      counter.add(valid_a.at(u, v) != 0, valid_b.at(u, v) != 0, a.at(u, v), b.at(u, v));
  return counter.result();
}

PictureComparison compareMasks(GrayView a, GrayView b) {
  if (!a.sameSize(b)) return otherSize();
  Counter counter;
  for (int v = 0; v < a.height; ++v)
    for (int u = 0; u < a.width; ++u) {
      const std::uint8_t left = a.at(u, v), right = b.at(u, v);
      counter.add(left != mask::unseen, right != mask::unseen, left == mask::obstacle,
                  right == mask::obstacle);
    }
  return counter.result();
}

PointComparison compareContacts(const std::vector<Contact>& a, const std::vector<Contact>& b) {
  PointComparison result;
  result.points_a = a.size();
  result.points_b = b.size();
  if (a.empty() != b.empty())
    result.mean_distance = result.max_distance = std::numeric_limits<double>::quiet_NaN();
  if (a.empty() || b.empty()) return result;
  addNearest(a, b, result);
  addNearest(b, a, result);
  result.mean_distance /= static_cast<double>(a.size() + b.size());
  return result;
}

}  // namespace ipm_mapping
