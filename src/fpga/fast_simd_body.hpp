// The two kernels that are worth writing in vectors: rules 3-5 of a row in one pass, and the line
// machines of rules 11 and 12. No include guard: fast_kernels.cpp includes this file once per
// instruction set, inside a namespace and under that set's target, after defining
//   FPGA_VECTOR_BYTES  width of a vector
//   FPGA_MUL_EVEN      64-bit products of the signed even 32-bit elements
//   FPGA_ANY           whether a mask has a set element
//   FPGA_GATHER        32-bit loads from byte offsets

constexpr int lanes = FPGA_VECTOR_BYTES / 4;
typedef std::int32_t I32 __attribute__((vector_size(FPGA_VECTOR_BYTES)));
typedef std::uint32_t U32 __attribute__((vector_size(FPGA_VECTOR_BYTES)));
typedef std::uint64_t U64 __attribute__((vector_size(FPGA_VECTOR_BYTES)));
typedef float F32 __attribute__((vector_size(FPGA_VECTOR_BYTES)));
typedef std::uint8_t U8 __attribute__((vector_size(FPGA_VECTOR_BYTES / 4)));

template <class V, class T>
FPGA_INLINE V loadVector(const T* from) {
  V v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
template <class V, class T>
FPGA_INLINE void storeVector(T* to, V v) {
  __builtin_memcpy(to, &v, sizeof v);
}

FPGA_INLINE I32 all(std::int32_t value) { return value - I32{}; }
FPGA_INLINE I32 columnIndices() {
  I32 index{};
  for (int i = 0; i < lanes; ++i) index[i] = i;
  return index;
}

/// body::signedQuotient for a vector.
FPGA_INLINE I32 quotient(I32 numerator, int shift, I32 divisor, F32 scale, float beyond) {
  const I32 sign = numerator >> 31;
  const I32 magnitude = (numerator ^ sign) - sign;
  const F32 estimate = __builtin_convertvector(magnitude, F32) * scale;
  const F32 limit = beyond - F32{};
  I32 q = __builtin_convertvector(estimate < limit ? estimate : limit, I32);
  const I32 remainder = (I32)(((U32)magnitude << shift) - (U32)q * (U32)divisor);
  q -= (remainder >= divisor);
  q += (remainder < 0);
  return (q ^ sign) - sign;
}

/// Even and odd elements of the chain of rule 4, as the low halves of 64-bit elements.
struct Halves {
  U64 even, odd;
};
FPGA_INLINE Halves split(I32 v) { return {(U64)v, (U64)v >> 32}; }
FPGA_INLINE I32 join(Halves h) {
  constexpr std::uint64_t low = 0xffffffffU;
  return (I32)((h.even & low) | (h.odd << 32));
}
FPGA_INLINE Halves spread(std::int32_t value) { return split(all(value)); }
FPGA_INLINE Halves operator+(Halves a, Halves b) { return {a.even + b.even, a.odd + b.odd}; }
FPGA_INLINE Halves operator*(Halves a, Halves b) {
  return {FPGA_MUL_EVEN(a.even, b.even), FPGA_MUL_EVEN(a.odd, b.odd)};
}
/// >> 16; only the low 32 bits of the elements are meaningful afterwards.
FPGA_INLINE Halves floor16(Halves a) { return {a.even >> 16, a.odd >> 16}; }

struct NormalizedPoint {
  I32 x, y;
};

/// body::normalized for a vector; count collects -1 for every saturation of a valid element.
FPGA_INLINE I32 normalizedVector(I32 coordinate, std::int32_t centre, std::int32_t f, float scale,
                                 I32 valid, I32& count) {
  const I32 q = quotient(coordinate - centre, 16, all(f), scale - F32{}, body::beyond_normalized);
  const I32 high = q > 524287 ? all(524287) : q;
  const I32 limited = high < -524288 ? all(-524288) : high;
  count += valid & (limited != q);
  return limited;
}

/// Rule 4 behind xn, yn, everything in 32 bits: raw coordinates, and validity.
template <bool HasK3>
FPGA_INLINE NormalizedPoint distorted(const LensConstants& c, NormalizedPoint n, I32& valid) {
  const Halves xn = split(n.x), yn = split(n.y);
  const Halves r2 = floor16(xn * xn + yn * yn);
  valid &= join(r2) <= c.r2_max;
  Halves p = spread(c.k2);
  if constexpr (HasK3) p = floor16(spread(c.k3) * r2) + p;
  p = floor16(p * r2) + spread(c.k1);
  p = floor16(p * r2) + spread(65536);
  const auto raw = [&p](Halves v, std::int32_t f, std::int32_t centre) {
    return join(floor16(floor16(v * p) * spread(f))) + centre;
  };
  return {raw(xn, c.fx, c.cx), raw(yn, c.fy, c.cy)};
}

struct WarpCounts {
  I32 xn{}, yn{}, near_write{};
};

FPGA_INLINE std::int64_t counted(I32 minus_ones) {
  std::int64_t sum = 0;
  for (int i = 0; i < lanes; ++i) sum -= minus_ones[i];
  return sum;
}

template <bool HasK3>
FPGA_INLINE void warpBlock(const HomographyRow& h, const LensConstants& lens,
                           const AddressConstants& a, int first, std::int32_t* offsets,
                           std::uint8_t* valid_bytes, WarpCounts& counts) {
  const I32 u = columnIndices() + first;
  const I32 d = h.d + h.d_step * u;
  I32 valid = (d > 0) & (h.horizon + h.horizon_step * u > 0) & (u < a.width);
  const I32 divisor = d > 0 ? d : all(1);
  const F32 scale = 64.0F / __builtin_convertvector(divisor, F32);
  const I32 x = quotient(h.nx + h.nx_step * u, 6, divisor, scale, body::beyond_view);
  const I32 y = quotient(h.ny + h.ny_step * u, 6, divisor, scale, body::beyond_view);
  valid &= (x >= -131072) & (x <= 131071) & (y >= -131072) & (y <= 131071);
  I32 offset{};
  if (FPGA_ANY(valid)) {
    const NormalizedPoint n{normalizedVector(x, lens.cx, lens.fx, lens.x_scale, valid, counts.xn),
                            normalizedVector(y, lens.cy, lens.fy, lens.y_scale, valid, counts.yn)};
    const NormalizedPoint raw = distorted<HasK3>(lens, n, valid);
    const I32 ui = (raw.x + 32) >> 6, vi = (raw.y + 32) >> 6;
    valid &= ((U32)ui < (std::uint32_t)a.width) & ((U32)vi < (std::uint32_t)a.height);
    counts.near_write += valid & (vi < a.near_write_below);
    offset = valid & (vi * a.stride + ui);
  }
  storeVector(offsets + first, offset);
  storeVector(valid_bytes + first, __builtin_convertvector(valid, U8));
}

template <bool HasK3>
FPGA_INLINE std::int64_t warpRow(const HomographyRow& h, const LensConstants& lens,
                                 const AddressConstants& a, std::int32_t* offsets,
                                 std::uint8_t* valid, LensCounts& counts) {
  WarpCounts c;
  for (int u = 0; u < a.width; u += lanes) warpBlock<HasK3>(h, lens, a, u, offsets, valid, c);
  counts.xn += counted(c.xn);
  counts.yn += counted(c.yn);
  return counted(c.near_write);
}

std::int64_t warp(const HomographyRow& h, const LensConstants& lens, const AddressConstants& a,
                  CoordinateRow& scratch, std::int32_t* offsets, std::uint8_t* valid,
                  LensCounts& counts) {
  if (!lens.narrow) return body::warp(h, lens, a, scratch, offsets, valid, counts);
  return lens.k3 == 0 ? warpRow<false>(h, lens, a, offsets, valid, counts)
                      : warpRow<true>(h, lens, a, offsets, valid, counts);
}

FPGA_INLINE I32 onesOf(I32 bits) {
  bits = bits - (bits >> 1 & 0x555);
  bits = (bits & 0x333) + (bits >> 2 & 0x333);
  return (bits & 0xf) + (bits >> 4 & 0xf) + (bits >> 8);
}

/// body::contactStep for a vector of lines from i on.
FPGA_INLINE void contactVector(const MachineConstants& c, int v, I32 window, LineRegisters& r,
                               int i) {
  const auto load = [i](const std::int32_t* from) { return loadVector<I32>(from + i); };
  const I32 score = load(r.score), surface = load(r.surface), height = load(r.height);
  const I32 smallest = load(r.smallest), stored = load(r.stored), found = load(r.found);
  const I32 pixel = -(window >> window_half_width & 1);
  const I32 a = onesOf(window);
  const I32 narrower = a <= smallest;
  const I32 contact = (score > c.score_min) & (surface > 4 * height) & (height >= c.min_height);
  const I32 keep = all(c.triangle ? -1 : 0);
  storeVector(r.found + i, (~pixel & contact) ? stored : found);
  storeVector(r.stored + i, (pixel & narrower) ? load(r.u) * 512 + v : stored);
  storeVector(r.smallest + i, (pixel & narrower) ? a : all(2 * window_half_width + 1));
  storeVector(r.score + i, pixel & (narrower ? score + 1 : keep & (score - 1)));
  storeVector(r.surface + i, pixel & (narrower ? surface + a : keep & surface));
  storeVector(r.height + i, pixel & (narrower ? height + 1 : keep & height));
  storeVector(r.bear + i, load(r.bear) - pixel);
}

/// Rule 11: the step of a vector of lines; saturated collects -1.
FPGA_INLINE void stepVector(LineRegisters& r, int i, I32& saturated) {
  const auto load = [i](const std::int32_t* from) { return loadVector<I32>(from + i); };
  const I32 steps = load(r.d) > 0;
  const I32 d = load(r.d) + (steps ? load(r.up) : load(r.flat));
  const I32 high = d > 262143 ? all(262143) : d;
  const I32 limited = high < -262144 ? all(-262144) : high;
  saturated += limited != d;
  storeVector(r.u + i, load(r.u) + (steps & load(r.direction)));
  storeVector(r.d + i, limited);
}

std::int64_t localize(const MachineConstants& c, int v, const BitRow& bits, LineRegisters& r) {
  I32 saturated{};
  for (int i = 0; i < line_count; i += lanes) {
    const I32 u = loadVector<I32>(r.u + i);
    const I32 low = u < -body::outside ? all(-body::outside) : u;
    const I32 clamped = low > max_width + body::outside ? all(max_width + body::outside) : low;
    const I32 first = clamped + (64 - window_half_width);
    const I32 word = FPGA_GATHER(bits.words, first >> 3);
    contactVector(c, v, (I32)((U32)word >> (U32)(first & 7)) & 0x7ff, r, i);
    stepVector(r, i, saturated);
  }
  return counted(saturated);
}
