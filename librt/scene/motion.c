/* The ways of moving instances: keys into segments, the box of all times, and how far rounding can carry a ray.
 *
 * Sizes are Frobenius norms. Over all times let size bound |S|, condition = size * inverse where inverse bounds |S^-1| (a
 * straight line between definite matrices is no nearer to singular than its ends: the smallest eigenvalue is concave), T bound
 * |T(u)|, rho the child's corners, u = 2^-24. What kernels compute, W' and M', is off by: R': the quaternion's angle, sine,
 * cosine and sum, then the matrix, cost at most 100 u; R' is orthogonal but for 20 u. S^-1: entries rounded from doubled
 * arithmetic (or at the commit), 4 u inverse; W' = S^-1 R'^T adds 6 u inverse. In all |W' - W| <= 120 u inverse; its exact
 * inverse M* is off M by 1.01 |M| |W' - W| |M| <= 122 u size condition. T' and w' = -W' T': the place that W' maps to the child's
 * origin is off T by 12 u condition T. So M* q lies off M q by u condition (122 size rho + 12 T) for q in the child's box. A ray
 * with |org| <= 4 reach per coordinate whose hits lie within reach (transform.c) is mapped with 5 u (|W'| |o| + |w'|) and 4 u
 * |W'| |t d|, which is condition u (72 reach + 5 T) when mapped back. The growth is 1.5 times all of that. For shading, M' W'
 * differs from the identity by 20 u + 14 u condition and the translations by 6 u condition T: surface.h takes condition u (24
 * size |p| + 8 T).
 *
 * The box: in a piece of a segment that turns by a every point strays from its chord by at most max |p''| / 8 with p'' <= a^2 |S
 * x| + 2 a |dS x|, so the boxes at the ends of the piece, grown by that, hold it.
 */
#include "scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "../kernel/maths.h"

#define CONDITION_MAX 1.0e4
#define SCALE_MAX     1.0e9
#define PIECES_MAX    64

typedef struct mat3 {
    double m[9];
} mat3;

static double det3(const mat3 *a)
{
    const double *m = a->m;
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/* Transposed inverse; of a matrix whose determinant is not zero. */
static mat3 cofactors(const mat3 *a)
{
    const double *m = a->m, d = det3(a);
    mat3 c = {{m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6], m[2] * m[7] - m[1] * m[8],
               m[0] * m[8] - m[2] * m[6], m[1] * m[6] - m[0] * m[7], m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5],
               m[0] * m[4] - m[1] * m[3]}};
    for (int i = 0; i < 9; i++)
        c.m[i] /= d;
    return c;
}

static double norm(const double *m, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += m[i] * m[i];
    return sqrt(sum);
}

/* Of xx xy xz yy yz zz. */
static double symmetric_norm(const double *s)
{
    return sqrt(s[0] * s[0] + s[3] * s[3] + s[5] * s[5] + 2.0 * (s[1] * s[1] + s[2] * s[2] + s[4] * s[4]));
}

/* The rotation of a matrix's polar decomposition (Higham 1986: Newton's iteration, scaled). */
static mat3 nearest_rotation(mat3 q)
{
    for (int k = 0; k < 64; k++) {
        mat3 c = cofactors(&q);
        double g = sqrt(norm(c.m, 9) / norm(q.m, 9)), change = 0.0;
        for (int i = 0; i < 9; i++) {
            double next = 0.5 * (g * q.m[i] + c.m[i] / g);
            change = fmax(change, fabs(next - q.m[i]));
            q.m[i] = next;
        }
        if (change < 1.0e-15)
            break;
    }
    return q;
}

typedef struct key {
    double t[3], q[4], s[6]; /* s negative definite where the key mirrors */
    double sign;
} key;

static void quaternion(const mat3 *r, double q[4])
{
    const double *m = r->m;
    double x = 1.0 + m[0] - m[4] - m[8], y = 1.0 - m[0] + m[4] - m[8], z = 1.0 - m[0] - m[4] + m[8], w = 1.0 + m[0] + m[4] + m[8],
           l;
    if (w >= x && w >= y && w >= z)
        memcpy(q, (double[]){m[7] - m[5], m[2] - m[6], m[3] - m[1], w}, 4 * sizeof *q);
    else if (x >= y && x >= z)
        memcpy(q, (double[]){x, m[1] + m[3], m[2] + m[6], m[7] - m[5]}, 4 * sizeof *q);
    else if (y >= z)
        memcpy(q, (double[]){m[1] + m[3], y, m[5] + m[7], m[2] - m[6]}, 4 * sizeof *q);
    else
        memcpy(q, (double[]){m[2] + m[6], m[5] + m[7], z, m[3] - m[1]}, 4 * sizeof *q);
    l = norm(q, 4);
    for (int i = 0; i < 4; i++)
        q[i] /= l;
}

static key key_of(const rtk_xfm *x)
{
    key k;
    mat3 a, r;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            a.m[3 * i + j] = x->m[4 * i + j];
        k.t[i] = x->m[4 * i + 3];
    }
    k.sign = det3(&a) < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 9; i++)
        a.m[i] *= k.sign;
    r = nearest_rotation(a);
    quaternion(&r, k.q);
    for (int i = 0, at = 0; i < 3; i++) {
        for (int j = i; j < 3; j++, at++) { /* R^T A, made symmetric */
            double one = 0.0, other = 0.0;
            for (int l = 0; l < 3; l++) {
                one += r.m[3 * l + i] * a.m[3 * l + j];
                other += r.m[3 * l + j] * a.m[3 * l + i];
            }
            k.s[at] = k.sign * 0.5 * (one + other);
        }
    }
    return k;
}

static mat3 full(const double s[6])
{
    return (mat3){{s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]}};
}

static void symmetric_inverse(const double s[6], double inv[6])
{
    mat3 a = full(s), c = cofactors(&a);
    memcpy(inv, (double[]){c.m[0], c.m[1], c.m[2], c.m[4], c.m[5], c.m[8]}, 6 * sizeof *inv);
}

/* size and condition of a segment's ends, NULL or what is wrong with them. */
static const char *measure(const rtk_motion *m, double *size, double *inverse)
{
    double most = 0.0, least = DBL_MAX;
    for (int end = 0; end < 2; end++) {
        double s[6], inv[6], n, i;
        for (int k = 0; k < 6; k++)
            s[k] = m->s0[k] + (double)end * m->ds[k];
        symmetric_inverse(s, inv);
        n = symmetric_norm(s);
        i = sqrt(3.0) * symmetric_norm(inv);
        if (!(n > 0.0 && n < INFINITY && i > 0.0 && i < INFINITY))
            return "stretch by nothing";
        most = fmax(most, n);
        least = fmin(least, 1.0 / i);
    }
    if (!(most <= SCALE_MAX && least >= 1.0 / SCALE_MAX))
        return "scale by a factor that is not from 1e-9 to 1e9";
    *size = fmax(*size, most);
    *inverse = fmax(*inverse, 1.0 / least);
    return *size * *inverse <= CONDITION_MAX ? NULL : "stretch by more than 1000 to 1";
}

static void make_segment(const key *a, const key *b, rtk_motion *out)
{
    double d = 0.0, p[4], n, s = 1.0, most = 0.0;
    memset(out, 0, sizeof *out);
    for (int i = 0; i < 4; i++)
        d += a->q[i] * b->q[i];
    if (d < 0.0) { /* the same rotation, by the shorter way */
        s = -1.0;
        d = -d;
    }
    for (int i = 0; i < 4; i++)
        p[i] = s * b->q[i] - d * a->q[i];
    n = norm(p, 4);
    out->angle = n > 1.0e-9 ? rtk_atan2((float)n, (float)d) : 0.0f;
    for (int i = 0; i < 4; i++) {
        out->q0[i] = (float)a->q[i];
        out->q1[i] = n > 1.0e-9 ? (float)(p[i] / n) : 0.0f;
    }
    for (int i = 0; i < 3; i++) {
        out->t0[i] = (float)a->t[i];
        out->dt[i] = (float)(b->t[i] - a->t[i]);
    }
    for (int i = 0; i < 6; i++) {
        out->s0[i] = (float)a->s[i];
        most = fmax(most, fabs(b->s[i] - a->s[i]));
    }
    if (most <= 1.0e-6 * symmetric_norm(a->s)) { /* the rounding of the keys' own floats */
        double s0[6], inv[6];
        for (int i = 0; i < 6; i++)
            s0[i] = out->s0[i];
        symmetric_inverse(s0, inv);
        for (int i = 0; i < 6; i++)
            out->inv[i] = (float)inv[i];
        out->flags = RTK_MOTION_RIGID;
        return;
    }
    for (int i = 0; i < 6; i++)
        out->ds[i] = (float)(b->s[i] - a->s[i]);
}

const char *rti_motion_make(const rtk_xfm *keys, uint32_t segments, rtk_motion *out)
{
    double size = 0.0, inverse = 0.0;
    key a = key_of(&keys[0]), b;
    for (uint32_t i = 0; i < segments; i++, a = b) {
        const char *fault;
        b = key_of(&keys[i + 1]);
        if (a.sign != b.sign)
            return "mirror space at one place and not at the next";
        make_segment(&a, &b, &out[i]);
        if ((fault = measure(&out[i], &size, &inverse)) != NULL)
            return fault;
    }
    for (uint32_t i = 0; i < segments; i++) {
        out[i].size = nextafterf((float)size, INFINITY);
        out[i].condition = nextafterf((float)(size * inverse), INFINITY);
    }
    return NULL;
}

bool rti_motion_sound(const rtk_motion *m, uint32_t segments)
{
    double size = 0.0, inverse = 0.0;
    for (uint32_t i = 0; i < segments; i++) {
        double a = 0.0, b = 0.0, ab = 0.0, first = 0.0;
        const float *s = m[i].s0;
        for (int k = 0; k < 4; k++) {
            a += (double)m[i].q0[k] * m[i].q0[k];
            b += (double)m[i].q1[k] * m[i].q1[k];
            ab += (double)m[i].q0[k] * m[i].q1[k];
        }
        if (!(fabs(a - 1.0) < 1.0e-4 && fabs(ab) < 1.0e-4 && m[i].angle >= 0.0f && m[i].angle < 1.58f) ||
            !(m[i].angle == 0.0f ? b == 0.0 : fabs(b - 1.0) < 1.0e-4) || (m[i].flags & ~RTK_MOTION_RIGID))
            return false;
        for (int k = 0; k < 3; k++)
            if (!(fabsf(m[i].t0[k]) <= RTI_COORD_MAX && fabsf(m[i].dt[k]) <= 2.0f * RTI_COORD_MAX))
                return false;
        for (int k = 0; k < 6; k++) {
            bool rigid = m[i].flags & RTK_MOTION_RIGID;
            if (!(fabsf(s[k]) <= SCALE_MAX && fabsf(m[i].ds[k]) <= 2.0f * SCALE_MAX && fabsf(m[i].inv[k]) <= 4.0f * SCALE_MAX) ||
                (rigid ? m[i].ds[k] != 0.0f : m[i].inv[k] != 0.0f))
                return false;
        }
        /* Definite at both ends, and of one sign: three minors each. */
        for (int end = 0; end < 2; end++) {
            double e[6], minor[3];
            mat3 f;
            for (int k = 0; k < 6; k++)
                e[k] = m[i].s0[k] + (double)end * m[i].ds[k];
            f = full(e);
            first = first != 0.0 ? first : (e[0] < 0.0 ? -1.0 : 1.0);
            minor[0] = first * e[0];
            minor[1] = e[0] * e[3] - e[1] * e[1];
            minor[2] = first * det3(&f);
            if (!(minor[0] > 0.0 && minor[1] > 0.0 && minor[2] > 0.0))
                return false;
        }
        if (measure(&m[i], &size, &inverse) != NULL || !(m[i].size >= 0.0f && m[i].size <= 4.0f * SCALE_MAX) ||
            !(m[i].condition >= 0.0f && m[i].condition <= 4.0f * CONDITION_MAX))
            return false;
    }
    return true;
}

/* ---- bounds ---- */

static void pose(const rtk_motion *m, double u, double out[12])
{
    double c = cos(u * m->angle), s = sin(u * m->angle), q[4], l, w[6];
    double x, y, z;
    mat3 r, f;
    for (int i = 0; i < 4; i++)
        q[i] = c * m->q0[i] + s * m->q1[i];
    l = norm(q, 4);
    x = q[0] / l;
    y = q[1] / l;
    z = q[2] / l;
    l = q[3] / l;
    r = (mat3){{1 - 2 * (y * y + z * z), 2 * (x * y - z * l), 2 * (x * z + y * l), 2 * (x * y + z * l), 1 - 2 * (x * x + z * z),
                2 * (y * z - x * l), 2 * (x * z - y * l), 2 * (y * z + x * l), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 6; i++)
        w[i] = m->s0[i] + u * m->ds[i];
    f = full(w);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            out[4 * i + j] = r.m[3 * i] * f.m[j] + r.m[3 * i + 1] * f.m[3 + j] + r.m[3 * i + 2] * f.m[6 + j];
        out[4 * i + 3] = m->t0[i] + u * (double)m->dt[i];
    }
}

/* Farthest corner of a box from the origin. */
static double radius(const float lo[3], const float hi[3])
{
    double far[3];
    for (int k = 0; k < 3; k++)
        far[k] = fmax(fabs((double)lo[k]), fabs((double)hi[k]));
    return norm(far, 3);
}

void rti_motion_bounds(const rtk_motion *m, uint32_t segments, const float lo[3], const float hi[3], float out_lo[3],
                       float out_hi[3])
{
    double rho = radius(lo, hi), low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (uint32_t i = 0; i < segments; i++, m++) {
        double turn = 2.0 * m->angle * 1.000001, change[6];
        int pieces = turn > 0.0 ? 1 + (int)fmin(PIECES_MAX - 1, 6.0 * turn) : 1;
        double a = turn / pieces, stray;
        for (int k = 0; k < 6; k++)
            change[k] = m->ds[k];
        stray = rho * (a * a * m->size + 2.0 * a * symmetric_norm(change) / pieces) / 8.0;
        for (int p = 0; p <= pieces; p++) {
            double x[12];
            pose(m, (double)p / pieces, x);
            for (int r = 0; r < 3; r++) {
                double one = x[4 * r + 3] - stray, other = x[4 * r + 3] + stray;
                for (int c = 0; c < 3; c++) {
                    one += fmin(x[4 * r + c] * lo[c], x[4 * r + c] * hi[c]);
                    other += fmax(x[4 * r + c] * lo[c], x[4 * r + c] * hi[c]);
                }
                low[r] = fmin(low[r], one);
                high[r] = fmax(high[r], other);
            }
        }
    }
    for (int r = 0; r < 3; r++) {
        out_lo[r] = nextafterf((float)low[r], -INFINITY);
        out_hi[r] = nextafterf((float)high[r], INFINITY);
    }
}

float rti_motion_growth(const rtk_motion *m, uint32_t segments, const float lo[3], const float hi[3], float reach)
{
    double far = 0.0, rho = radius(lo, hi);
    for (uint32_t i = 0; i < segments; i++) {
        for (int end = 0; end < 2; end++) {
            double t[3];
            for (int k = 0; k < 3; k++)
                t[k] = m[i].t0[k] + (double)end * m[i].dt[k];
            far = fmax(far, norm(t, 3));
        }
    }
    return (float)(1.5 / 16777216.0 * m->condition * (122.0 * m->size * rho + 17.0 * far + 72.0 * reach));
}
