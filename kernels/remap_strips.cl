// Resample one plane strip by strip, the coordinates worked out on the fly: one work-item a row.
kernel void remap_strips(
    global const WORD *restrict source,  // source plane, from its first sample
    const int source_pitch,              // words from row to row of the source
    global WORD *restrict output,        // output plane, from its first sample
    const int output_pitch,              // words from row to row of the output
    constant struct mapping *map)
{
    const int row = get_global_id(0);
    for (int column = 0; column < map->output_width; column += STRIP) {
        const int count = min(STRIP, map->output_width - column);
        global WORD *target = output + (long)row * output_pitch + column * COMPONENTS;
        strip_of_uint places;
        int2 base;
        if (strip_places(map, column, row, &places, &base) == STRIP_BORDER)
            remap_border(map, source, source_pitch, target, column, row, count);
        else
            remap_places(
                source + (long)base.y * source_pitch + base.x * COMPONENTS, source_pitch, &places, target,
                count);
    }
}
