// Work out all places of a plane once, to be used for every frame until the model changes: one work-item a row.
kernel void bake_places(
    constant struct mapping *map,
    global MANY(uint) *restrict places,  // out: STRIP places for each strip, row after row
    global int4 *restrict strips)        // out: base (source sample), what the strip needs, unused
{
    const int row = get_global_id(0);
    const int count = (map->output_width + STRIP - 1) / STRIP;
    for (int n = 0; n < count; ++n) {
        strip_of_uint here;
        int2 base = 0;
        const int kind = strip_places(map, n * STRIP, row, &here, &base);
        strips[row * count + n] = (int4)(base, kind, 0);
        for (int v = 0; v < STRIP / LANES; ++v)
            places[(row * count + n) * (STRIP / LANES) + v] = here.lanes[v];
    }
}
