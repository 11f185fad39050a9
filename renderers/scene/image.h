#pragma once

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

namespace occlab {

/// A float image: row-major, top row first, channels interleaved, linear values unless stated.
class Image {
 public:
  Image() = default;
  Image(int width, int height, int channels, float fill = 0.0f)
      : width_(width),
        height_(height),
        channels_(channels),
        values_(std::size_t(width) * std::size_t(height) * std::size_t(channels), fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int channels() const { return channels_; }
  bool empty() const { return values_.empty(); }
  std::size_t pixel_count() const { return std::size_t(width_) * std::size_t(height_); }
  bool same_size(const Image& other) const {
    return width_ == other.width_ && height_ == other.height_;
  }

  /// The channels of the pixel in column x and row y; row 0 is the top.
  std::span<float> pixel(int x, int y) {
    return {values_.data() + offset(x, y), std::size_t(channels_)};
  }
  std::span<const float> pixel(int x, int y) const {
    return {values_.data() + offset(x, y), std::size_t(channels_)};
  }
  float& at(int x, int y, int channel = 0) { return values_[offset(x, y) + std::size_t(channel)]; }
  float at(int x, int y, int channel = 0) const {
    return values_[offset(x, y) + std::size_t(channel)];
  }

  /// All values in storage order.
  std::span<float> values() { return values_; }
  std::span<const float> values() const { return values_; }

  bool operator==(const Image&) const = default;

 private:
  std::size_t offset(int x, int y) const {
    assert(x >= 0 && x < width_ && y >= 0 && y < height_);
    return (std::size_t(y) * std::size_t(width_) + std::size_t(x)) * std::size_t(channels_);
  }

  int width_ = 0;
  int height_ = 0;
  int channels_ = 0;
  std::vector<float> values_;
};

}  // namespace occlab
