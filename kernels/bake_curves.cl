// Fit the curves of a plane: one work-item a row, LANES curves at a time.
// Build options: STRIP; CURVE_ERROR, the most that a cubic may be off, source samples.

// A cubic through values at four points (Chebyshev's, +-0.924 and +-0.383 of -1 ... 1), and its error.
static inline void fit_cubic(
    const real *at,              // values at -0.924, -0.383, 0.383, 0.924, and what they are at 0 and 1
    real *c,                     // out: four powers
    real *error)                 // in and out: the greatest error yet
{
    const float outer = 0.92387953f, inner = 0.38268343f;
    const float outer2 = outer * outer, inner2 = inner * inner;
    const real even_outer = 0.5f * (at[3] + at[0]);
    const real even_inner = 0.5f * (at[2] + at[1]);
    const real odd_outer = (0.5f / outer) * (at[3] - at[0]);
    const real odd_inner = (0.5f / inner) * (at[2] - at[1]);
    c[2] = (even_outer - even_inner) * (1.0f / (outer2 - inner2));
    c[0] = even_inner - c[2] * inner2;
    c[3] = (odd_outer - odd_inner) * (1.0f / (outer2 - inner2));
    c[1] = odd_inner - c[3] * inner2;
    *error = fmax(*error, fmax(fabs(at[4] - c[0]), fabs(at[5] - (c[0] + c[1] + c[2] + c[3]))));
}

// The least and the greatest that a cubic can reach between -1 and 1: those of its Bernstein coefficients.
static inline void cubic_bounds(
    const real *c,               // four powers
    real *low,                   // out
    real *high)                  // out
{
    const real even = c[0] - c[2] * (1.0f / 3.0f), odd = c[1] * (1.0f / 3.0f) - c[3];
    const real first = c[0] - c[1] + c[2] - c[3], last = c[0] + c[1] + c[2] + c[3];
    *low = fmin(fmin(first, last), even - fabs(odd));
    *high = fmax(fmax(first, last), even + fabs(odd));
}

kernel void bake_curves(
    constant struct mapping *map,            // the plane's
    global struct curve *restrict curves,    // out: curves_in_row for each output row
    const int curves_in_row,                 // curves
    const int length_log2)                   // of the output samples in a curve
{
    const float nodes[6] = {-0.92387953f, -0.38268343f, 0.38268343f, 0.92387953f, 0.0f, 1.0f};
    const int row = get_global_id(0), samples = 1 << length_log2;
    const float half_length = 0.5f * (samples - 1);
    for (int n = 0; n < curves_in_row; n += LANES) {
        const whole start = (n + TO(int, LANE_NUMBERS)) * samples;
        real at_x[6], at_y[6];
        for (int k = 0; k < 6; ++k)
            displacement(map, TO(float, start) + half_length * (1.0f + nodes[k]), row, &at_x[k], &at_y[k]);
        real x[4], y[4], error = 0.0f;
        fit_cubic(at_x, x, &error);
        fit_cubic(at_y, y, &error);
        // From displacements to places: add the sample's own index, less the start.
        x[0] += half_length;
        x[1] += half_length;
        real low_x, low_y, high_x, high_y;
        cubic_bounds(x, &low_x, &high_x);
        cubic_bounds(y, &low_y, &high_y);
        // A little more than rounding may move a place.
        const float margin = 1.0f / 1024.0f;
        const whole base_x = floor_whole(low_x + ROUNDING - margin);
        const whole last_x = floor_whole(high_x + ROUNDING + margin);
        const whole base_y = floor_whole(low_y + ROUNDING - margin);
        const whole last_y = floor_whole(high_y + ROUNDING + margin);
        const whole left = start + base_x + FIRST_TAP, upper = row + base_y + FIRST_TAP;
        const whole inside =
            (error <= CURVE_ERROR) & (left >= 0) & (upper >= 0)
            & (start + last_x + FIRST_TAP + TAPS + OVERRUN <= map->source_width)
            & (row + last_y + FIRST_TAP + TAPS <= map->source_height)
            & (last_x - base_x < 1000) & (last_y - base_y < 1000);
        x[0] += ROUNDING - TO(float, base_x);
        y[0] += ROUNDING - TO(float, base_y);

        union { real lanes[8]; float each[8][LANES]; } powers;
        union { whole lanes[5]; int each[5][LANES]; } facts;
        for (int k = 0; k < 4; ++k) {
            powers.lanes[k] = x[k] * (float)ONE;
            powers.lanes[4 + k] = y[k] * (float)ONE;
        }
        facts.lanes[0] = left, facts.lanes[1] = upper, facts.lanes[2] = inside;
        facts.lanes[3] = left + (last_x - base_x), facts.lanes[4] = upper + (last_y - base_y);
        for (int k = 0; k < min(LANES, curves_in_row - n); ++k) {
            global struct curve *out = curves + row * curves_in_row + n + k;
            for (int p = 0; p < 4; ++p) {
                out->x[p] = powers.each[p][k];
                out->y[p] = powers.each[4 + p][k];
            }
            out->base_x = facts.each[0][k];
            out->base_y = facts.each[1][k];
            out->kind = facts.each[2][k] ? CURVE_INSIDE : CURVE_EXACT;
            out->last_x = facts.each[3][k];
            out->last_y = facts.each[4][k];
        }
    }
}
