// Resample one plane, each work-item one output sample, its coordinates worked out on the fly: for GPUs.
// LANES is 1.
kernel void remap_direct(
    global const WORD *restrict source,  // source plane, from its first sample
    const int source_pitch,              // words from row to row of the source
    global WORD *restrict output,        // output plane, from its first sample
    const int output_pitch,              // words from row to row of the output
    constant struct mapping *map)        // the plane's
{
    const int column = get_global_id(0), row = get_global_id(1);
    if (column < map->output_width && row < map->output_height)
        remap_anywhere(
            map, source, source_pitch, output + (long)row * output_pitch + column * COMPONENTS,
            column, row, 1);
}
