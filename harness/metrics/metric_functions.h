#pragma once

#include "harness/metrics/metrics.h"
#include "harness/metrics/prepared_pair.h"

namespace occlab {

/// Why psnr, ssim, flip_ldr, ciede2000 and hue_shadow may be unmeasured.
inline constexpr const char* no_exposure =
    "the 99th percentile of the reference's luminance is not positive, so that there is no "
    "exposure";

// The entries of metrics(), whose definitions say what each one is. The pair has no failure.

Measured measure_rmse(const PreparedPair& pair);
Measured measure_relmse(const PreparedPair& pair);
Measured measure_smape(const PreparedPair& pair);
Measured measure_psnr(const PreparedPair& pair);
Measured measure_ssim(const PreparedPair& pair);
Measured measure_flip_ldr(const PreparedPair& pair);
Measured measure_flip_hdr(const PreparedPair& pair);
Measured measure_ciede2000(const PreparedPair& pair);
Measured measure_rgb_angle_shadow(const PreparedPair& pair);
Measured measure_delta_uv_shadow(const PreparedPair& pair);
Measured measure_hue_shadow(const PreparedPair& pair);
Measured measure_shadow_excluded(const PreparedPair& pair);

/// `sigma` in pixels.
Measured high_frequency_residual(const PreparedPair& pair, double sigma);

}  // namespace occlab
