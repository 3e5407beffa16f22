/* FLIP, the difference that a person sees who flips between two images. Source: P. Andersson, J. Nilsson, T. Akenine-Moller,
 * M. Oskarsson, K. Astrom, M. D. Fairchild, "FLIP: a difference evaluator for alternating images", Proceedings of the ACM on
 * Computer Graphics and Interactive Techniques 3 (2), 2020; the symbols are theirs. Every filter of theirs is a sum of products
 * of one along x and one along y, so that rows are filtered first and kept for as many columns as a filter is high. Beyond the
 * border the outermost pixels go on. */
#include <math.h>

#include "image.h"
#include "power.h"

#define PI  3.14159265358979323846
#define PPD 67.0206432765823 /* 0.7 m before 3840 pixels on 0.7 m: 0.7 (3840 / 0.7) pi / 180 */

enum { Y, CX, CZ, CHANNELS };                                 /* a linear opponent space: luminance, red-green, blue-yellow */
enum { ROW_Y, ROW_CX, ROW_CZ1, ROW_CZ2, COLOUR_ROWS };        /* Gaussians; blue-yellow has two */
enum { ROW_SMOOTH = COLOUR_ROWS, ROW_EDGE, ROW_POINT, ROWS }; /* of luminance: Gaussian, its first and second derivative */

/* What is filtered both ways: the Gaussians by themselves, of edges and points what answers along x and what along y. */
enum { EDGE_X = COLOUR_ROWS, EDGE_Y, POINT_X, POINT_Y, COLUMNS };
static const struct {
    int row, weights;
} columns[COLUMNS] = {
    {ROW_Y, ROW_Y},         {ROW_CX, ROW_CX},       {ROW_CZ1, ROW_CZ1},      {ROW_CZ2, ROW_CZ2},
    {ROW_EDGE, ROW_SMOOTH}, {ROW_SMOOTH, ROW_EDGE}, {ROW_POINT, ROW_SMOOTH}, {ROW_SMOOTH, ROW_POINT},
};

/* Contrast sensitivity, table 1: a sqrt(pi / b) e^(-pi^2 x^2 / b) summed, x in degrees. */
static const double csf_a[COLOUR_ROWS] = {1.0, 1.0, 34.1, 13.5};
static const double csf_b[COLOUR_ROWS] = {0.0047, 0.0053, 0.04, 0.025};

#define FEATURE_WIDTH 0.082 /* degrees: of an edge between its detector's extremes */
#define QC            0.7
#define PC            0.4
#define PT            0.95

typedef struct side {
    const rt_image *image;
    double *padded; /* [CHANNELS][width + 2 reach]: the row that is filtered */
    double *rows;   /* [kept][ROWS][width] */
    double *here;   /* [COLUMNS][width]: filtered along y, too, of the row that is compared */
} side;

typedef struct flip {
    side side[2];
    uint32_t width, height, colour_radius, feature_radius, reach, kept;
    double *weights; /* [ROWS][2 reach + 1], their middle at reach */
    double mix[2];   /* of the two Gaussians of CZ */
    double cmax;     /* the largest colour difference, to the power QC */
} flip;

/* ---- colours ---- */

static const double to_xyz[3][3] = {
    {10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0},
};

/* XYZ by those of white */
static void relative_xyz(const double rgb[3], double to[3])
{
    for (int i = 0; i < 3; i++) {
        const double *m = to_xyz[i];
        to[i] = (m[0] * rgb[0] + m[1] * rgb[1] + m[2] * rgb[2]) / (m[0] + m[1] + m[2]);
    }
}

/* The inverse, by cofactors. */
static void linear_rgb(const double relative[3], double rgb[3])
{
    double xyz[3], det = 0;
    for (int i = 0; i < 3; i++) {
        const double *m = to_xyz[i], *n = to_xyz[(i + 1) % 3], *o = to_xyz[(i + 2) % 3];
        xyz[i] = relative[i] * (m[0] + m[1] + m[2]);
        if (i == 0)
            det = m[0] * (n[1] * o[2] - n[2] * o[1]) + m[1] * (n[2] * o[0] - n[0] * o[2]) + m[2] * (n[0] * o[1] - n[1] * o[0]);
    }
    for (int c = 0; c < 3; c++) {
        int d = (c + 1) % 3, e = (c + 2) % 3;
        double sum = 0;
        for (int i = 0; i < 3; i++) {
            const double *n = to_xyz[(i + 1) % 3], *o = to_xyz[(i + 2) % 3];
            sum += xyz[i] * (n[d] * o[e] - n[e] * o[d]);
        }
        rgb[c] = sum / det;
    }
}

static void opponent(const float *pixel, double to[CHANNELS])
{
    double rgb[3], v[3];
    for (int c = 0; c < 3; c++)
        rgb[c] = pixel[c] > 0.0f ? (pixel[c] < 1.0f ? (double)pixel[c] : 1.0) : 0.0; /* NaN counts as black */
    relative_xyz(rgb, v);
    to[Y] = 116 * v[1] - 16;
    to[CX] = 500 * (v[0] - v[1]);
    to[CZ] = 200 * (v[1] - v[2]);
}

static double lab_curve(double t)
{
    const double delta = 6.0 / 29.0;
    return t > delta * delta * delta ? rti_math_pow(t, 1.0 / 3.0) : t / (3 * delta * delta) + 4.0 / 29.0;
}

/* CIELAB, its colourfulness less where it is dark (Hunt's effect). */
static void hunt_lab(const double rgb[3], double lab[3])
{
    double v[3];
    relative_xyz(rgb, v);
    for (int i = 0; i < 3; i++)
        v[i] = lab_curve(v[i]);
    lab[0] = 116 * v[1] - 16;
    lab[1] = 0.01 * lab[0] * 500 * (v[0] - v[1]);
    lab[2] = 0.01 * lab[0] * 200 * (v[1] - v[2]);
}

/* HyAB, for differences that are large: city blocks between lightness and hue. */
static double distance(const double a[3], const double b[3])
{
    double da = a[1] - b[1], db = a[2] - b[2];
    return fabs(a[0] - b[0]) + sqrt(da * da + db * db);
}

static double largest_distance(void)
{
    static const double green[3] = {0, 1, 0}, blue[3] = {0, 0, 1};
    double a[3], b[3];
    hunt_lab(green, a);
    hunt_lab(blue, b);
    return rti_math_pow(distance(a, b), QC);
}

/* ---- filters ---- */

static double *weights_of(const flip *f, int row)
{
    return f->weights + (size_t)row * (2 * f->reach + 1) + f->reach;
}

/* Positive and negative weights by their own sums, as the paper has it, so that a step of 1 answers with 1. */
static void normalise(double *w, int radius)
{
    double positive = 0, negative = 0;
    for (int i = -radius; i <= radius; i++) {
        positive += w[i] > 0 ? w[i] : 0;
        negative -= w[i] < 0 ? w[i] : 0;
    }
    for (int i = -radius; i <= radius; i++)
        w[i] /= w[i] > 0 ? positive : negative > 0 ? negative : 1;
}

static void make_weights(flip *f, double ppd)
{
    int radius = (int)f->colour_radius;
    double deviation = 0.5 * FEATURE_WIDTH * ppd, area[2], all;
    for (int row = 0; row < COLOUR_ROWS; row++) {
        double *w = weights_of(f, row), sum = 0;
        for (int i = -radius; i <= radius; i++) {
            double x = i / ppd;
            w[i] = rti_math_exp(-PI * PI * x * x / csf_b[row]);
            sum += w[i];
        }
        for (int i = -radius; i <= radius; i++)
            w[i] /= sum;
        if (row >= ROW_CZ1)
            area[row - ROW_CZ1] = csf_a[row] * sqrt(PI / csf_b[row]) * sum * sum;
    }
    all = area[0] + area[1];
    f->mix[0] = area[0] / all;
    f->mix[1] = area[1] / all;
    radius = (int)f->feature_radius;
    for (int i = -radius; i <= radius; i++) {
        double x = i, g = rti_math_exp(-x * x / (2 * deviation * deviation));
        weights_of(f, ROW_SMOOTH)[i] = g;
        weights_of(f, ROW_EDGE)[i] = -x * g;
        weights_of(f, ROW_POINT)[i] = (x * x / (deviation * deviation) - 1) * g;
    }
    for (int row = ROW_SMOOTH; row < ROWS; row++)
        normalise(weights_of(f, row), radius);
}

static double *kept_row(const flip *f, const side *s, uint32_t y, int row)
{
    return s->rows + ((size_t)(y % f->kept) * ROWS + (size_t)row) * f->width;
}

static void pad_row(const flip *f, const side *s, uint32_t y)
{
    const float *p = rti_image_row(s->image, y);
    size_t stride = f->width + 2 * (size_t)f->reach;
    for (size_t i = 0; i < stride; i++) {
        size_t x = i < f->reach ? 0 : i - f->reach < f->width ? i - f->reach : f->width - 1;
        double v[CHANNELS];
        opponent(p + 4 * x, v);
        for (int c = 0; c < CHANNELS; c++)
            s->padded[(size_t)c * stride + i] = v[c];
    }
}

static void filter_row(const flip *f, const side *s, uint32_t y)
{
    static const int channel[ROWS] = {Y, CX, CZ, CZ, Y, Y, Y};
    size_t stride = f->width + 2 * (size_t)f->reach;
    pad_row(f, s, y);
    for (int row = 0; row < ROWS; row++) {
        int radius = (int)(row < COLOUR_ROWS ? f->colour_radius : f->feature_radius);
        const double *w = weights_of(f, row), *from = s->padded + (size_t)channel[row] * stride + f->reach;
        double *to = kept_row(f, s, y, row);
        for (uint32_t x = 0; x < f->width; x++)
            to[x] = 0;
        for (int i = -radius; i <= radius; i++) {
            const double *at = from + i;
            for (uint32_t x = 0; x < f->width; x++)
                to[x] += w[i] * at[x];
        }
    }
}

/* Filters the kept rows along y. */
static void filter_columns(const flip *f, const side *s, uint32_t y)
{
    for (int k = 0; k < COLUMNS; k++) {
        int radius = (int)(k < COLOUR_ROWS ? f->colour_radius : f->feature_radius);
        const double *w = weights_of(f, columns[k].weights);
        double *to = s->here + (size_t)k * f->width;
        for (uint32_t x = 0; x < f->width; x++)
            to[x] = 0;
        for (int i = -radius; i <= radius; i++) {
            int64_t at = (int64_t)y + i;
            at = at < 0 ? 0 : at < f->height ? at : f->height - 1;
            const double *from = kept_row(f, s, (uint32_t)at, columns[k].row);
            for (uint32_t x = 0; x < f->width; x++)
                to[x] += w[i] * from[x];
        }
    }
}

static double filtered(const flip *f, const side *s, uint32_t x, int k)
{
    return s->here[(size_t)k * f->width + x];
}

/* ---- the two pipelines ---- */

static void seen_colour(const flip *f, const side *s, uint32_t x, double lab[3])
{
    double v[3], rgb[3], cz = f->mix[0] * filtered(f, s, x, ROW_CZ1) + f->mix[1] * filtered(f, s, x, ROW_CZ2);
    v[1] = (filtered(f, s, x, ROW_Y) + 16) / 116;
    v[0] = v[1] + filtered(f, s, x, ROW_CX) / 500;
    v[2] = v[1] - cz / 200;
    linear_rgb(v, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] = rgb[i] > 0 ? (rgb[i] < 1 ? rgb[i] : 1) : 0;
    hunt_lab(rgb, lab);
}

/* How strong an edge (EDGE_X) or a point (POINT_X) is; luminance as 0 ... 1. */
static double feature(const flip *f, const side *s, uint32_t x, int kind)
{
    double along_x = filtered(f, s, x, kind) / 116, along_y = filtered(f, s, x, kind + 1) / 116;
    return sqrt(along_x * along_x + along_y * along_y);
}

static double colour_difference(const flip *f, uint32_t x)
{
    double a[3], b[3], d;
    seen_colour(f, &f->side[0], x, a);
    seen_colour(f, &f->side[1], x, b);
    d = rti_math_pow(distance(a, b), QC);
    if (d < PC * f->cmax)
        return PT / (PC * f->cmax) * d;
    return PT + (d - PC * f->cmax) / (f->cmax - PC * f->cmax) * (1 - PT);
}

static double feature_difference(const flip *f, uint32_t x)
{
    double edge = fabs(feature(f, &f->side[0], x, EDGE_X) - feature(f, &f->side[1], x, EDGE_X));
    double point = fabs(feature(f, &f->side[0], x, POINT_X) - feature(f, &f->side[1], x, POINT_X));
    double d = (edge > point ? edge : point) / sqrt(2);
    return d > 0 ? (d < 1 ? sqrt(d) : 1) : 0; /* qf is 0.5 */
}

static double difference(const flip *f, uint32_t x)
{
    double c = colour_difference(f, x), by = 1 - feature_difference(f, x);
    c = c > 0 ? (c < 1 ? c : 1) : 0;
    return c > 0 ? (by > 0 ? rti_math_pow(c, by) : 1) : 0;
}

/* ---- the image ---- */

static double all_pixels(flip *f, rt_image *map)
{
    uint32_t next = 0;
    double sum = 0;
    for (uint32_t y = 0; y < f->height; y++) {
        double row = 0;
        for (; next < f->height && next <= y + f->reach; next++) {
            filter_row(f, &f->side[0], next);
            filter_row(f, &f->side[1], next);
        }
        filter_columns(f, &f->side[0], y);
        filter_columns(f, &f->side[1], y);
        for (uint32_t x = 0; x < f->width; x++) {
            double d = difference(f, x);
            row += d;
            if (map) {
                float *out = rti_image_row(map, y) + 4 * (size_t)x;
                out[0] = out[1] = out[2] = (float)d;
                out[3] = 1.0f;
            }
        }
        sum += row;
    }
    return sum / ((double)f->width * f->height);
}

static rt_status refuse(const rt_image *a, const rt_image *b, double ppd)
{
    if (a->width != b->width || a->height != b->height)
        return rti_fail(a->ctx, RT_ERROR_ARGUMENT, "rt_image_flip: the sizes differ: %u x %u and %u x %u", a->width, a->height,
                        b->width, b->height);
    if (!(ppd >= 1 && ppd <= 1000)) {
        char number[32];
        return rti_fail(a->ctx, RT_ERROR_ARGUMENT, "rt_image_flip: pixels_per_degree is %s; it must be 1 ... 1000, or 0 for 67",
                        rti_num(number, (float)ppd));
    }
    return RT_OK;
}

rt_status rt_image_flip(const rt_image *a, const rt_image *b, double pixels_per_degree, double *mean, rt_image **map)
{
    RTI_NEED_TO_MAKE(map, a);
    RTI_NEED_TO_MAKE(map, b);
    double ppd = pixels_per_degree == 0 ? PPD : pixels_per_degree;
    flip f = {.side = {{.image = a}, {.image = b}}, .width = a->width, .height = a->height};
    rt_image *made = NULL;
    rt_status status;
    if (map)
        *map = NULL;
    status = refuse(a, b, ppd);
    if (status != RT_OK)
        return status;
    f.colour_radius = (uint32_t)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd);
    f.feature_radius = (uint32_t)ceil(3 * 0.5 * FEATURE_WIDTH * ppd);
    f.reach = f.colour_radius > f.feature_radius ? f.colour_radius : f.feature_radius;
    f.kept = 2 * f.reach + 1;
    f.cmax = largest_distance();
    size_t weights = ROWS * (size_t)f.kept * sizeof(double);
    size_t padded = CHANNELS * ((size_t)f.width + 2 * (size_t)f.reach) * sizeof(double);
    size_t rows = (size_t)f.kept * ROWS * f.width * sizeof(double), here = COLUMNS * (size_t)f.width * sizeof(double);
    bool there;
    if (map)
        status = rt_image_create(a->ctx, a->width, a->height, &made);
    if (status != RT_OK)
        return status;
    f.weights = rti_alloc_zero(a->ctx, weights);
    there = f.weights;
    for (int i = 0; i < 2; i++) {
        f.side[i].padded = rti_alloc(a->ctx, padded);
        f.side[i].rows = rti_alloc(a->ctx, rows);
        f.side[i].here = rti_alloc(a->ctx, here);
        there = there && f.side[i].padded && f.side[i].rows && f.side[i].here;
    }
    if (there) {
        double m;
        make_weights(&f, ppd);
        m = all_pixels(&f, made);
        if (mean)
            *mean = m;
    } else {
        status = rti_fail_memory(a->ctx, "rt_image_flip", weights + 2 * (padded + rows + here));
    }
    for (int i = 0; i < 2; i++) {
        rti_free(a->ctx, f.side[i].padded, padded);
        rti_free(a->ctx, f.side[i].rows, rows);
        rti_free(a->ctx, f.side[i].here, here);
    }
    rti_free(a->ctx, f.weights, weights);
    if (status != RT_OK)
        rt_image_destroy(made);
    else if (map)
        *map = made;
    return status;
}
