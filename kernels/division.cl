// The inverse of the division model, as DivisionModel.radial_ratio in endocal/model.py (Lee et al. 2013,
// doi:10.1109/TBME.2013.2261816, eq. 1 and 4), in single precision.
// Build option: NEWTON_STEPS.

// r_d / r_u for an undistorted radius r_u that the model reaches; exactly 1 without distortion.
static inline real radial_ratio(
    real q,           // r_u squared, px^2
    float lam,        // lambda, px^-2
    float lam2)       // second parameter, px^-4
{
    const real a = lam * q;
    real ratio = 2.0f / (1.0f + sqrt(fmax(1.0f - 4.0f * a, 0.0f)));
    if (lam2 == 0.0f)
        return ratio;
    // m = r_d / r_u solves m = 1 + a m^2 + b m^4. Newton from the root of the one-parameter model.
    const real b = lam2 * q * q;
    for (int k = 0; k < NEWTON_STEPS; ++k) {
        const real m = ratio * ratio;
        const real value = (1.0f - ratio) + m * (a + b * m);
        const real slope = ratio * (2.0f * a + 4.0f * b * m) - 1.0f;
        // At the wanted root the slope is negative: it is held so on the way there.
        ratio = clamp(ratio - value / fmin(slope, -0.02f), 0.0f, 2.0f);
    }
    return ratio;
}
