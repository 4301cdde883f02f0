#pragma once
// Counter-based randomness: every number is a pure function of a seed and of what it is for, so
// that frames can be rendered in any order, or left out, and keep their bytes.

#include <cstdint>

namespace ipm_mapping::sim {

/// SplitMix64's finaliser: a bijection of 64-bit words without visible structure.
inline std::uint64_t mixBits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31);
}

inline std::uint64_t hashOf(std::uint64_t a, std::uint64_t b) { return mixBits(mixBits(a) ^ b); }
inline std::uint64_t hashOf(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
  return hashOf(hashOf(a, b), c);
}
inline std::uint64_t hashOf(std::uint64_t a, std::uint64_t b, std::uint64_t c, std::uint64_t d) {
  return hashOf(hashOf(a, b, c), d);
}

/// Hash of a pair of signed cell indices.
inline std::uint64_t cellHash(std::uint64_t seed, int i, int j) {
  return hashOf(seed, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j));
}

/// Uniform in [0, 1) from the top 24 bits.
inline float unitFloat(std::uint64_t bits) { return static_cast<float>(bits >> 40) * 0x1p-24F; }

/// Uniform in [-1, 1).
inline float signedFloat(std::uint64_t bits) { return 2.0F * unitFloat(bits) - 1.0F; }

/// Standard normal deviate from 24 random bits, by table; clipped near +-3.9.
float normalFloat(std::uint32_t bits24);

/// What a stream of random numbers is for; keeps the streams of one seed apart.
enum class Stream : std::uint64_t { Sensor = 1, Exposure, Odometry, Drop, Texture, Heap, Light };

/// A sequence of deviates of one stream.
class RandomSequence {
 public:
  RandomSequence(std::uint64_t seed, Stream stream)
      : state_(hashOf(seed, static_cast<std::uint64_t>(stream))) {}

  std::uint64_t bits() { return mixBits(state_ ^ counter_++ * 0xD1342543DE82EF95ULL); }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double normal() {
    return static_cast<double>(normalFloat(static_cast<std::uint32_t>(bits() >> 40)));
  }

 private:
  std::uint64_t state_;
  std::uint64_t counter_ = 0;
};

}  // namespace ipm_mapping::sim
