#pragma once

#include <cstdint>
#include <utility>

namespace occlab {

/// Scrambles the bits of a number.
inline std::uint32_t hash(std::uint32_t value) {
  // PCG output permutation [Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"].
  const std::uint32_t state = value * 747796405u + 2891336453u;
  const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

/// The R2 sequence [Roberts 2018], shifted at random: stratified, and unbiased over the shifts.
class PointSequence {
 public:
  PointSequence(std::uint64_t seed, std::uint32_t tile, std::uint32_t batch,
                std::uint32_t purpose) {
    std::uint32_t state = hash(std::uint32_t(seed)) ^ std::uint32_t(seed >> 32);
    for (const std::uint32_t part : {tile, batch, purpose}) state = hash(state ^ hash(part));
    u_ = hash(state);
    v_ = hash(u_ + 0x9e3779b9u);
  }
  std::pair<float, float> next() {
    u_ += 3242174889u;  // 2^32 / plastic number
    v_ += 2447445414u;  // 2^32 / plastic number^2
    return {float(u_ >> 8) * 0x1p-24f, float(v_ >> 8) * 0x1p-24f};
  }

 private:
  std::uint32_t u_;
  std::uint32_t v_;
};

/// Independent points: a second R2 sequence beside a first one would go along with it, whatever
/// their shifts.
class RandomPoints {
 public:
  RandomPoints(std::uint64_t seed, std::uint32_t tile, std::uint32_t batch, std::uint32_t purpose)
      : state_(hash(std::uint32_t(seed)) ^ std::uint32_t(seed >> 32)) {
    for (const std::uint32_t part : {tile, batch, purpose}) state_ = hash(state_ ^ hash(part));
  }
  std::pair<float, float> next() {
    const float u = float(hash(state_++) >> 8) * 0x1p-24f;
    const float v = float(hash(state_++) >> 8) * 0x1p-24f;
    return {u, v};
  }

 private:
  std::uint32_t state_;
};

}  // namespace occlab
