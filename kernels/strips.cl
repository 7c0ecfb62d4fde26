// Strips of STRIP neighbouring output samples of one row, for CPUs: worked on in vectors of LANES but for the
// loads from the source, which go one sample at a time and read all taps of a row at once.
// Build options: STRIP (a multiple of LANES), RUN (uchar, ushort, uint or ulong: what one load reads).
struct __attribute__((packed)) unaligned_run { RUN bits; };
struct __attribute__((packed)) unaligned_words { MANY(WORD) words; };
#define RUN_WORDS ((int)(sizeof(RUN) / sizeof(WORD)))
// Runs for the taps of one row, and how many samples the last one reaches beyond the last tap.
#define RUNS ((TAPS * COMPONENTS + RUN_WORDS - 1) / RUN_WORDS)
#define OVERRUN ((RUNS * RUN_WORDS - TAPS * COMPONENTS + COMPONENTS - 1) / COMPONENTS)

// Frames come from memory, and so slowly that up to half of the time would be waiting for them. So lines of
// the cache that the next rows will need are asked for ahead: source rows below those of a strip, and output
// rows below the one that is written. To ask for what does not exist does no harm.
#ifdef __clang__
#define FETCH(address, to_write) __builtin_prefetch(address, to_write)
#else
#define FETCH(address, to_write)
#endif
#define AHEAD_SOURCE 4
#define AHEAD_TARGET 3
#define LINE_WORDS (64 / (int)sizeof(WORD))

static inline RUN load_run(global const WORD *from)
{
    return ((global const struct unaligned_run *)from)->bits;
}

// A strip of values, as vectors and one by one.
#define STRIP_OF(type) union { MANY(type) lanes[STRIP / LANES]; type each[STRIP]; }
typedef STRIP_OF(int) strip_of_int;
typedef STRIP_OF(RUN) strip_of_runs;
typedef STRIP_OF(WORD) strip_of_words;

// The values of one word of a strip's runs: VALUES(type of the result, runs of one row of taps, word of the
// row, vector of the strip), without the shift that the words may carry.
#define VALUES(type, runs, word, v) \
    (TO(type, (runs)[(word) / RUN_WORDS].lanes[v] >> (RUN)((word) % RUN_WORDS * 8 * sizeof(WORD))) \
     & (type)((1u << (8 * sizeof(WORD))) - 1))

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

// A strip of which some taps lie beyond the plane, or which no curve describes.
static void remap_exact(
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
            map, source, source_pitch, target + first * COMPONENTS, column + first, row,
            min(LANES, count - first));
}
