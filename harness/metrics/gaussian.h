#pragma once

#include <cstddef>
#include <vector>

namespace occlab {

/// Taps 0 to `radius` of a normalised Gaussian: its centre and one of its sides, weights of the
/// full kernel adding up to 1. `sigma` in pixels.
std::vector<double> gaussian_taps(double sigma, int radius);

/// Separable convolution of a plane (width x height, row-major) with the symmetric kernel `taps` in
/// both directions; outside the plane everything is 0. Multi-threaded.
template <typename T>
std::vector<T> blur(const std::vector<T>& plane, int width, int height,
                    const std::vector<double>& taps);

extern template std::vector<float> blur(const std::vector<float>&, int, int,
                                        const std::vector<double>&);
extern template std::vector<double> blur(const std::vector<double>&, int, int,
                                         const std::vector<double>&);

}  // namespace occlab
