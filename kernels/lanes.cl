// Numbers side by side: the same source serves one sample at a time (LANES 1, for GPUs) and vectors of
// neighbouring samples (LANES 8 or 16, for CPUs).
// Build option: LANES.
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#if LANES == 1
#define MANY(type) type
#define LANE_NUMBERS 0.0f
#define ANY(truth) (truth)
#define TO(type, value) JOIN(convert_, type)(value)
#else
#define MANY(type) JOIN(type, LANES)
#if LANES == 8
#define LANE_NUMBERS ((float8)(0, 1, 2, 3, 4, 5, 6, 7))
#else
#define LANE_NUMBERS ((float16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#endif
#define ANY(truths) any(truths)
#define LOAD JOIN(vload, LANES)
#define STORE JOIN(vstore, LANES)
// Clang's own conversion stays one instruction where OpenCL's may fall apart into single lanes.
#ifdef __clang__
#define TO(type, values) __builtin_convertvector(values, MANY(type))
#else
#define TO(type, values) JOIN(convert_, MANY(type))(values)
#endif
#endif
typedef MANY(float) real;
typedef MANY(int) whole;

// The greatest whole number not above a value within what an int holds. (PoCL's floor() and directed
// conversions go lane by lane.)
static inline whole floor_whole(real value)
{
    const whole cut = TO(int, value);
    // A comparison of vectors gives -1 where it holds, one of scalars 1.
#if LANES == 1
    return cut - (value < TO(float, cut));
#else
    return cut + (value < TO(float, cut));
#endif
}
