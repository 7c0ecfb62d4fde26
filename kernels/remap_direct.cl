// Resample one plane, working out each sample's coordinates on the fly: one work-item an output sample.
kernel void remap_direct(
    global const WORD *restrict source,  // source plane, from its first sample
    const int source_pitch,              // words from row to row of the source
    const int2 source_size,              // samples, (columns, rows)
    global WORD *restrict output,        // output plane, from its first sample
    const int output_pitch,              // words from row to row of the output
    const int2 output_size,              // samples, (columns, rows)
    const float2 origin,                 // luma coordinate of source sample (0, 0), luma px
    const float2 step,                   // luma px per source sample
    const float2 shift,                  // undistorted place of output sample (0, 0), source samples
    const float2 stretch,                // source samples per output sample, less 1
    const float2 center,                 // distortion centre, source samples
    const float2 metric,                 // px of the frame's height per source sample
    const float lam,                     // lambda, px^-2
    const float lam2,                    // second parameter, px^-4
    const float reach,                   // squared undistorted radius that the model reaches, px^2
    const float4 fill)                   // value outside the frame, by component
{
    const int2 index = (int2)(get_global_id(0), get_global_id(1));
    if (index.x >= output_size.x || index.y >= output_size.y)
        return;
    const float2 moved = distort(index, shift, stretch, center, metric, lam, lam2, reach);
    const float2 at = convert_float2(index) + moved;
    const float share = share_inside(at.x, origin.x, step.x, source_size.x)
                      * share_inside(at.y, origin.y, step.y, source_size.y);
    const float fills[4] = {fill.x, fill.y, fill.z, fill.w};
    global WORD *target = output + (long)index.y * output_pitch + index.x * COMPONENTS;
    if (share <= 0.0f) {
        for (int c = 0; c < COMPONENTS; ++c)
            target[c] = (WORD)((uint)fills[c] << DEPTH_SHIFT);
        return;
    }
    const float2 whole = floor(moved + ROUNDING);
    const float2 fraction = moved + ROUNDING - whole;
    float wx[TAPS], wy[TAPS];
    tap_weights(fraction.x, wx);
    tap_weights(fraction.y, wy);
    const int2 first = index + convert_int2(whole) + FIRST_TAP;
    for (int c = 0; c < COMPONENTS; ++c)
        target[c] = sample_anywhere(source + c, source_pitch, source_size, first, wx, wy, share, fills[c]);
}
