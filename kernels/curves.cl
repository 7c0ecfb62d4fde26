// Where a run of output samples of one row comes from, as a cubic: baked once a model, a few bytes a sample.
// Within a few dozen samples a cubic through four exact places is as good as the exact place of each; where
// it is not, the curve says so and its samples are worked out one by one.

#define ONE 4096                 // a source sample, in the units of places
#define CURVE_INSIDE 0           // every tap lies in the plane and the cubic holds
#define CURVE_EXACT 1            // samples must be worked out one by one

struct curve {
    float x[4], y[4];            // place from the base, 1 / ONE source sample: factors of u^0 ... u^3,
                                 // u running from -1 (first sample) to 1 (last sample)
    int base_x, base_y;          // first tap of the least place, source samples
    int last_x, last_y;          // first tap of the greatest place, source samples
    int kind;                    // CURVE_INSIDE or CURVE_EXACT
};

// Places of neighbouring samples in whole numbers. Adding 1.5 * 2^23 leaves no bits for a fraction, so that
// the sum's own bits hold the rounded number; right for less than 2^22.
static inline whole places(
    global const float *c,       // a curve's x or y
    real u)                      // where on the curve, -1 to 1
{
    const real place = c[0] + u * (c[1] + u * (c[2] + u * c[3]));
    return JOIN(as_, MANY(int))(place + 12582912.0f) - 0x4B400000;
}
