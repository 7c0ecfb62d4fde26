// The values of a strip whose taps all lie inside the plane, by the interpolation.

#if INTERPOLATION == BILINEAR && WORD_BYTES == 1
// Whole numbers of 16 bits: values times 256, and the upper half of their product with a share of 65536.
static inline MANY(ushort) share_of(MANY(ushort) value, MANY(ushort) share)
{
    return TO(ushort, TO(uint, value) * TO(uint, share) >> 16);
}

// With 8 bits of the fraction along x, 12 along y, and an error of 2/256 of a level from the halves cut off.
static inline MANY(WORD) blend(
    const strip_of_runs (*runs)[RUNS],   // of the two rows of taps
    int component,                       // which of COMPONENTS
    whole x,                             // fraction, in 1 / ONE source sample
    whole y,                             // fraction, in 1 / ONE source sample
    float maximum,                       // the largest value; a mean of values never exceeds it
    int v)                               // vector of the strip
{
    const int left = component, right = COMPONENTS + component;
    const MANY(ushort) fx = TO(ushort, (x + 8) >> 4), gx = (ushort)256 - fx;
    const MANY(ushort) fy = TO(ushort, y << 4), gy = (ushort)65535 - fy;
    const MANY(ushort) top =
        VALUES(ushort, runs[0], left, v) * gx + VALUES(ushort, runs[0], right, v) * fx;
    const MANY(ushort) bottom =
        VALUES(ushort, runs[1], left, v) * gx + VALUES(ushort, runs[1], right, v) * fx;
    return TO(WORD, (share_of(top, gy) + share_of(bottom, fy) + (ushort)128) >> (ushort)8);
}
#elif INTERPOLATION != NEAREST
static inline MANY(WORD) blend(
    const strip_of_runs (*runs)[RUNS],   // of the rows of taps
    int component,                       // which of COMPONENTS
    whole x,                             // fraction, in 1 / ONE source sample
    whole y,                             // fraction, in 1 / ONE source sample
    float maximum,                       // the largest value that the plane's depth holds
    int v)                               // vector of the strip
{
    real wx[TAPS], wy[TAPS], sum = 0.0f;
    tap_weights(TO(float, x) * (1.0f / ONE), wx);
    tap_weights(TO(float, y) * (1.0f / ONE), wy);
    #pragma unroll
    for (int b = 0; b < TAPS; ++b) {
        real line = 0.0f;
        #pragma unroll
        for (int a = 0; a < TAPS; ++a) {
            const MANY(uint) words = VALUES(uint, runs[b], a * COMPONENTS + component, v);
            line += wx[a] * TO(float, TO(int, words >> DEPTH_SHIFT));
        }
        sum += wy[b] * line;
    }
    const real zero = 0.0f, most = maximum;
    const real value = sum < zero ? zero : sum > most ? most : sum;
    return TO(WORD, TO(uint, TO(int, value + 0.5f)) << DEPTH_SHIFT);
}
#endif

static void blend_strip(
    global const WORD *source,       // source plane, from its first sample
    int source_pitch,                // words from row to row of the source
    float maximum,                   // the largest value that the plane's depth holds
    const strip_of_int *offset,      // of each sample's first tap, words
    const strip_of_int *x,           // fraction, in 1 / ONE source sample
    const strip_of_int *y,           // fraction, in 1 / ONE source sample
    global WORD *target,             // the strip in the output plane
    int count)                       // output samples
{
#if INTERPOLATION == NEAREST
    for (int k = 0; k < count; ++k)
        for (int c = 0; c < COMPONENTS; ++c)
            target[k * COMPONENTS + c] = source[offset->each[k] + c];
#else
    for (int k = 0; k < STRIP; k += max(LINE_WORDS / COMPONENTS, 1))
        FETCH(source + offset->each[k] + (long)(TAPS + AHEAD_SOURCE) * source_pitch, 0);
    strip_of_runs runs[TAPS][RUNS];
    global const WORD *lines[TAPS];      // the source, down by one row each
    for (int b = 0; b < TAPS; ++b)
        lines[b] = source + b * source_pitch;
    #pragma clang loop vectorize(disable) unroll_count(2)
    for (int k = 0; k < STRIP; ++k) {
        const int from = offset->each[k];
        #pragma unroll
        for (int b = 0; b < TAPS; ++b)
            #pragma unroll
            for (int n = 0; n < RUNS; ++n)
                runs[b][n].each[k] = load_run(lines[b] + from + n * RUN_WORDS);
    }
#if COMPONENTS == 1
    if (count == STRIP) {
        for (int v = 0; v < STRIP / LANES; ++v)
            ((global struct unaligned_words *)target)[v].words =
                blend(runs, 0, x->lanes[v], y->lanes[v], maximum, v);
        return;
    }
#endif
    for (int c = 0; c < COMPONENTS; ++c) {
        strip_of_words values;
        for (int v = 0; v < STRIP / LANES; ++v)
            values.lanes[v] = blend(runs, c, x->lanes[v], y->lanes[v], maximum, v);
        put_component(&values, c, target, count);
    }
#endif
}
