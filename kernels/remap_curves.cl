// Resample one plane along baked curves, strip by strip: one work-item a row.

// Whether a strip's curves all hold and stay inside the plane.
static inline bool strip_is_inside(
    global const struct curve *curves,   // of the strip
    int count)                           // curves in a strip
{
    int kinds = 0;
    for (int n = 0; n < count; ++n)
        kinds |= curves[n].kind;
    return kinds == CURVE_INSIDE;
}

kernel void remap_curves(
    global const WORD *restrict source,  // source plane, from its first sample
    const int source_pitch,              // words from row to row of the source
    global WORD *restrict output,        // output plane, from its first sample
    const int output_pitch,              // words from row to row of the output
    constant struct mapping *map,        // the plane's
    global const struct curve *restrict curves,  // curves_in_row for each output row
    const int curves_in_row,             // curves
    const int length_log2)               // of the output samples in a curve: LANES to STRIP of them
{
    const int row = get_global_id(0), samples = 1 << length_log2, in_strip = STRIP >> length_log2;
    const float scale = 2.0f / (samples - 1);
    real along[STRIP / LANES];           // where on its curve each sample of a strip is, -1 to 1
    for (int v = 0; v < STRIP / LANES; ++v)
        along[v] = ((v * LANES & (samples - 1)) + LANE_NUMBERS) * scale - 1.0f;
    global const struct curve *here = curves + row * curves_in_row;
    for (int column = 0; column < map->output_width; column += STRIP, here += in_strip) {
        const int count = min(STRIP, map->output_width - column);
        global WORD *target = output + (long)row * output_pitch + column * COMPONENTS;
        if (!strip_is_inside(here, in_strip)) {
            remap_exact(map, source, source_pitch, target, column, row, count);
            continue;
        }
        for (int n = 0; n < STRIP * COMPONENTS; n += LINE_WORDS)
            FETCH(target + (long)AHEAD_TARGET * output_pitch + n, 1);
#ifdef LOOKS_UP
        struct window window;
        if (strip_window(map, here, in_strip, &window)) {
            global const WORD *from = source + (long)window.upper * source_pitch + window.left;
            look_up_strip(from, source_pitch, &window, here, length_log2, along, target, count);
            continue;
        }
#endif
        strip_of_int offset, x, y;
        int v = 0;
        for (global const struct curve *curve = here; curve < here + in_strip; ++curve) {
            const int base = curve->base_y * source_pitch + curve->base_x * COMPONENTS;
            for (const int end = v + samples / LANES; v < end; ++v) {
                const whole place_x = places(curve->x, along[v]), place_y = places(curve->y, along[v]);
                offset.lanes[v] = base + (place_y >> 12) * source_pitch + (place_x >> 12) * COMPONENTS;
                x.lanes[v] = place_x & (ONE - 1);
                y.lanes[v] = place_y & (ONE - 1);
            }
        }
        blend_strip(source, source_pitch, map->maximum, &offset, &x, &y, target, count);
    }
}
