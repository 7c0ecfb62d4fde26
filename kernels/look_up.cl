// Strips of bytes whose taps are looked up in registers, for processors that find 64 bytes in a table of 128
// in one instruction (AVX-512 VBMI): the rows of the source that a strip touches are read whole, a few for
// each strip, in place of two loads for each sample.
// Build option: LOOK_UP, whether to do so where the processor can.
#if LOOK_UP && INTERPOLATION == BILINEAR && WORD_BYTES == 1 && COMPONENTS == 1 && LANES == 16 \
    && STRIP == 64 && defined(__AVX512VBMI__)
#define LOOKS_UP

#define TABLE 128                // bytes of a source row that can be looked up at once
#define TABLE_ROWS 32            // most rows that a strip's taps may span: 5 bits

typedef char bytes __attribute__((ext_vector_type(64)));
typedef uchar numbers __attribute__((ext_vector_type(64)));
typedef short words __attribute__((ext_vector_type(32)));
typedef ushort shares __attribute__((ext_vector_type(32)));
struct __attribute__((packed)) unaligned_bytes { bytes all; };
#define AS(type, value) __builtin_astype(value, type)
#define TWICE(n) n, n
#define FOUR(f, n) f(n), f(n + 2), f(n + 4), f(n + 6)
#define EVERY_OTHER_32(n) \
    n, n + 2, n + 4, n + 6, n + 8, n + 10, n + 12, n + 14, n + 16, n + 18, n + 20, n + 22, n + 24, n + 26, \
    n + 28, n + 30, n + 32, n + 34, n + 36, n + 38, n + 40, n + 42, n + 44, n + 46, n + 48, n + 50, n + 52, \
    n + 54, n + 56, n + 58, n + 60, n + 62
#define SIXTEEN_TWICE(n) FOUR(TWICE, n), FOUR(TWICE, n + 8), FOUR(TWICE, n + 16), FOUR(TWICE, n + 24)

// What a strip sees of the source.
struct window {
    int left, upper;             // its first column and row, source samples
    int rows;                    // source samples
};

// Find the window; whether it is small enough to be looked up in.
static inline bool strip_window(
    constant struct mapping *map,
    global const struct curve *curves,   // of the strip, all inside the plane
    int count,                           // curves in a strip
    struct window *window)               // out
{
    int left = curves->base_x, right = curves->last_x, upper = curves->base_y, lower = curves->last_y;
    for (int n = 1; n < count; ++n) {
        left = min(left, curves[n].base_x), right = max(right, curves[n].last_x);
        upper = min(upper, curves[n].base_y), lower = max(lower, curves[n].last_y);
    }
    // The table ends within the row, so that nothing is read beyond the plane.
    window->left = min(left, map->source_width - TABLE);
    window->upper = upper;
    window->rows = lower + 2 - upper;
    return window->left >= 0 && right + 1 - window->left < TABLE && window->rows <= TABLE_ROWS;
}

// The lower halves of 32 numbers.
static inline words lower_halves(int16 first, int16 second)
{
    return __builtin_shufflevector(AS(words, first), AS(words, second), EVERY_OTHER_32(0));
}

// Places of a strip's samples in its window: 1/256 sample along x, 1/2048 along y, in the lower halves.
static inline __attribute__((always_inline)) void strip_places(
    const struct window *window,         // of the strip
    global const struct curve *curves,   // of the strip
    int length_log2,                     // of the output samples in a curve
    const real *along,                   // where on its curve each sample is, -1 to 1
    int16 *place_x,                      // out: four
    int16 *place_y)                      // out: four
{
    // Adding 1.5 * 2^27 or 2^24 leaves no bits for what is smaller, and none of its own in the lower half.
    #pragma unroll
    for (int v = 0; v < 4; ++v) {
        global const struct curve *curve = curves + (v * LANES >> length_log2);
        const float base_x = curve->x[0] + ONE * (curve->base_x - window->left);
        const float base_y = curve->y[0] + ONE * (curve->base_y - window->upper);
        const real u = along[v];
        const real x = base_x + u * (curve->x[1] + u * (curve->x[2] + u * curve->x[3]));
        const real y = base_y + u * (curve->y[1] + u * (curve->y[2] + u * curve->y[3]));
        place_x[v] = as_int16(x + 0x1.8p27f);
        place_y[v] = as_int16(y + 0x1.8p24f);
    }
}

static void look_up_strip(
    global const WORD *from,             // the window's first sample
    int source_pitch,                    // words from row to row of the source
    const struct window *window,         // of the strip
    global const struct curve *curves,   // of the strip
    int length_log2,                     // of the output samples in a curve
    const real *along,                   // where on its curve each sample is, -1 to 1
    global WORD *target,                 // the strip in the output plane
    int count)                           // output samples
{
    for (int n = 0; n < TABLE; n += LINE_WORDS)
        FETCH(from + (long)(window->rows + AHEAD_SOURCE) * source_pitch + n, 0);
    int16 place_x[4], place_y[4];
    if (STRIP >> length_log2 == 1)       // most often, and quicker
        strip_places(window, curves, 6, along, place_x, place_y);
    else
        strip_places(window, curves, length_log2, along, place_x, place_y);
    bytes index[2], weight[2];           // of the left and the right tap of each sample, side by side
    shares row[2], fraction[2];
    const numbers left_right = AS(numbers, (shares)0x0100);
    #pragma unroll
    for (int h = 0; h < 2; ++h) {
        const bytes x = AS(bytes, lower_halves(place_x[2 * h], place_x[2 * h + 1]));
        const shares y = AS(shares, lower_halves(place_y[2 * h], place_y[2 * h + 1]));
        const numbers part = AS(numbers, __builtin_shufflevector(x, x, SIXTEEN_TWICE(0), SIXTEEN_TWICE(32)));
        const numbers whole_part =
            AS(numbers, __builtin_shufflevector(x, x, SIXTEEN_TWICE(1), SIXTEEN_TWICE(33)));
        // A weight of 256 does not fit a byte: where the fraction is 0, both taps are the left one, and
        // share it as 255 and 1.
        const numbers right = part < (numbers)1 ? (numbers)1 : part;
        weight[h] = AS(bytes, left_right != (numbers)0 ? right : (numbers)0 - right);
        index[h] = AS(bytes, whole_part + (part < left_right ? part : left_right));
        row[h] = y >> (ushort)11;
        fraction[h] = (y & (ushort)2047) << (ushort)4;
    }
    words above[2] = {0, 0}, below[2] = {0, 0};  // taps, two bytes a sample
    for (int r = 0; r < window->rows; ++r, from += source_pitch) {
        const bytes near = ((global const struct unaligned_bytes *)from)->all;
        const bytes far = ((global const struct unaligned_bytes *)(from + 64))->all;
        #pragma unroll
        for (int h = 0; h < 2; ++h) {
            const words taps = AS(words, __builtin_ia32_vpermi2varqi512(near, index[h], far));
            above[h] = row[h] == (shares)(ushort)r ? taps : above[h];
            below[h] = row[h] + (ushort)1 == (shares)(ushort)r ? taps : below[h];
        }
    }
    // Values less 128, times 256: bytes with a sign times bytes without, two products added.
    words value[2];
    #pragma unroll
    for (int h = 0; h < 2; ++h) {
        const words sign = (short)0x8080;
        const words upper = AS(words, __builtin_ia32_pmaddubsw512(weight[h], AS(bytes, above[h] ^ sign)));
        const words lower = AS(words, __builtin_ia32_pmaddubsw512(weight[h], AS(bytes, below[h] ^ sign)));
        // The upper half, rounded, of twice the product.
        value[h] = AS(words, __builtin_ia32_pmulhrsw512(upper, AS(words, (ushort)32767 - fraction[h])))
                 + AS(words, __builtin_ia32_pmulhrsw512(lower, AS(words, fraction[h]))) + (short)128;
    }
    const bytes all = __builtin_shufflevector(
        AS(bytes, value[0]), AS(bytes, value[1]), EVERY_OTHER_32(1), EVERY_OTHER_32(65));
    const numbers result = AS(numbers, all) ^ (uchar)128;
    if (count == STRIP)
        ((global struct unaligned_bytes *)target)->all = AS(bytes, result);
    else
        for (int k = 0; k < count; ++k)
            target[k] = result[k];
}
#endif
