// Strips of STRIP neighbouring output samples of one row, for CPUs: worked on in vectors of LANES but for the
// loads from the source, which go one sample at a time and read all taps of a row at once.
// Build options: STRIP (a multiple of LANES), RUN (ushort, uint or ulong: what one
// load reads), BLEND (ushort or uint: what holds a word times 256).
struct __attribute__((packed)) unaligned_run { RUN bits; };
struct __attribute__((packed)) unaligned_words { MANY(WORD) words; };
#define RUN_WORDS ((int)(sizeof(RUN) / sizeof(WORD)))
// Runs for the taps of one row, and how many samples the last one reaches beyond the last tap.
#define RUNS ((TAPS * COMPONENTS + RUN_WORDS - 1) / RUN_WORDS)
#define OVERRUN ((RUNS * RUN_WORDS - TAPS * COMPONENTS + COMPONENTS - 1) / COMPONENTS)

static inline RUN load_run(global const WORD *from)
{
    return ((global const struct unaligned_run *)from)->bits;
}

// What a strip needs of the source.
#define STRIP_INSIDE 0   // every tap lies in the plane
#define STRIP_BORDER 1   // some lie beyond it

// A strip of values, as vectors and one by one.
#define STRIP_OF(type) union { MANY(type) lanes[STRIP / LANES]; type each[STRIP]; }
typedef STRIP_OF(int) strip_of_int;
typedef STRIP_OF(uint) strip_of_uint;
typedef STRIP_OF(RUN) strip_of_runs;
typedef STRIP_OF(WORD) strip_of_words;

static inline int least(MANY(int) values)
{
#if LANES == 16
    const int8 of8 = min(values.lo, values.hi);
#else
    const int8 of8 = values;
#endif
    const int4 of4 = min(of8.lo, of8.hi);
    const int2 of2 = min(of4.lo, of4.hi);
    return min(of2.lo, of2.hi);
}

// A word of a strip's runs, as BLEND: WORD_OF(runs of one row of taps, word of the row, vector of the strip).
#define WORD_OF(runs, word, v) \
    (TO(BLEND, (runs)[(word) / RUN_WORDS].lanes[v] >> (RUN)((word) % RUN_WORDS * 8 * sizeof(WORD))) \
     & (BLEND)((1u << (8 * sizeof(WORD))) - 1))

// Write one component of a strip.
static inline void put_component(
    const strip_of_words *values,
    int component,               // which of COMPONENTS
    global WORD *target,         // the strip in the output plane
    int count)                   // output samples
{
#if COMPONENTS == 1
    if (count == STRIP) {
        for (int v = 0; v < STRIP / LANES; ++v)
            ((global struct unaligned_words *)target)[v].words = values->lanes[v];
        return;
    }
#endif
    for (int k = 0; k < count; ++k)
        target[k * COMPONENTS + component] = values->each[k];
}

// A strip of which some taps lie beyond the plane.
static void remap_border(
    constant struct mapping *map,
    global const WORD *source,   // source plane, from its first sample
    int source_pitch,            // words from row to row of the source
    global WORD *target,         // the strip in the output plane
    int column,                  // first output sample
    int row,                     // output sample
    int count)                   // output samples
{
    for (int first = 0; first < count; first += LANES)
        remap_anywhere(
            map, source, source_pitch, target + first * COMPONENTS, column + first, row, min(LANES, count - first));
}
