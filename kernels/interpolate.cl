// The value of a plane between its samples, as in endocal/remap/interpolation.py and numpy_engine.py.
// Build options: WORD (uchar or ushort), COMPONENTS (per sample), DEPTH_SHIFT (bits from a stored word to its
// value), MAXIMUM (largest value), INTERPOLATION (one of the four below).
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

// sin(pi x / 3) / x for 0 <= x <= 1, to 1e-7.
static inline float lobe(float x)
{
    const float t = x * x;
    return 1.04719755f + t * (-0.19139903f + t * (0.01049493f + t * (-2.7402e-4f + t * 4.1737e-6f)));
}

// The weights of the samples around a position.
static inline void tap_weights(
    float f,          // the position's fraction, 0 to 1
    float *w)         // out: TAPS weights that add up to 1
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
    // sinc(d) sinc(d/3) goes with sin(pi d) sin(pi d/3) / d^2, at the distances d = f + 2 ... f - 3. The first
    // sine only changes its sign from tap to tap; the second repeats, but for its sign, every third tap.
    // All are multiplied by f (1 - f) / sin(pi f), so that nothing is divided by zero at a whole position.
    const float u = 1.0f - f;
    const float fu = f * u;
    const float middle = cospi((f - 0.5f) / 3.0f);
    w[0] = lobe(u) * u * fu / ((f + 2.0f) * (f + 2.0f));
    w[1] = -middle * fu / ((f + 1.0f) * (f + 1.0f));
    w[2] = lobe(f) * u;
    w[3] = lobe(u) * f;
    w[4] = -middle * fu / ((u + 1.0f) * (u + 1.0f));
    w[5] = lobe(f) * f * fu / ((u + 2.0f) * (u + 2.0f));
    const float sum = w[0] + w[1] + w[2] + w[3] + w[4] + w[5];
    for (int k = 0; k < TAPS; ++k)
        w[k] /= sum;
#endif
}

// How much of a luma pixel centred on the position lies inside the frame along one axis, 0 to 1 (for
// nearest: all or nothing). 0 where the position is NaN.
static inline float share_inside(
    float position,   // source samples
    float origin,     // luma coordinate of source sample 0, luma px
    float step,       // luma px per source sample
    int length)       // source samples
{
    const float luma = origin + step * position;
#if INTERPOLATION == NEAREST
    return luma >= -0.5f && luma < step * length - 0.5f ? 1.0f : 0.0f;
#else
    const float inner = fmin(luma + 1.0f, step * length - luma);
    return inner > 0.0f ? fmin(inner, 1.0f) : 0.0f;
#endif
}

// One value at a position that may lie anywhere: samples beyond the plane repeat its edge, and the result
// fades to the fill by the share that lies outside the frame.
static inline WORD sample_anywhere(
    global const WORD *plane,   // the component's word in source sample (0, 0)
    int pitch,                  // words from row to row
    int2 size,                  // source samples, (columns, rows)
    int2 first,                 // index of the first tap, (column, row)
    const float *wx,            // TAPS weights along x
    const float *wy,            // TAPS weights along y
    float share,                // inside the frame, 0 to 1
    float fill)                 // value outside
{
    float value = 0.0f;
    for (int b = 0; b < TAPS; ++b) {
        global const WORD *row = plane + (long)clamp(first.y + b, 0, size.y - 1) * pitch;
        float line = 0.0f;
        for (int a = 0; a < TAPS; ++a)
            line += wx[a] * (row[clamp(first.x + a, 0, size.x - 1) * COMPONENTS] >> DEPTH_SHIFT);
        value += wy[b] * line;
    }
    value = clamp(value, 0.0f, (float)MAXIMUM);
    value += (1.0f - share) * (fill - value);
    return (WORD)((uint)(value + 0.5f) << DEPTH_SHIFT);
}
