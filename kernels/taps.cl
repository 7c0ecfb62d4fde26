// Resample strips with exact weights, worked out on the fly: for bicubic and lanczos.

// Where the taps of a strip lie and what they weigh.
struct strip_taps {
    strip_of_int x, y;                          // first tap, source samples
    real wx[TAPS][STRIP / LANES];               // weights along x
    real wy[TAPS][STRIP / LANES];               // weights along y
};

// Work out the taps of the strip that starts at an output sample; returns what the strip needs.
static int find_taps(
    constant struct mapping *map,
    int column,                  // first output sample
    int row,                     // output sample
    struct strip_taps *taps)     // out
{
    whole low_x = INT_MAX, low_y = INT_MAX, high_x = INT_MIN, high_y = INT_MIN;
    for (int v = 0; v < STRIP / LANES; ++v) {
        // Beyond the row's end the last sample is repeated.
        const real at = fmin(column + v * LANES + LANE_NUMBERS, (float)(map->output_width - 1));
        real moved_x, moved_y, w[TAPS];
        displacement(map, at, row, &moved_x, &moved_y);
        const whole before_x = floor_whole(moved_x), before_y = floor_whole(moved_y);
        tap_weights(moved_x - TO(float, before_x), w);
        for (int a = 0; a < TAPS; ++a)
            taps->wx[a][v] = w[a];
        tap_weights(moved_y - TO(float, before_y), w);
        for (int b = 0; b < TAPS; ++b)
            taps->wy[b][v] = w[b];
        const whole x = TO(int, at) + before_x + FIRST_TAP, y = row + before_y + FIRST_TAP;
        taps->x.lanes[v] = x, taps->y.lanes[v] = y;
        low_x = min(low_x, x), high_x = max(high_x, x);
        low_y = min(low_y, y), high_y = max(high_y, y);
    }
    return least(low_x) < 0 || least(low_y) < 0 || -least(-high_x) + TAPS + OVERRUN > map->source_width
               || -least(-high_y) + TAPS > map->source_height
           ? STRIP_BORDER : STRIP_INSIDE;
}

// Resample a strip whose taps all lie inside the plane.
static void remap_taps(
    global const WORD *source,   // source plane, from its first sample
    int source_pitch,            // words from row to row of the source
    const struct strip_taps *taps,
    float maximum,               // the largest value that the plane's depth holds
    global WORD *target,         // the strip in the output plane
    int count)                   // output samples
{
    strip_of_runs runs[TAPS][RUNS];
    #pragma clang loop vectorize(disable)
    for (int k = 0; k < STRIP; ++k) {
        global const WORD *from = source + ((long)taps->y.each[k] * source_pitch + taps->x.each[k] * COMPONENTS);
        for (int b = 0; b < TAPS; ++b, from += source_pitch)
            for (int n = 0; n < RUNS; ++n)
                runs[b][n].each[k] = load_run(from + n * RUN_WORDS);
    }
    for (int c = 0; c < COMPONENTS; ++c) {
        strip_of_words values;
        for (int v = 0; v < STRIP / LANES; ++v) {
            real sum = 0.0f;
            #pragma unroll
            for (int b = 0; b < TAPS; ++b) {
                real line = 0.0f;
                #pragma unroll
                for (int a = 0; a < TAPS; ++a)
                    line += taps->wx[a][v] * TO(float, TO(int, WORD_OF(runs[b], a * COMPONENTS + c, v) >> DEPTH_SHIFT));
                sum += taps->wy[b][v] * line;
            }
            const real zero = 0.0f, top = maximum;
            const real value = sum < zero ? zero : sum > top ? top : sum;
            values.lanes[v] = TO(WORD, TO(uint, TO(int, value + 0.5f)) << DEPTH_SHIFT);
        }
        put_component(&values, c, target, count);
    }
}
