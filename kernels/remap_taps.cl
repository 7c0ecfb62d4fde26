// Resample one plane strip by strip with exact weights: one work-item a row.
kernel void remap_with_taps(
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
        struct strip_taps taps;
        if (find_taps(map, column, row, &taps) == STRIP_BORDER)
            remap_border(map, source, source_pitch, target, column, row, count);
        else
            remap_taps(source, source_pitch, &taps, map->maximum, target, count);
    }
}
