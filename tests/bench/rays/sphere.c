/* The generated scene "sphere": a sphere of 998,000 triangles with bumps, the same bits on every machine. */
#include "rays.h"

#include <math.h>
#include <stdlib.h>

#define ROUND 1000 /* points around */
#define RINGS 499  /* between the poles */

/* Taylor's series after a reduction to a quarter turn: right to a few units of the last place, and free of any C library's taste.
 */
double bench_sin(double x)
{
    static const double pi_high = 3.141592653589793116, pi_low = 1.2246467991473532e-16;
    double n = floor(x / pi_high + 0.5), y, square, term, sum;
    y = (x - n * pi_high) - n * pi_low;
    square = y * y;
    term = sum = y;
    for (int k = 1; k < 12; k++) {
        term *= -square / (double)(2 * k * (2 * k + 1));
        sum += term;
    }
    return fmod(n, 2.0) == 0.0 ? sum : -sum;
}

static double bench_cos(double x)
{
    return bench_sin(x + 1.5707963267948966);
}

/* r = 1 + sum over k = 1 ... 5 of 0.1 / 2^k * sin(s x + k) sin(s y + 2 k) sin(s z + 3 k), s = 3 * 2^k. */
static void put(float *to, double x, double y, double z)
{
    double r = 1;
    for (int k = 1; k <= 5; k++) {
        double s = 3.0 * (double)(1 << k);
        r += 0.1 / (double)(1 << k) * bench_sin(s * x + k) * bench_sin(s * y + 2 * k) * bench_sin(s * z + 3 * k);
    }
    to[0] = (float)(r * x);
    to[1] = (float)(r * y);
    to[2] = (float)(r * z);
}

static uint32_t corner(uint32_t ring, uint32_t i)
{
    return 1 + ring * ROUND + i % ROUND;
}

int bench_sphere_add(rt_scene *scene)
{
    uint32_t vertices = 2 + RINGS * ROUND, triangles = 2 * ROUND * RINGS, n = 0;
    float *p = malloc((size_t)vertices * 3 * sizeof *p);
    uint32_t *index = malloc((size_t)triangles * 3 * sizeof *index);
    rt_mesh_desc mesh = rt_mesh_desc_default();
    rt_status status = RT_ERROR_MEMORY;
    if (p && index) {
        put(p, 0, 1, 0);
        put(p + 3 * (size_t)(vertices - 1), 0, -1, 0);
        for (uint32_t ring = 0; ring < RINGS; ring++) {
            double a = 3.141592653589793 * (ring + 1) / (RINGS + 1);
            for (uint32_t i = 0; i < ROUND; i++) {
                double b = 6.283185307179586 * i / ROUND;
                put(p + 3 * (size_t)corner(ring, i), bench_sin(a) * bench_cos(b), bench_cos(a), bench_sin(a) * bench_sin(b));
            }
        }
        for (uint32_t ring = 0; ring <= RINGS; ring++) {
            for (uint32_t i = 0; i < ROUND; i++) {
                uint32_t a = corner(ring - 1, i), b = corner(ring - 1, i + 1), c = corner(ring, i), d = corner(ring, i + 1);
                if (ring > 0 && ring < RINGS) {
                    uint32_t six[6] = {a, b, c, b, d, c};
                    for (int k = 0; k < 6; k++)
                        index[n++] = six[k];
                } else {
                    index[n++] = ring == 0 ? 0 : a;
                    index[n++] = ring == 0 ? d : b;
                    index[n++] = ring == 0 ? c : vertices - 1;
                }
            }
        }
        mesh.positions = p;
        mesh.vertex_count = vertices;
        mesh.indices = index;
        mesh.triangle_count = triangles;
        status = rt_scene_add_mesh(scene, &mesh, NULL);
    }
    free(p);
    free(index);
    return status == RT_OK ? BENCH_OK : bench_fail(BENCH_MACHINE, "no memory for the sphere");
}
