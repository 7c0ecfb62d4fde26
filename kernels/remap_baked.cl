// Resample one plane by the places that bake_places left: one work-item a row.
kernel void remap_baked(
    global const WORD *restrict source,  // source plane, from its first sample
    const int source_pitch,              // words from row to row of the source
    global WORD *restrict output,        // output plane, from its first sample
    const int output_pitch,              // words from row to row of the output
    constant struct mapping *map,
    global const MANY(uint) *restrict places,  // STRIP places for each strip, row after row
    global const int4 *restrict strips)  // base (source sample), what the strip needs, unused
{
    const int row = get_global_id(0);
    const int in_row = (map->output_width + STRIP - 1) / STRIP;
    for (int n = 0; n < in_row; ++n) {
        const int column = n * STRIP;
        const int4 strip = strips[row * in_row + n];
        const int count = min(STRIP, map->output_width - column);
        global WORD *target = output + (long)row * output_pitch + column * COMPONENTS;
        if (strip.z == STRIP_BORDER) {
            remap_border(map, source, source_pitch, target, column, row, count);
            continue;
        }
        strip_of_uint here;
        for (int v = 0; v < STRIP / LANES; ++v)
            here.lanes[v] = places[(row * in_row + n) * (STRIP / LANES) + v];
        remap_places(
            source + (long)strip.y * source_pitch + strip.x * COMPONENTS, source_pitch, &here, target,
            count);
    }
}
