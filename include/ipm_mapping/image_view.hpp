#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace ipm_mapping {

/// A window onto pixels owned by somebody else (a message, a workspace, an OpenCV matrix).
/// `stride` counts elements, not bytes, from one row to the next.
template <class Pixel>
struct ImageView {
  Pixel* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;

  ImageView() = default;
  ImageView(Pixel* pixels, int w, int h) : ImageView(pixels, w, h, w) {}
  ImageView(Pixel* pixels, int w, int h, std::ptrdiff_t elements_per_row)
      : data(pixels), width(w), height(h), stride(elements_per_row) {}

  /// A writable view serves where a read-only one is asked for.
  template <class Other, class = std::enable_if_t<std::is_same_v<const Other, Pixel>>>
  ImageView(const ImageView<Other>& other)  // NOLINT(google-explicit-constructor)
      : ImageView(other.data, other.width, other.height, other.stride) {}

  [[nodiscard]] Pixel* row(int v) const { return data + v * stride; }
  [[nodiscard]] Pixel& at(int u, int v) const { return row(v)[u]; }
  [[nodiscard]] bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  [[nodiscard]] bool contains(int u, int v) const {
    return u >= 0 && v >= 0 && u < width && v < height;
  }
  template <class Other>
  [[nodiscard]] bool sameSize(const ImageView<Other>& other) const {
    return width == other.width && height == other.height;
  }
};

using GrayView = ImageView<const std::uint8_t>;
using GrayBuffer = ImageView<std::uint8_t>;

/// An image that owns its pixels: rows are contiguous, and `padding` spare elements follow the
/// last row so that wide loads may read past the end.
template <class Pixel>
class Image {
 public:
  static constexpr std::size_t padding = 64;

  Image() = default;
  Image(int width, int height, Pixel value = Pixel{}) { resize(width, height, value); }

  /// Gives the image this size and every pixel this value; keeps the memory where it suffices.
  void resize(int width, int height, Pixel value = Pixel{}) {
    width_ = width;
    height_ = height;
    pixels_.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) + padding,
                   value);
  }
  /// As resize(), but leaves the pixels alone when the size is already right.
  void ensure(int width, int height) {
    if (width != width_ || height != height_) resize(width, height);
  }

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool empty() const { return width_ == 0 || height_ == 0; }
  [[nodiscard]] Pixel* row(int v) { return view().row(v); }
  [[nodiscard]] const Pixel* row(int v) const { return view().row(v); }
  [[nodiscard]] Pixel& at(int u, int v) { return row(v)[u]; }
  [[nodiscard]] const Pixel& at(int u, int v) const { return row(v)[u]; }
  [[nodiscard]] ImageView<Pixel> view() { return {pixels_.data(), width_, height_}; }
  [[nodiscard]] ImageView<const Pixel> view() const { return {pixels_.data(), width_, height_}; }

 private:
  int width_ = 0;
  int height_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace ipm_mapping
