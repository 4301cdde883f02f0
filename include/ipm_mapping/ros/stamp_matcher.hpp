#pragma once

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <deque>
#include <optional>
#include <tuple>

namespace ipm_mapping {

/// Brings together messages of the same stamp from several topics, each of which keeps its order.
/// Sets wait in the order in which they began, a bounded number of them.
template <class... Messages>
class StampMatcher {
 public:
  using Set = std::tuple<boost::shared_ptr<const Messages>...>;
  using Stamp = std::uint64_t;  ///< nanoseconds

  explicit StampMatcher(std::size_t waiting) : waiting_(waiting) {}

  /// Takes topic `I`'s message. The complete set, when this was its last message: older ones that
  /// are not complete cannot become so any more, and are given up.
  template <std::size_t I, class Message>
  std::optional<Set> add(Stamp stamp, const boost::shared_ptr<const Message>& message) {
    if (stamp < newest_[I]) forgetTopic<I>();
    newest_[I] = stamp;
    Entry& entry = entryOf(stamp);
    std::get<I>(entry.set) = message;
    if (!complete(entry.set)) return std::nullopt;
    const Set set = entry.set;
    while (sets_.front().stamp != stamp) giveUpOldest();
    sets_.pop_front();
    return set;
  }
  void clear() {
    sets_.clear();
    for (Stamp& newest : newest_) newest = 0;
  }

  [[nodiscard]] std::size_t waiting() const { return sets_.size(); }
  /// Sets that never became complete.
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }

 private:
  struct Entry {
    Stamp stamp;
    Set set;
  };

  Entry& entryOf(Stamp stamp) {
    for (Entry& each : sets_)
      if (each.stamp == stamp) return each;
    if (sets_.size() >= waiting_) giveUpOldest();
    sets_.push_back({stamp, {}});
    return sets_.back();
  }
  void giveUpOldest() {
    sets_.pop_front();
    ++incomplete_;
  }
  /// The clock was set back: what the topic has brought so far belongs to the time before.
  template <std::size_t I>
  void forgetTopic() {
    for (auto each = sets_.begin(); each != sets_.end();) {
      const bool stale = std::get<I>(each->set) != nullptr;
      incomplete_ += stale;
      each = stale ? sets_.erase(each) : each + 1;
    }
  }
  static bool complete(const Set& set) {
    return std::apply([](const auto&... each) { return (... && (each != nullptr)); }, set);
  }

  std::size_t waiting_;
  std::deque<Entry> sets_;
  Stamp newest_[sizeof...(Messages)] = {};
  std::uint64_t incomplete_ = 0;
};

}  // namespace ipm_mapping
