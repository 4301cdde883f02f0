#pragma once
// The rules of the contract, one function each. Everything is 128 bits wide; widths are applied
// only where a rule names them.

#include "oracle.hpp"

namespace oracle {

__extension__ typedef __int128 Int;

/// Width of a wire. Rule 1: a value that does not fit saturates.
struct Width {
  int bits;
  bool is_signed;
  Int lowest() const { return is_signed ? -(Int{1} << (bits - 1)) : Int{0}; }
  Int highest() const { return (Int{1} << (is_signed ? bits - 1 : bits)) - 1; }
  bool holds(Int value) const { return value >= lowest() && value <= highest(); }
};

/// Rule 1: writes a wire, saturating and counting.
Int writeWire(Int value, Width width, int64_t& counter);

/// Coordinates with 6 fraction bits (rule 2), or a pixel that a test has found invalid.
struct Point {
  bool valid = true;
  Int x = 0, y = 0;
};

/// Integer pixel of an image (rule 5).
struct Address {
  bool valid = false;
  int u = 0, v = 0;
};
using AddressImage = std::vector<Address>;

struct LinePixel {
  int64_t u;
  int v;
};
using Line = std::vector<LinePixel>;

// Rules 2 to 6: where a pixel of the output grid comes from.
Point homography(const Params& p, const Point& in, int fraction_bits, Wires& w);
bool belowHorizon(const Params& p, int u, int v);
Point distort(const Params& p, const Point& in, int64_t& xn_counter, int64_t& yn_counter, Wires& w);
Address address(const Params& p, const Point& distorted);
AddressImage referenceAddresses(const Params& p, Wires& w);
AddressImage currentAddresses(const Params& p, Wires& w);
void countReadWrite(const Params& p, const AddressImage& reference, Wires& w);

// Rules 7 to 9: images.
std::vector<uint16_t> difference(const Inputs& in, const AddressImage& reference,
                                 const AddressImage& current);
std::vector<uint16_t> gaussian(const Params& p, const std::vector<uint16_t>& difference);
std::vector<int64_t> histogram(const std::vector<uint16_t>& gaussian);
std::vector<uint8_t> binarise(const Params& p, const std::vector<uint16_t>& gaussian);
int otsu(int threshold_in, const std::vector<int64_t>& histogram, Wires& w);
std::vector<uint8_t> erode(const Params& p, const std::vector<uint8_t>& mask);

// Rules 11 to 15: localisation.
Line beamLine(const Params& p, int i, Wires& w);
int bearing(const Params& p, const std::vector<uint8_t>& eroded, const Line& line, Wires& w);
Contact contact(const Params& p, const std::vector<uint8_t>& eroded, const Line& line, int i,
                Wires& w);
std::vector<uint32_t> peaks(const Params& p, const std::vector<int>& bear, Wires& w);
std::vector<uint32_t> select(const Params& p, const std::vector<uint32_t>& peaks,
                             const std::vector<Contact>& cor, Wires& w);

}  // namespace oracle
