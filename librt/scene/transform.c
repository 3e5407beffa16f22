/* Affine maps: making, inverting, and how far rounding can carry a ray that goes through one.
 *
 * The growth of an instance's world box. A ray (o, d) prepared for the top level has |o| <= 4 S and its hits |o + t d| <= S, S
 * the largest coordinate of the grown boxes. The object ray is o' = fl(W o), d' = fl(W d) with W the inverse of M rounded once:
 * per row four products and sums, so with u = 2^-24 |o' - W o| <= 5 u (|W| |o| + |w|),   |d' - W d| <= 4 u |W| |d|,   |t d| <= 5
 * S. A hit's object point q = o' + t d' lies in the child's grown box, hence the world point lies off M q by at most |M| (5 u (4
 * |W| S + |w|) + 20 u |W| S) = u (40 |M| |W| S + 5 |M| |w|). The code takes 1.5 times that. With |M| |W| limited to 10^5 (rows
 * summed) the part with S stays below S / 2, so one step from the ungrown boxes bounds S itself.
 */
#include "scene.h"

#include <math.h>
#include <string.h>

#define CONDITION_MAX 1.0e5

rt_transform rt_transform_identity(void)
{
    rt_transform t = {{1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f}};
    return t;
}

rt_transform rt_transform_translate(rt_vec3 by)
{
    rt_transform t = rt_transform_identity();
    t.m[3] = by.x;
    t.m[7] = by.y;
    t.m[11] = by.z;
    return t;
}

rt_transform rt_transform_scale(rt_vec3 by)
{
    rt_transform t = rt_transform_identity();
    t.m[0] = by.x;
    t.m[5] = by.y;
    t.m[10] = by.z;
    return t;
}

/* Sine and cosine of an angle in degrees, exact at multiples of 90. */
static void sincos_degrees(double degrees, double *s, double *c)
{
    const double radians = 0.017453292519943295;
    double turn = floor(degrees / 90.0 + 0.5), rest = (degrees - 90.0 * turn) * radians;
    double a = sin(rest), b = cos(rest);
    int quarter = (int)(turn - 4.0 * floor(turn / 4.0));
    *s = quarter == 0 ? a : (quarter == 1 ? b : (quarter == 2 ? -a : -b));
    *c = quarter == 0 ? b : (quarter == 1 ? -a : (quarter == 2 ? -b : a));
}

rt_transform rt_transform_rotate(rt_vec3 axis, float degrees)
{
    rti_fpenv env = rti_fp_enter();
    rt_transform t = rt_transform_identity();
    double x, y, z, l, s, c, k;
    RTI_FP_HOLD(axis);
    RTI_FP_HOLD(degrees);
    x = axis.x;
    y = axis.y;
    z = axis.z;
    if ((x == 0.0 && y == 0.0 && z == 0.0) || !(fabsf(degrees) <= 1.0e9f)) {
        rti_fp_leave(env);
        return t;
    }
    l = sqrt(x * x + y * y + z * z);
    x /= l;
    y /= l;
    z /= l;
    sincos_degrees(degrees, &s, &c);
    k = 1.0 - c;
    t.m[0] = (float)(c + x * x * k);
    t.m[1] = (float)(x * y * k - z * s);
    t.m[2] = (float)(x * z * k + y * s);
    t.m[4] = (float)(y * x * k + z * s);
    t.m[5] = (float)(c + y * y * k);
    t.m[6] = (float)(y * z * k - x * s);
    t.m[8] = (float)(z * x * k - y * s);
    t.m[9] = (float)(z * y * k + x * s);
    t.m[10] = (float)(c + z * z * k);
    RTI_FP_HOLD(t);
    rti_fp_leave(env);
    return t;
}

rt_transform rt_transform_multiply(rt_transform a, rt_transform b)
{
    rt_transform t;
    rti_fpenv env = rti_fp_enter();
    RTI_FP_HOLD(a);
    RTI_FP_HOLD(b);
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 4; c++) {
            double sum = c == 3 ? a.m[4 * r + 3] : 0.0;
            for (int k = 0; k < 3; k++)
                sum += (double)a.m[4 * r + k] * b.m[4 * k + c];
            t.m[4 * r + c] = (float)sum;
        }
    }
    RTI_FP_HOLD(t);
    rti_fp_leave(env);
    return t;
}

bool rti_xfm_invert(const rtk_xfm *a, rtk_xfm *out)
{
    double m[12], w[12], det, most = 0.0;
    for (int i = 0; i < 12; i++)
        m[i] = a->m[i];
    w[0] = m[5] * m[10] - m[6] * m[9];
    w[1] = m[2] * m[9] - m[1] * m[10];
    w[2] = m[1] * m[6] - m[2] * m[5];
    w[4] = m[6] * m[8] - m[4] * m[10];
    w[5] = m[0] * m[10] - m[2] * m[8];
    w[6] = m[2] * m[4] - m[0] * m[6];
    w[8] = m[4] * m[9] - m[5] * m[8];
    w[9] = m[1] * m[8] - m[0] * m[9];
    w[10] = m[0] * m[5] - m[1] * m[4];
    det = m[0] * w[0] + m[1] * w[4] + m[2] * w[8];
    if (!(fabs(det) > 0.0))
        return false;
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            w[4 * r + c] /= det;
        w[4 * r + 3] = -(w[4 * r] * m[3] + w[4 * r + 1] * m[7] + w[4 * r + 2] * m[11]);
    }
    for (int r = 0; r < 3; r++) {
        double sum = 0.0;
        for (int k = 0; k < 3; k++)
            sum += fabs(m[4 * r + k]) * (fabs(w[4 * k]) + fabs(w[4 * k + 1]) + fabs(w[4 * k + 2]));
        most = fmax(most, sum);
    }
    for (int i = 0; i < 12; i++) {
        if (!(fabs(w[i]) <= 1.0e30))
            return false;
        out->m[i] = (float)w[i];
    }
    return most <= CONDITION_MAX;
}

void rti_xfm_bounds(const rtk_xfm *to_world, const float lo[3], const float hi[3], float out_lo[3], float out_hi[3])
{
    const float *m = to_world->m;
    for (int r = 0; r < 3; r++) {
        double low = m[4 * r + 3], high = low;
        for (int c = 0; c < 3; c++) {
            double a = (double)m[4 * r + c] * lo[c], b = (double)m[4 * r + c] * hi[c];
            low += fmin(a, b);
            high += fmax(a, b);
        }
        out_lo[r] = nextafterf((float)low, -INFINITY);
        out_hi[r] = nextafterf((float)high, INFINITY);
    }
}

bool rti_xfm_turns(const rtk_xfm *a)
{
    bool turns = false;
    for (int r = 0; r < 3; r++) {
        const float *row = a->m + 4 * r;
        turns |= (row[0] != 0.0f) + (row[1] != 0.0f) + (row[2] != 0.0f) > 1;
    }
    return turns;
}

void rti_xfm_cover(const rtk_xfm *to_world, const float (*boxes)[6], uint32_t count, float lo[3], float hi[3])
{
    for (int r = 0; r < 3; r++) {
        const float *row = to_world->m + 4 * r;
        const int x = row[0] < 0.0f ? 3 : 0, y = row[1] < 0.0f ? 4 : 1, z = row[2] < 0.0f ? 5 : 2;
        double low = INFINITY, high = -INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            const float *b = boxes[i];
            const double least = (double)row[0] * b[x] + (double)row[1] * b[y] + (double)row[2] * b[z];
            const double most = (double)row[0] * b[3 - x] + (double)row[1] * b[5 - y] + (double)row[2] * b[7 - z];
            low = least < low ? least : low;
            high = most > high ? most : high;
        }
        lo[r] = fmaxf(lo[r], nextafterf((float)(low + row[3]), -INFINITY));
        hi[r] = fminf(hi[r], nextafterf((float)(high + row[3]), INFINITY));
    }
}

void rti_xfm_growth(const rtk_xfm *to_world, const rtk_xfm *to_object, float reach, float out[3])
{
    const float *m = to_world->m, *w = to_object->m;
    const double u = 1.5 / 16777216.0;
    for (int r = 0; r < 3; r++) {
        double sum = 0.0;
        for (int k = 0; k < 3; k++) {
            double row = fabs((double)w[4 * k]) + fabs((double)w[4 * k + 1]) + fabs((double)w[4 * k + 2]);
            sum += fabs((double)m[4 * r + k]) * (40.0 * row * reach + 5.0 * fabs((double)w[4 * k + 3]));
        }
        out[r] = (float)(u * sum);
    }
}
