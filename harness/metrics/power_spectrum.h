#pragma once

#include <span>
#include <string>
#include <vector>

#include "harness/metrics/noise_bias.h"

namespace occlab {

/// Width of a bin of frequencies, in cycles per pixel: 32 bins up to 1/2, which is the highest
/// frequency along rows and columns, and 14 more up to the diagonals' sqrt(1/2).
inline constexpr double spectrum_bin_width = 1.0 / 64.0;

/// Frequencies of a width x height grid whose distance from 0 is in one bin.
struct SpectrumBin {
  double frequency = 0.0;  ///< the bin's middle, in cycles per pixel
  long count = 0;          ///< how many of the grid's width * height frequencies, at least 1
  double power = 0.0;      ///< their mean power
};

/// Radially averaged power spectra of real fields of width * height values in row-major order:
///
///   P(k) = |sum_x f(x) exp(-2 pi i k.x)|^2 / n
///
/// without a window. With n the number of pixels that count (`norm`), the sum of P over all
/// width * height frequencies, which is the sum of count * power over the bins, is width * height
/// times the mean of f^2 over these pixels (Parseval): power is a density over the unit square of
/// frequencies, and white noise is flat at its variance. Where f is 0 outside a mask, the spectrum
/// is smoothed by the mask's own. Bins without any frequency (of small grids) are left out.
///
/// InputError for a field of another size, a size below 1x1, or norm <= 0.
std::vector<std::vector<SpectrumBin>> radial_spectra(std::span<const std::vector<float>> fields,
                                                     int width, int height, double norm);

/// The spectrum of the noise of K >= 2 runs: of Y_k - mean_k Y, Y being the luminance (of one
/// channel: the value) in units of `mean_luminance`, in which the mean over the runs times
/// K / (K - 1) makes it unbiased. The mean of `power` over all frequencies is therefore the
/// luminance's noise^2. Intervals are for K >= 3, of the logarithm, from the spread of the runs'
/// powers with Student's t; simulated for 8 runs of white noise, nominal 95% cover 94%, and 93% in
/// bins of one to four frequencies.
struct NoiseSpectrum {
  struct Bin {
    double frequency = 0.0;
    long count = 0;
    Estimate power;
  };
  std::vector<Bin> bins;
};

/// InputError for K < 2; where runs hold values that are not finite, or mean_luminance is not
/// positive, every power is empty and says so.
NoiseSpectrum noise_spectrum(const RunStatistics& runs, double mean_luminance,
                             double confidence = 0.95);

}  // namespace occlab
