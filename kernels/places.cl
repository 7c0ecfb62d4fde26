// The places of a strip's samples in 8 + 8 bits: for nearest and bilinear.
//
// A place is how far a sample's source lies from the strip's base, a whole source sample at or before all of
// them: x in the lower 16 bits and y in the upper, each in 1/256 source sample.
#define ONE 256                  // a source sample

// A displacement in 1/256 source sample, rounded to the nearest. Adding 1.5 * 2^23 leaves no bits for a
// fraction, so that the sum's own bits hold the whole number, right for less than 2^22 of them.
static inline whole nearest_fraction(
    real moved)                  // source samples
{
    const real limit = 16383.0f;
    const real held = moved < -limit ? -limit : moved > limit ? limit : moved;
    return JOIN(as_, MANY(int))(held * (float)ONE + 12582912.0f) - 0x4B400000;
}

// Work out the places of the strip that starts at an output sample; returns what the strip needs.
static int strip_places(
    constant struct mapping *map,
    int column,                  // first output sample
    int row,                     // output sample
    strip_of_uint *places,       // out
    int2 *base)                  // out: source sample
{
    MANY(int) x[STRIP / LANES], y[STRIP / LANES];
    MANY(int) low_x = INT_MAX, low_y = INT_MAX, high_x = INT_MIN, high_y = INT_MIN;
    for (int v = 0; v < STRIP / LANES; ++v) {
        // Beyond the row's end the last sample is repeated.
        const real at = fmin(column + v * LANES + LANE_NUMBERS, (float)(map->output_width - 1));
        real moved_x, moved_y;
        displacement(map, at, row, &moved_x, &moved_y);
#if INTERPOLATION == NEAREST
        x[v] = (TO(int, at) + floor_whole(moved_x + ROUNDING)) * ONE;
        y[v] = (row + floor_whole(moved_y + ROUNDING)) * ONE;
#else
        x[v] = TO(int, at) * ONE + nearest_fraction(moved_x);
        y[v] = row * ONE + nearest_fraction(moved_y);
#endif
        low_x = min(low_x, x[v]), high_x = max(high_x, x[v]);
        low_y = min(low_y, y[v]), high_y = max(high_y, y[v]);
    }
    const int first_x = least(low_x) >> 8, first_y = least(low_y) >> 8;
    const int last_x = -least(-high_x) >> 8, last_y = -least(-high_y) >> 8;
    if (first_x < 0 || first_y < 0 || last_x + TAPS + OVERRUN > map->source_width
        || last_y + TAPS > map->source_height || last_x - first_x > 255 || last_y - first_y > 255)
        return STRIP_BORDER;
    for (int v = 0; v < STRIP / LANES; ++v)
        places->lanes[v] = TO(uint, (x[v] - first_x * ONE) | ((y[v] - first_y * ONE) << 16));
    *base = (int2)(first_x, first_y);
    return STRIP_INSIDE;
}

// Resample a strip whose taps all lie inside the plane.
static void remap_places(
    global const WORD *source,   // the strip's base in the source plane
    int source_pitch,            // words from row to row of the source
    const strip_of_uint *places,
    global WORD *target,         // the strip in the output plane
    int count)                   // output samples
{
    strip_of_int offset;         // of the upper left tap, words
    for (int v = 0; v < STRIP / LANES; ++v) {
        const MANY(uint) place = places->lanes[v];
        offset.lanes[v] =
            TO(int, (place >> 24) * (uint)source_pitch + ((place >> 8) & 255u) * (uint)COMPONENTS);
    }
#if INTERPOLATION == NEAREST
    for (int k = 0; k < count; ++k)
        for (int c = 0; c < COMPONENTS; ++c)
            target[k * COMPONENTS + c] = source[offset.each[k] + c];
#else
    strip_of_runs upper[RUNS], lower[RUNS];
    #pragma clang loop vectorize(disable) unroll_count(8)
    for (int k = 0; k < STRIP; ++k) {
        global const WORD *from = source + offset.each[k];
        for (int n = 0; n < RUNS; ++n) {
            upper[n].each[k] = load_run(from + n * RUN_WORDS);
            lower[n].each[k] = load_run(from + n * RUN_WORDS + source_pitch);
        }
    }
    for (int c = 0; c < COMPONENTS; ++c) {
        const int left = c, right = COMPONENTS + c;
        strip_of_words values;
        for (int v = 0; v < STRIP / LANES; ++v) {
            const MANY(uint) place = places->lanes[v];
            const MANY(BLEND) fx = TO(BLEND, place & 255u);
            const MANY(uint) fy = (place >> 16) & 255u;
            const MANY(BLEND) top = WORD_OF(upper, left, v) * ((BLEND)ONE - fx) + WORD_OF(upper, right, v) * fx;
            const MANY(BLEND) bottom = WORD_OF(lower, left, v) * ((BLEND)ONE - fx) + WORD_OF(lower, right, v) * fx;
            const MANY(uint) sum = TO(uint, top) * ((uint)ONE - fy) + TO(uint, bottom) * fy;
            const uint rounding = 1u << (15 + DEPTH_SHIFT);
            values.lanes[v] = TO(WORD, ((sum + rounding) >> (16 + DEPTH_SHIFT)) << DEPTH_SHIFT);
        }
        put_component(&values, c, target, count);
    }
#endif
}
