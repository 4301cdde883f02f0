// Elementary functions of the sweep's kernels. No include guard: files with kernels include this
// one once per instruction set, inside that set's namespace, where `hn` is Highway's.

using Floats = hn::ScalableTag<float>;
using Ints = hn::RebindToSigned<Floats>;
using Vf = hn::Vec<Floats>;

// Highway's own Log and Atan fuse products into sums where the target can: not the same bits.

/// ln x, x > 0: exponent, and 2 atanh((m - 1) / (m + 1)) of the mantissa in [sqrt 1/2, sqrt 2).
HWY_INLINE Vf logarithm(Floats d, Vf x) {
  const Ints di;
  const auto bits = hn::BitCast(di, x);
  const auto exponent = hn::ShiftRight<23>(hn::Sub(bits, hn::Set(di, 0x3F3504F3)));
  const Vf m = hn::BitCast(d, hn::Sub(bits, hn::ShiftLeft<23>(exponent)));
  const Vf one = hn::Set(d, 1.0F);
  const Vf z = hn::Div(hn::Sub(m, one), hn::Add(m, one)), z2 = hn::Mul(z, z);
  Vf series = hn::Set(d, 2.0F / 7.0F);
  for (const float term : {2.0F / 5.0F, 2.0F / 3.0F, 2.0F})
    series = hn::Add(hn::Mul(series, z2), hn::Set(d, term));
  return hn::Add(hn::Mul(hn::ConvertTo(d, exponent), hn::Set(d, 0.693147181F)), hn::Mul(z, series));
}

/// Angle of (x, y): an odd polynomial (minimax on [0, 1], 4e-8) of the smaller over the larger.
HWY_INLINE Vf angle(Floats d, Vf x, Vf y) {
  const Vf ax = hn::Abs(x), ay = hn::Abs(y);
  const Vf t = hn::Div(hn::Min(ax, ay), hn::Max(hn::Max(ax, ay), hn::Set(d, 1e-20F)));
  const Vf t2 = hn::Mul(t, t);
  Vf series = hn::Set(d, -0.00405455676F);
  for (const float term : {0.0218629205F, -0.0559122735F, 0.0964219347F, -0.139086281F,
                           0.199465654F, -0.333298608F, 0.999999336F})
    series = hn::Add(hn::Mul(series, t2), hn::Set(d, term));
  Vf a = hn::Mul(t, series);
  a = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(d, 1.57079633F), a), a);
  a = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, 3.14159265F), a), a);
  return hn::CopySign(a, y);
}

/// a b + c d
HWY_INLINE Vf sumOfProducts(Vf a, Vf b, Vf c, Vf d) {
  return hn::Add(hn::Mul(a, b), hn::Mul(c, d));
}
