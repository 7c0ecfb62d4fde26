// The division model's inverse, as in endocal/model.py (Lee et al. 2013, eq. 1 and 4), single precision.

// r_d / r_u - 1 of an undistorted point: exactly 0 where there is no distortion, NaN where no distorted
// point maps there. Written as a difference from 1, so that the displacement keeps its digits.
static inline float radial_excess(
    float q,          // squared undistorted radius, px^2
    float lam,        // lambda, px^-2
    float lam2,       // second parameter, px^-4
    float reach)      // squared undistorted radius that the model reaches, px^2 (INFINITY: everywhere)
{
    const float a = lam * q;
#if TWO_PARAMETERS
    // m = r_d / r_u solves m = 1 + a m^2 + b m^4. Newton on the excess m - 1, from the one-parameter root.
    const float b = lam2 * q * q;
    const float s = sqrt(fmax(1.0f - 4.0f * a, 0.0f));
    float excess = 4.0f * a / ((1.0f + s) * (1.0f + s));
    for (int k = 0; k < NEWTON_STEPS; ++k) {
        const float m = 1.0f + excess;
        const float m2 = m * m;
        const float value = m2 * (a + b * m2) - excess;
        const float slope = m * (2.0f * a + 4.0f * b * m2) - 1.0f;
        // The slope at the wanted root is negative: hold it so on the way there.
        excess = clamp(excess - value / fmin(slope, -0.02f), -1.0f, 1.0f);
    }
    return q < reach ? excess : NAN;
#else
    const float s = sqrt(1.0f - 4.0f * a);
    return 4.0f * a / ((1.0f + s) * (1.0f + s));
#endif
}

// How far the distorted place of an output sample lies from the sample's own index, in source samples.
static inline float2 distort(
    int2 index,       // output sample, (column, row)
    float2 shift,     // source samples
    float2 stretch,   // source samples per output sample, less 1
    float2 center,    // distortion centre, source samples
    float2 metric,    // px per source sample
    float lam,        // px^-2
    float lam2,       // px^-4
    float reach)      // px^2
{
    const float2 at = convert_float2(index);
    const float2 extra = shift + stretch * at;
    const float2 offset = (at - center) + extra;
    const float2 square = offset * metric;
    const float q = square.x * square.x + square.y * square.y;
    return extra + offset * radial_excess(q, lam, lam2, reach);
}
