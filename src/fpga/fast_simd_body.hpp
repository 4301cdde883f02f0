// The two kernels that are worth writing in vectors: rules 3-5 of a row in one pass, and the line
// machines of rules 11 and 12. No include guard: fast_kernels.cpp includes this file once per
// instruction set, inside a namespace and under that set's target, after defining
//   FPGA_VECTOR_BYTES  width of a vector
//   FPGA_MUL_EVEN      64-bit products of the signed even 32-bit elements
//   FPGA_ANY           whether a mask has a set element
//   FPGA_GATHER        32-bit loads from byte offsets
//   FPGA_TO_INT        truncation, the lowest integer where it does not fit

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

/// numerator << shift / divisor, truncated toward 0, exact while the quotient stays below 2^20:
/// `scale` is a little low, so that the estimate is right or one short in magnitude. Estimates
/// beyond 32 bits become the lowest integer; all quotients outside 20 bits stay outside.
FPGA_INLINE I32 quotient(I32 numerator, int shift, I32 divisor, F32 scale) {
  const I32 q = FPGA_TO_INT(__builtin_convertvector(numerator, F32) * scale);
  const U32 remainder = ((U32)numerator << shift) - (U32)q * (U32)divisor;
  const I32 one = (numerator >> 31) | 1;
  const I32 magnitude = (I32)remainder < 0 ? -(I32)remainder : (I32)remainder;
  return (I32)((U32)q + (U32)((magnitude >= divisor) & one));
}
/// Relative steps below 1 that outweigh the rounding of an estimate: four roundings of 2^-24 in a
/// view coordinate, three in a normalised one.
constexpr float view_scale = 64.0F * (1.0F - 0x1p-21F);
constexpr float normalized_scale = 1.0F - 0x1p-22F;

/// Even and odd elements of the chain of rule 4, as the low halves of 64-bit elements.
struct Halves {
  U64 even, odd;
};
FPGA_INLINE Halves split(I32 v) { return {(U64)v, (U64)v >> 32}; }
FPGA_INLINE I32 join(Halves h) {
  constexpr std::uint64_t low = 0xffffffffU;
  return (I32)((h.even & low) | (h.odd << 32));
}
/// (products + offset) >> 22: the two floors of rules 4 and 5 in one.
FPGA_INLINE I32 joinAfter22(Halves products, std::int64_t offset) {
  constexpr std::uint64_t low = 0xffffffffU;
  const auto addend = static_cast<std::uint64_t>(offset);
  return (I32)(((products.even + addend) >> 22 & low) | ((products.odd + addend) << 10 & ~low));
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

struct PixelBlock {
  I32 u, v;
};

/// What warpRow keeps in registers.
struct WarpConstants {
  LensConstants lens;
  AddressConstants address;
  F32 x_scale, y_scale;
};

/// Saturated normalised coordinates of a block in which some leave 20 bits: seldom.
__attribute__((noinline)) NormalizedPoint saturatedBlock(const LensConstants& c, I32 x, I32 y,
                                                         I32 valid, LensCounts& counts) {
  NormalizedPoint out{};
  for (int i = 0; i < lanes; ++i) {
    std::int32_t xn = 0, yn = 0;
    out.x[i] = body::normalized(x[i], c.cx, c.fx, c.x_scale, valid[i], xn);
    out.y[i] = body::normalized(y[i], c.cy, c.fy, c.y_scale, valid[i], yn);
    counts.xn += xn;
    counts.yn += yn;
  }
  return out;
}

/// Rule 4: xn and yn.
FPGA_INLINE NormalizedPoint normalizedBlock(const WarpConstants& c, I32 x, I32 y, I32 valid,
                                            LensCounts& counts) {
  const LensConstants& lens = c.lens;
  const NormalizedPoint n{quotient(x - lens.cx, 16, all(lens.fx), c.x_scale),
                          quotient(y - lens.cy, 16, all(lens.fy), c.y_scale)};
  const I32 outside = ((U32)(n.x + 524288) > 1048575U) | ((U32)(n.y + 524288) > 1048575U);
  if (__builtin_expect(FPGA_ANY(outside & valid), 0)) {
    return saturatedBlock(lens, x, y, valid, counts);
  }
  return n;
}

/// Rules 4 and 5 behind xn, yn, everything in 32 bits: ui and vi, and validity.
template <bool HasK3>
FPGA_INLINE PixelBlock distorted(const LensConstants& c, NormalizedPoint n, I32& valid) {
  const Halves xn = split(n.x), yn = split(n.y);
  const Halves r2 = floor16(xn * xn + yn * yn);
  valid &= join(r2) <= c.r2_max;
  Halves p = spread(c.k2);
  if constexpr (HasK3) p = floor16(spread(c.k3) * r2) + p;
  p = floor16(p * r2) + spread(c.k1);
  p = floor16(p * r2) + spread(65536);
  const auto nearest = [&p](Halves v, std::int32_t f, std::int32_t centre) {
    return joinAfter22(floor16(v * p) * spread(f), std::int64_t{centre + 32} << 16);
  };
  return {nearest(xn, c.fx, c.cx), nearest(yn, c.fy, c.cy)};
}

FPGA_INLINE std::int64_t counted(I32 minus_ones) {
  std::int64_t sum = 0;
  for (int i = 0; i < lanes; ++i) sum -= minus_ones[i];
  return sum;
}

/// Rule 3's sums at a block of columns.
struct Sums {
  I32 u, nx, ny, d, horizon;
};

/// Rule 3 of a row; whether any pixel is left.
FPGA_INLINE bool homographyRow(const HomographyRow& h, int width, CoordinateRow& row) {
  const I32 u0 = columnIndices();
  Sums s{u0, h.nx + h.nx_step * u0, h.ny + h.ny_step * u0, h.d + h.d_step * u0,
         h.horizon + h.horizon_step * u0};
  const Sums step{all(lanes), all(lanes * h.nx_step), all(lanes * h.ny_step), all(lanes * h.d_step),
                  all(lanes * h.horizon_step)};
  I32 any{};
  for (int u = 0; u < width; u += lanes) {
    const I32 divisor = s.d > 0 ? s.d : all(1);
    const F32 scale = view_scale / __builtin_convertvector(divisor, F32);
    const I32 x = quotient(s.nx, 6, divisor, scale);
    const I32 y = quotient(s.ny, 6, divisor, scale);
    storeVector(row.x + u, x);
    storeVector(row.y + u, y);
    const I32 valid = (s.d > 0) & (s.horizon > 0) & (s.u < width) & (x >= -131072) & (x <= 131071) &
                      (y >= -131072) & (y <= 131071);
    storeVector(row.valid + u, valid);
    any |= valid;
    s = {s.u + step.u, s.nx + step.nx, s.ny + step.ny, s.d + step.d, s.horizon + step.horizon};
  }
  return FPGA_ANY(any);
}

FPGA_INLINE void normalizeRow(const WarpConstants& c, int width, CoordinateRow& row,
                              LensCounts& counts) {
  for (int u = 0; u < width; u += lanes) {
    const NormalizedPoint n =
        normalizedBlock(c, loadVector<I32>(row.x + u), loadVector<I32>(row.y + u),
                        loadVector<I32>(row.valid + u), counts);
    storeVector(row.x + u, n.x);
    storeVector(row.y + u, n.y);
  }
}

template <bool HasK3>
FPGA_INLINE std::int64_t addressRow(const WarpConstants& c, const CoordinateRow& row,
                                    std::int32_t* offsets, std::uint8_t* valid_bytes) {
  const AddressConstants& a = c.address;
  I32 near_write{};
  for (int u = 0; u < a.width; u += lanes) {
    I32 valid = loadVector<I32>(row.valid + u);
    const PixelBlock pixel =
        distorted<HasK3>(c.lens, {loadVector<I32>(row.x + u), loadVector<I32>(row.y + u)}, valid);
    valid &= ((U32)pixel.u < (std::uint32_t)a.width) & ((U32)pixel.v < (std::uint32_t)a.height);
    near_write += valid & (pixel.v < a.near_write_below);
    storeVector(offsets + u, valid & (pixel.v * a.stride + pixel.u));
    storeVector(valid_bytes + u, __builtin_convertvector(valid, U8));
  }
  return counted(near_write);
}

/// Three short loops: their chains of dependent operations overlap, one long one's would not.
template <bool HasK3>
FPGA_INLINE std::int64_t warpRow(const HomographyRow h, const WarpConstants c,
                                 CoordinateRow& scratch, std::int32_t* offsets,
                                 std::uint8_t* valid_bytes, LensCounts& counts) {
  LensCounts local;
  if (!homographyRow(h, c.address.width, scratch)) {
    std::fill_n(offsets, c.address.width, 0);
    std::fill_n(valid_bytes, c.address.width, std::uint8_t{0});
    return 0;
  }
  normalizeRow(c, c.address.width, scratch, local);
  counts.xn += local.xn;
  counts.yn += local.yn;
  return addressRow<HasK3>(c, scratch, offsets, valid_bytes);
}

std::int64_t warp(const HomographyRow& h, const LensConstants& lens, const AddressConstants& a,
                  CoordinateRow& scratch, std::int32_t* offsets, std::uint8_t* valid,
                  LensCounts& counts) {
  if (!lens.narrow) return body::warp(h, lens, a, scratch, offsets, valid, counts);
  const WarpConstants c{lens, a, lens.x_scale * normalized_scale - F32{},
                        lens.y_scale * normalized_scale - F32{}};
  return lens.k3 == 0 ? warpRow<false>(h, c, scratch, offsets, valid, counts)
                      : warpRow<true>(h, c, scratch, offsets, valid, counts);
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
