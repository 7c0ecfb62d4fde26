// Where each output sample of a plane comes from, as endocal/remap/grid.py.

// One plane's mapping: what its layout, the view and the model determine. endocal/remap/opencl_mapping.py
// fills it.
struct mapping {
    int source_width, source_height;   // source plane, samples
    int output_width, output_height;   // output plane, samples
    float origin_x, origin_y;          // luma coordinate of source sample (0, 0), luma px
    float step_x, step_y;              // luma px per source sample
    float shift_x, shift_y;            // undistorted place of output sample (0, 0), source samples
    float stretch_x, stretch_y;        // source samples per output sample, less 1
    float center_x, center_y;          // distortion centre, source samples
    float metric_x, metric_y;          // px of the frame's height per source sample
    float lam;                         // lambda, px^-2
    float lam2;                        // second parameter, px^-4
    float limit;                       // distorted radius up to which the model holds, px
    float reach;                       // squared undistorted radius up to which the model reaches, px^2
    float maximum;                     // the largest value that the plane's depth holds
    float fill[4];                     // value outside the frame, by component
};

// Where nothing maps to, and the farthest that anything does: outside every frame, source samples.
#define NOWHERE (-1.0e6f)

// How far the source of output samples lies from their own index, in source samples: exactly 0 where the view
// shifts and the model distorts nothing.
static inline void displacement(
    constant struct mapping *map,
    real column,      // output samples
    float row,        // output sample
    real *moved_x,    // out: source samples
    real *moved_y)    // out: source samples
{
    const real from_x = column - map->center_x;
    const float from_y = row - map->center_y;
    const real x = from_x + (map->shift_x + map->stretch_x * column);
    const float y = from_y + (map->shift_y + map->stretch_y * row);
    const real square_x = x * map->metric_x;
    const float square_y = y * map->metric_y;
    const real q = square_x * square_x + square_y * square_y;
    const real ratio = radial_ratio(q, map->lam, map->lam2, map->limit);
    const real nowhere = NOWHERE;
    *moved_x = select(nowhere, clamp(x * ratio - from_x, NOWHERE, -NOWHERE), q <= map->reach);
    *moved_y = select(nowhere, clamp(y * ratio - from_y, NOWHERE, -NOWHERE), q <= map->reach);
}
