// Weights and borders, as endocal/remap/interpolation.py and numpy_engine.py.
// Build option: INTERPOLATION, one of the four.
#define NEAREST 0
#define BILINEAR 1
#define BICUBIC 2
#define LANCZOS 3

#if INTERPOLATION == NEAREST
#define TAPS 1
#define ROUNDING 0.5f
#else
#define TAPS (2 * INTERPOLATION)
#define ROUNDING 0.0f
#endif
#define FIRST_TAP (1 - (TAPS + 1) / 2)

// sin(pi x / 3) / x for 0 <= x <= 1, within 1e-7: its Taylor polynomial.
static inline real lobe(real x)
{
    const real t = x * x;
    return 1.04719755f + t * (-0.19139682f + t * (0.010494495f + t * (-2.7402e-4f + t * 4.1737e-6f)));
}

// cos(pi x / 3) for -1/2 <= x <= 1/2, within 1e-7: its Taylor polynomial.
static inline real crest(real x)
{
    const real t = x * x;
    return 1.0f + t * (-0.54831136f + t * (0.05010756f + t * (-1.8316e-3f + t * 3.587e-5f)));
}

// The weights of the samples around a position; they add up to 1.
static inline void tap_weights(
    real f,           // the position's fraction, 0 to 1
    real *w)          // out: TAPS weights
{
#if INTERPOLATION == NEAREST
    w[0] = 1.0f;
#elif INTERPOLATION == BILINEAR
    w[0] = 1.0f - f;
    w[1] = f;
#elif INTERPOLATION == BICUBIC
    w[0] = ((-0.5f * f + 1.0f) * f - 0.5f) * f;
    w[1] = (1.5f * f - 2.5f) * f * f + 1.0f;
    w[2] = ((-1.5f * f + 2.0f) * f + 0.5f) * f;
    w[3] = (0.5f * f - 0.5f) * f * f;
#else
    // sinc(d) sinc(d/3) goes with sin(pi d) sin(pi d/3) / d^2, at the distances d = f + 2 ... f - 3. The
    // first sine only changes its sign from tap to tap; the second repeats, but for its sign, every third.
    // All are multiplied by f (1 - f) / sin(pi f), so that nothing is divided by zero at a whole position.
    const real u = 1.0f - f;
    const real fu = f * u;
    const real near = lobe(f), far = lobe(u), middle = crest(f - 0.5f);
    w[0] = far * u * fu / ((f + 2.0f) * (f + 2.0f));
    w[1] = -middle * fu / ((f + 1.0f) * (f + 1.0f));
    w[2] = near * u;
    w[3] = far * f;
    w[4] = -middle * fu / ((u + 1.0f) * (u + 1.0f));
    w[5] = near * f * fu / ((u + 2.0f) * (u + 2.0f));
    const real scale = 1.0f / (w[0] + w[1] + w[2] + w[3] + w[4] + w[5]);
    for (int k = 0; k < TAPS; ++k)
        w[k] *= scale;
#endif
}

// How much of a luma pixel centred on a position lies inside the frame along one axis: 1 inside, falling to
// 0 over the pixel beyond the outermost samples. For nearest all or nothing: if the nearest sample exists.
static inline real share_inside(
    real position,    // source samples
    float origin,     // luma coordinate of source sample 0, luma px
    float step,       // luma px per source sample
    int length)       // source samples
{
#if INTERPOLATION == NEAREST
    const real inside = 1.0f, outside = 0.0f;
    return select(outside, inside, (position >= -0.5f) & (position < length - 0.5f));
#else
    const real luma = origin + step * position;
    return clamp(fmin(luma + 1.0f, step * length - luma), 0.0f, 1.0f);
#endif
}
