#pragma once
// Fixed point with the format in the type: width, integer bits, sign, rounding and overflow.
//
// Sums and products widen their type so that they are always exact; only an explicit
// conversion rounds, saturates or refuses. That is how the datapath is drawn: full-width
// operators between registers of a stated format.

#include <cstdint>
#include <optional>
#include <type_traits>

namespace ipm_mapping::fpga {

enum class Sign { Unsigned, Signed };

/// What a conversion does with fraction bits that its format cannot hold.
enum class Rounding { Floor, TowardZero, NearestAway };

/// What a conversion does with a value that its format cannot hold. Exact: the compiler proves
/// that it cannot happen. Refuse: fit() returns nothing.
enum class Overflow { Exact, Saturate, Refuse };

__extension__ typedef __int128 Int128;

/// Value raw · 2^-FractionBits. IntegerBits counts the sign bit of a signed format.
template <int Width, int IntegerBits, Sign S = Sign::Signed, Rounding R = Rounding::Floor,
          Overflow O = Overflow::Exact>
class Fixed {
 public:
  static constexpr int width = Width;
  static constexpr int integer_bits = IntegerBits;
  static constexpr int fraction_bits = Width - IntegerBits;
  static constexpr bool is_signed = S == Sign::Signed;
  static constexpr Sign sign = S;
  static constexpr Rounding rounding = R;
  static constexpr Overflow overflow = O;
  /// Integer bits that a signed format needs to hold every value of this one.
  static constexpr int signed_integer_bits = IntegerBits + (is_signed ? 0 : 1);

  static_assert(Width >= 1 && Width <= 126, "wider than any wire of the datapath");
  using Raw = std::conditional_t<(Width <= 62), std::int64_t, Int128>;

  constexpr Fixed() = default;
  static constexpr Fixed fromRaw(Raw raw) { return Fixed(raw); }

  [[nodiscard]] constexpr Raw raw() const { return raw_; }
  static constexpr Raw lowest() { return is_signed ? -(Raw{1} << (Width - 1)) : Raw{0}; }
  static constexpr Raw highest() {
    return is_signed ? (Raw{1} << (Width - 1)) - 1 : (Raw{1} << Width) - 1;
  }

 private:
  explicit constexpr Fixed(Raw raw) : raw_(raw) {}
  Raw raw_ = 0;
};

/// An integer of so many bits.
template <int Width, Overflow O = Overflow::Exact>
using Unsigned = Fixed<Width, Width, Sign::Unsigned, Rounding::Floor, O>;
template <int Width, Overflow O = Overflow::Exact>
using Signed = Fixed<Width, Width, Sign::Signed, Rounding::Floor, O>;

template <class Raw>
constexpr Raw floorShift(Raw raw, int bits) {
  return bits >= 0 ? raw >> bits : raw * (Raw{1} << -bits);
}

/// raw / 2^bits, rounded; a negative count multiplies.
template <Rounding R, class Raw>
constexpr Raw roundedShift(Raw raw, int bits) {
  if (bits <= 0) return floorShift(raw, bits);
  const Raw step = Raw{1} << bits;
  if constexpr (R == Rounding::TowardZero) return raw / step;
  if constexpr (R == Rounding::NearestAway) {
    const Raw half = step / 2;
    return raw >= 0 ? (raw + half) >> bits : -((-raw + half) >> bits);
  }
  return raw >> bits;
}

namespace detail {
constexpr int maxOf(int a, int b) { return a > b ? a : b; }

template <class A, class B>
struct Sum {
  static constexpr bool is_signed = A::is_signed || B::is_signed;
  static constexpr int fraction = maxOf(A::fraction_bits, B::fraction_bits);
  static constexpr int integer =
      1 + (is_signed ? maxOf(A::signed_integer_bits, B::signed_integer_bits)
                     : maxOf(A::integer_bits, B::integer_bits));
  using Type = Fixed<integer + fraction, integer, is_signed ? Sign::Signed : Sign::Unsigned>;
};

template <class A, class B>
struct Difference {
  static constexpr int fraction = maxOf(A::fraction_bits, B::fraction_bits);
  static constexpr int integer = 1 + maxOf(A::signed_integer_bits, B::signed_integer_bits);
  using Type = Fixed<integer + fraction, integer, Sign::Signed>;
};

template <class A, class B>
struct Product {
  static constexpr bool is_signed = A::is_signed || B::is_signed;
  using Type = Fixed<A::width + B::width, A::integer_bits + B::integer_bits,
                     is_signed ? Sign::Signed : Sign::Unsigned>;
};

/// The raw value of a number with more fraction bits.
template <class To, class From>
constexpr typename To::Raw alignedRaw(From value) {
  static_assert(To::fraction_bits >= From::fraction_bits);
  return static_cast<typename To::Raw>(value.raw()) *
         (typename To::Raw{1} << (To::fraction_bits - From::fraction_bits));
}
}  // namespace detail

template <int W1, int I1, Sign S1, Rounding R1, Overflow O1, int W2, int I2, Sign S2, Rounding R2,
          Overflow O2>
constexpr auto operator+(Fixed<W1, I1, S1, R1, O1> a, Fixed<W2, I2, S2, R2, O2> b) {
  using Type = typename detail::Sum<decltype(a), decltype(b)>::Type;
  return Type::fromRaw(detail::alignedRaw<Type>(a) + detail::alignedRaw<Type>(b));
}

template <int W1, int I1, Sign S1, Rounding R1, Overflow O1, int W2, int I2, Sign S2, Rounding R2,
          Overflow O2>
constexpr auto operator-(Fixed<W1, I1, S1, R1, O1> a, Fixed<W2, I2, S2, R2, O2> b) {
  using Type = typename detail::Difference<decltype(a), decltype(b)>::Type;
  return Type::fromRaw(detail::alignedRaw<Type>(a) - detail::alignedRaw<Type>(b));
}

template <int W1, int I1, Sign S1, Rounding R1, Overflow O1, int W2, int I2, Sign S2, Rounding R2,
          Overflow O2>
constexpr auto operator*(Fixed<W1, I1, S1, R1, O1> a, Fixed<W2, I2, S2, R2, O2> b) {
  using Type = typename detail::Product<decltype(a), decltype(b)>::Type;
  return Type::fromRaw(static_cast<typename Type::Raw>(a.raw()) *
                       static_cast<typename Type::Raw>(b.raw()));
}

/// Removes fraction bits (toward minus infinity) until FractionBits are left.
template <int FractionBits, class From>
constexpr auto dropFraction(From value) {
  static_assert(From::fraction_bits >= FractionBits);
  using Type = Fixed<From::integer_bits + FractionBits, From::integer_bits, From::sign>;
  return Type::fromRaw(
      static_cast<typename Type::Raw>(value.raw() >> (From::fraction_bits - FractionBits)));
}

/// numerator / denominator with FractionBits fraction bits, truncated toward 0.
/// The denominator must not be 0.
template <int FractionBits, class N, class D>
constexpr auto divide(N numerator, D denominator) {
  constexpr int shift = FractionBits + D::fraction_bits - N::fraction_bits;
  static_assert(shift >= 0, "the numerator would lose bits before the division");
  using Type = Fixed<N::width + shift + 2, N::width + shift + 2 - FractionBits, Sign::Signed>;
  using Raw = typename Type::Raw;
  const Raw shifted = static_cast<Raw>(numerator.raw()) * (Raw{1} << shift);
  return Type::fromRaw(shifted / static_cast<Raw>(denominator.raw()));
}

/// A value in To's fraction bits, rounded To's way, not yet limited to its width.
template <class To, class From>
constexpr auto roundedRaw(From value) {
  using Raw = std::conditional_t<(sizeof(typename From::Raw) > sizeof(typename To::Raw)),
                                 typename From::Raw, typename To::Raw>;
  return roundedShift<To::rounding>(static_cast<Raw>(value.raw()),
                                    From::fraction_bits - To::fraction_bits);
}

template <class To, class Raw>
constexpr bool fits(Raw raw) {
  return raw >= To::lowest() && raw <= To::highest();
}

/// Conversion that refuses what does not fit.
template <class To, class From>
constexpr std::optional<To> fit(From value) {
  static_assert(To::overflow == Overflow::Refuse, "To states another overflow rule");
  const auto raw = roundedRaw<To>(value);
  if (!fits<To>(raw)) return std::nullopt;
  return To::fromRaw(static_cast<typename To::Raw>(raw));
}

/// Saturating conversion; count grows by one when the value does not fit.
template <class To, class From>
constexpr To saturate(From value, std::uint64_t& count) {
  static_assert(To::overflow == Overflow::Saturate, "To states another overflow rule");
  const auto raw = roundedRaw<To>(value);
  if (fits<To>(raw)) return To::fromRaw(static_cast<typename To::Raw>(raw));
  ++count;
  return To::fromRaw(raw < 0 || raw < To::lowest() ? To::lowest() : To::highest());
}

/// Conversion that cannot overflow, proved by the types.
template <class To, class From>
constexpr To widen(From value) {
  static_assert(To::is_signed ? To::integer_bits >= From::signed_integer_bits
                              : !From::is_signed && To::integer_bits >= From::integer_bits,
                "To is too narrow");
  return To::fromRaw(static_cast<typename To::Raw>(roundedRaw<To>(value)));
}

}  // namespace ipm_mapping::fpga
