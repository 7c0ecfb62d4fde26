// The inverse of the division model, as DivisionModel.radial_ratio in endocal/model.py (Lee et al. 2013,
// doi:10.1109/TBME.2013.2261816, eq. 1 and 4), in single precision.
// Build option: NEWTON_STEPS, the most that are taken.

// r_d / r_u for an undistorted radius r_u that the model reaches; exactly 1 without distortion.
static inline real radial_ratio(
    real q,           // r_u squared, px^2
    float lam,        // lambda, px^-2
    float lam2,       // second parameter, px^-4
    float limit)      // distorted radius up to which the model holds, px
{
    real ratio = 2.0f / (1.0f + sqrt(fmax(1.0f - 4.0f * lam * q, 0.0f)));
    if (lam2 == 0.0f)
        return ratio;
    // m = r_d / r_u solves 1 + p (lambda + lambda2 p) = m, p = m^2 r_u^2 being the distorted radius squared:
    // once between 0, where the left is greater, and the limit. Newton from the root of the one-parameter
    // model, within what is left of that bracket; a step that leaves it (near a fold, or far from the root)
    // halves it instead.
    real low = 0.0f, high = limit * (1.0f / sqrt(q));
    ratio = fmin(ratio, high);
    for (int k = 0; k < NEWTON_STEPS; ++k) {
        const real stretched = q * ratio, p = stretched * ratio;
        const real value = (1.0f - ratio) + p * (lam + lam2 * p);
        const real slope = 2.0f * stretched * (lam + 2.0f * lam2 * p) - 1.0f;
        low = select(low, ratio, value > 0.0f);
        high = select(ratio, high, value > 0.0f);
        const real step = ratio - value / slope;
        const real next = select(0.5f * (low + high), step, (step >= low) & (step <= high));
        const whole moves = fabs(next - ratio) > 3e-7f * next;
        ratio = next;
        if (!ANY(moves))
            break;
    }
    return ratio;
}
