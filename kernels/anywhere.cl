// Output samples whose sources may lie anywhere, on the border and outside too.
// Build options: WORD (uchar or ushort), COMPONENTS (words per sample), DEPTH_SHIFT (bits by which a stored
// word is shifted).

// The values at word offsets from a place in the source plane.
static inline real gather(
    global const WORD *from,     // what offset 0 is
    whole offset)                // words
{
#if LANES == 1
    return from[offset] >> DEPTH_SHIFT;
#else
    int each[LANES];
    uint found[LANES];
    STORE(offset, 0, each);
    for (int k = 0; k < LANES; ++k)
        found[k] = from[each[k]];
    return TO(float, TO(int, LOAD(0, found) >> DEPTH_SHIFT));
#endif
}

// Resample neighbouring output samples of a row. Samples beyond the plane repeat its edge; values fade to the
// fill by the share of a luma pixel that lies outside the frame.
static void remap_anywhere(
    constant struct mapping *map,
    global const WORD *source,   // source plane, from its first sample
    int source_pitch,            // words from row to row of the source
    global WORD *target,         // where the first sample goes
    int column,                  // first output sample
    int row,                     // output sample
    int count)                   // output samples, LANES at most
{
    const whole at = column + TO(int, LANE_NUMBERS);
    real moved_x, moved_y, wx[TAPS], wy[TAPS];
    displacement(map, TO(float, at), row, &moved_x, &moved_y);
    const whole whole_x = floor_whole(moved_x + ROUNDING), whole_y = floor_whole(moved_y + ROUNDING);
    tap_weights(moved_x + ROUNDING - TO(float, whole_x), wx);
    tap_weights(moved_y + ROUNDING - TO(float, whole_y), wy);
    const whole x = at + whole_x + FIRST_TAP, y = row + whole_y + FIRST_TAP;
    const real share = share_inside(TO(float, at) + moved_x, map->origin_x, map->step_x, map->source_width)
                     * share_inside(row + moved_y, map->origin_y, map->step_y, map->source_height);
    const bool seen = ANY(share > 0.0f);
    for (int c = 0; c < COMPONENTS; ++c) {
        real value = 0.0f;
        if (seen)
            for (int b = 0; b < TAPS; ++b) {
                const whole line = clamp(y + b, 0, map->source_height - 1) * source_pitch + c;
                real sum = 0.0f;
                for (int a = 0; a < TAPS; ++a)
                    sum += wx[a] * gather(source, line + clamp(x + a, 0, map->source_width - 1) * COMPONENTS);
                value += wy[b] * sum;
            }
        value = clamp(value, 0.0f, map->maximum);
        value += (1.0f - share) * (map->fill[c] - value);
        const MANY(WORD) words = TO(WORD, TO(uint, TO(int, value + 0.5f)) << DEPTH_SHIFT);
#if LANES == 1
        target[c] = words;
#else
        WORD each[LANES];
        STORE(words, 0, each);
        for (int k = 0; k < count; ++k)
            target[k * COMPONENTS + c] = each[k];
#endif
    }
}
