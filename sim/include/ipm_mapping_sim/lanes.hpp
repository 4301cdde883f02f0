#pragma once
// Sixteen numbers side by side, one a ray. The compiler turns the loops over them into vector
// instructions; a function marked SIM_LANES exists for every x86-64 and once more for AVX2. Both
// round alike, so a seed's bytes do not depend on the machine.

#include <cstdint>
#include <cstring>

namespace ipm_mapping::sim {

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define SIM_LANES __attribute__((target_clones("avx2", "default")))
#else
#define SIM_LANES
#endif

constexpr int kPacket = 16;
constexpr unsigned kAllLanes = (1U << kPacket) - 1U;

template <class T>
struct alignas(64) LanesOf {
  T v[kPacket];
  T& operator[](int k) { return v[k]; }
  const T& operator[](int k) const { return v[k]; }
};
using Lanes = LanesOf<float>;
using IntLanes = LanesOf<std::int32_t>;

struct Lanes2 {
  Lanes x, y;
};
struct Lanes3 {
  Lanes x, y, z;
};

inline void fill(Lanes& lanes, float value) {
  for (int k = 0; k < kPacket; ++k) lanes[k] = value;
}

inline bool contains(unsigned members, int k) { return (members >> k & 1U) != 0; }

/// Calls body(k) for each lane in `members`.
template <class Body>
inline void forMembers(unsigned members, Body&& body) {
  for (; members != 0; members &= members - 1) body(__builtin_ctz(members));
}

/// Whole number at or below x; std::floor is a library call without SSE4.1.
inline int floorOf(float x) {
  const int whole = static_cast<int>(x);
  return whole - static_cast<int>(static_cast<float>(whole) > x);
}

inline std::int32_t bitsOf(float x) {
  std::int32_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}
inline float floatOf(std::int32_t bits) {
  float x;
  std::memcpy(&x, &bits, sizeof x);
  return x;
}

/// Logarithm to base 2 of a positive normal number, to 1e-6: the series of artanh around root 2.
inline float log2Of(float x) {
  constexpr float root = 1.41421356F, two_over_ln2 = 2.88539008F;
  const std::int32_t bits = bitsOf(x);
  const float exponent = static_cast<float>((bits >> 23) - 127);
  const float m = floatOf((bits & 0x7FFFFF) | 0x3F800000);
  const float s = (m - root) / (m + root), q = s * s;
  const float series = s * (1.0F + q * (1.0F / 3.0F + q * (0.2F + q * (1.0F / 7.0F))));
  return exponent + 0.5F + two_over_ln2 * series;
}

/// 2^x for x in -126...127, to a relative 1e-6.
inline float exp2Of(float x) {
  constexpr float ln2 = 0.693147181F, root = 1.41421356F;
  const int whole = floorOf(x);
  const float g = (x - static_cast<float>(whole) - 0.5F) * ln2;
  constexpr float c[] = {1.0F, 1.0F, 0.5F, 1.0F / 6.0F, 1.0F / 24.0F, 1.0F / 120.0F, 1.0F / 720.0F};
  const float high = c[4] + g * (c[5] + g * c[6]);
  const float series = c[0] + g * (c[1] + g * (c[2] + g * (c[3] + g * high)));
  return root * series * floatOf((whole + 127) * (1 << 23));
}

}  // namespace ipm_mapping::sim
