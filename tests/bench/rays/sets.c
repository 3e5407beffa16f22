/* The ray sets. What is written here is what bench_definitions says; everything is computed in double and rounded once, so that
 * another program that follows the words comes to the same floats. */
#include "rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const bench_set_names[BENCH_SETS] = {"primary", "shadow", "diffuse", "ao", "random"};

const char bench_definitions[] =
    "The ray sets. All arithmetic is in double precision, each number is rounded to float once, when it is written into a ray; "
    "tmin is 0 in every ray, tmax "
    "infinite unless said, and hits count in tmin < t < tmax. W x H is the size; E the eye, A the point looked at, U upwards, V "
    "the vertical angle in degrees.\n"
    "\n"
    "primary (closest hit): one ray through the centre of each pixel, in tiles of 8 x 8 pixels, tiles by rows from the top left, "
    "in a tile by rows from its top "
    "left; tiles at the border are cut. f = norm(A - E), r = norm(f x U), u = r x f, h = tan(V pi / 360). Pixel (x, y): "
    "dir = norm(f + h W/H (2 (x + 0.5) / W - 1) r + h (1 - 2 (y + 0.5) / H) u), org = E.\n"
    "\n"
    "Of a primary hit the sets shadow, diffuse and ao take the point P = org + t dir and the geometric normal N (triangles: "
    "norm((v1 - v0) x (v2 - v0)), spheres: from the centre), turned "
    "against dir. Their rays start at P + d N, d = 2^-13 max(t, |P.x|, |P.y|, |P.z|), and stand in the order of the primary "
    "rays; misses give none.\n"
    "\n"
    "shadow (any hit): from each hit to the point light L: dir = L - org (with org as rounded), tmax = 1. Without --light, L "
    "stands over the middle between "
    "the eye and the hit of the ray f from E (without a hit: E + 0.5 D f, D the diagonal of the bounds): M = that middle; from M "
    "straight upwards (0,1,0), "
    "at 0.9 of the way to the first hit, or at 0.5 D without one.\n"
    "\n"
    "diffuse (closest hit): one cosine-weighted bounce a hit: dir = norm(N + s), s the first of the points p in the ball (see "
    "below), brought to length 1. "
    "ao (any hit): four such rays a hit in a row, tmax = the reach; without --reach it is a quarter of the median t of the "
    "primary hits (of n sorted, number "
    "n / 2 from 0, rounded to float).\n"
    "\n"
    "random (closest hit): W H rays, unsorted: org evenly in the box of all vertices (low + n (high - low) for x, y, z in turn), "
    "dir = p brought to length 1, p "
    "as above.\n"
    "\n"
    "Numbers n in [0, 1): a stream for each ray, of the splitmix64 generator: state = mix(mix(seed) + 2^32 k + i) for ray i of "
    "set k (2 diffuse, 3 ao, 4 random); "
    "then for each number state += 0x9e3779b97f4a7c15 (modulo 2^64) and n = (mix(state) >> 11) / 2^53. mix(z): z ^= z >> 30; z "
    "*= 0xbf58476d1ce4e5b9; "
    "z ^= z >> 27; z *= 0x94d049bb133111eb; z ^= z >> 31. A point in the ball: three numbers give p = 2 n - 1 for x, y, z; again "
    "while |p|^2 > 1 or "
    "|p|^2 < 2^-20.\n"
    "\n"
    "Rays of primary and shadow are hinted as coherent, those of primary as of one origin. --dump writes the sets as they were "
    "traced.";

typedef struct vec {
    double x, y, z;
} vec;

static vec v3(const double p[3])
{
    return (vec){p[0], p[1], p[2]};
}
static vec of(rt_vec3 p)
{
    return (vec){(double)p.x, (double)p.y, (double)p.z};
}
static rt_vec3 to(vec p)
{
    return (rt_vec3){(float)p.x, (float)p.y, (float)p.z};
}
static vec add(vec a, double s, vec b)
{
    return (vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec norm(vec a)
{
    double length = sqrt(dot(a, a));
    return (vec){a.x / length, a.y / length, a.z / length};
}

/* ---- numbers ---- */

static uint64_t mix(uint64_t z)
{
    z ^= z >> 30;
    z *= 0xbf58476d1ce4e5b9u;
    z ^= z >> 27;
    z *= 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static double next(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15u;
    return (double)(mix(*state) >> 11) * 0x1p-53;
}

static vec on_ball(uint64_t *state)
{
    vec p;
    do {
        p.x = 2 * next(state) - 1;
        p.y = 2 * next(state) - 1;
        p.z = 2 * next(state) - 1;
    } while (dot(p, p) > 1 || dot(p, p) < 0x1p-20);
    return norm(p);
}

static uint64_t stream(const bench_options *o, int set, size_t ray)
{
    return mix(mix(o->seed) + ((uint64_t)set << 32) + ray);
}

/* ---- the view ---- */

static bool frame_of(const bench_view *view, vec *f, vec *r, vec *u, double *h)
{
    vec up = v3(view->up);
    double half = view->vfov * 3.141592653589793 / 360;
    *f = norm(add(v3(view->at), -1, v3(view->eye)));
    *r = norm(cross(*f, up));
    *u = cross(*r, *f);
    *h = bench_sin(half) / bench_sin(half + 1.5707963267948966);
    return isfinite(r->x) && isfinite(r->y) && isfinite(r->z);
}

static bool rays_new(bench_rays *out, const char *set, const char *scene, size_t count)
{
    memset(out, 0, sizeof *out);
    snprintf(out->set, sizeof out->set, "%s", set);
    snprintf(out->scene, sizeof out->scene, "%s", scene);
    out->count = count;
    out->rays = malloc((count ? count : 1) * sizeof *out->rays);
    return out->rays != NULL;
}

void bench_rays_free(bench_rays *rays)
{
    free(rays->rays);
    memset(rays, 0, sizeof *rays);
}

static int out_of_memory(void)
{
    return bench_fail(BENCH_MACHINE, "no memory for the rays; a smaller --size needs less");
}

static int make_primary(const bench_options *o, const bench_world *w, bench_rays *out)
{
    uint32_t width = o->width, height = o->height;
    vec f, r, u, eye = v3(w->view.eye);
    double h;
    size_t n = 0;
    if (!frame_of(&w->view, &f, &r, &u, &h))
        return bench_fail(BENCH_FILE, "%s: the view has no direction, or runs along its up", w->name);
    if (!rays_new(out, "primary", w->name, (size_t)width * height))
        return out_of_memory();
    for (uint32_t ty = 0; ty < height; ty += 8) {
        for (uint32_t tx = 0; tx < width; tx += 8) {
            for (uint32_t y = ty; y < ty + 8 && y < height; y++) {
                for (uint32_t x = tx; x < tx + 8 && x < width; x++) {
                    double a = h * width / height * (2 * (x + 0.5) / width - 1), b = h * (1 - 2 * (y + 0.5) / height);
                    out->rays[n++] = (rt_ray){to(eye), 0, to(norm(add(add(f, a, r), b, u))), INFINITY, RT_MASK_ALL};
                }
            }
        }
    }
    out->hints = RT_RAYS_COHERENT | RT_RAYS_COMMON_ORIGIN;
    return BENCH_OK;
}

/* ---- from the primary hits ---- */

static double shoot(const bench_source *s, vec org, vec dir)
{
    rt_ray ray = {to(org), 0, to(dir), INFINITY, RT_MASK_ALL};
    rt_hit hit;
    rt_tracer_intersect(s->tracer, &ray, &hit, 1, 0);
    return hit.prim_id == RT_INVALID_ID ? -1 : (double)hit.t;
}

static void choose_light(bench_source *s)
{
    vec f, r, u, eye = v3(s->world->view.eye), up = {0, 1, 0}, box = add(of(s->world->high), -1, of(s->world->low));
    double h, diagonal = sqrt(dot(box, box)), t;
    if (s->o->has_light) {
        s->light = to(v3(s->o->light));
        return;
    }
    (void)frame_of(&s->world->view, &f, &r, &u, &h);
    t = shoot(s, eye, f);
    eye = add(eye, 0.5 * (t < 0 ? diagonal : t), f);
    t = shoot(s, eye, up);
    s->light = to(add(eye, t < 0 ? 0.5 * diagonal : 0.9 * t, up));
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

static int choose_reach(bench_source *s)
{
    float *t = malloc(s->primary.count * sizeof *t);
    size_t n = 0;
    if (!t)
        return out_of_memory();
    for (size_t i = 0; i < s->primary.count; i++)
        if (s->hits[i].prim_id != RT_INVALID_ID)
            t[n++] = s->hits[i].t;
    qsort(t, n, sizeof *t, by_value);
    s->reach = s->o->reach > 0 ? (float)s->o->reach : n ? (float)((double)t[n / 2] * 0.25) : 1.0f;
    free(t);
    return BENCH_OK;
}

int bench_source_open(bench_source *s, const bench_options *o, const bench_world *world, const rt_tracer *tracer)
{
    int status;
    memset(s, 0, sizeof *s);
    s->o = o;
    s->world = world;
    s->tracer = tracer;
    status = make_primary(o, world, &s->primary);
    if (status != BENCH_OK)
        return status;
    s->primary.width = o->width;
    s->primary.height = o->height;
    s->hits = malloc(s->primary.count * sizeof *s->hits);
    if (!s->hits)
        return out_of_memory();
    rt_tracer_intersect(tracer, s->primary.rays, s->hits, s->primary.count, s->primary.hints);
    choose_light(s);
    return choose_reach(s);
}

void bench_source_close(bench_source *s)
{
    bench_rays_free(&s->primary);
    free(s->hits);
    memset(s, 0, sizeof *s);
}

/* Where rays that leave the hit start, and the normal on the ray's side. */
static vec leave(const bench_source *s, size_t i, vec *normal)
{
    const rt_ray *ray = &s->primary.rays[i];
    rt_surface at;
    vec p = add(of(ray->org), (double)s->hits[i].t, of(ray->dir)), n;
    double d = fmax(fmax((double)s->hits[i].t, fabs(p.x)), fmax(fabs(p.y), fabs(p.z)));
    rt_scene_surface(s->world->scene, ray, &s->hits[i], &at);
    n = of(at.ng);
    *normal = dot(n, of(ray->dir)) > 0 ? (vec){-n.x, -n.y, -n.z} : n;
    return add(p, d * 0x1p-13, *normal);
}

static void from_hit(const bench_source *s, int set, size_t hit, size_t first, uint32_t each, rt_ray *out)
{
    vec normal, org = leave(s, hit, &normal);
    for (uint32_t k = 0; k < each; k++) {
        rt_ray ray = {to(org), 0, {0, 0, 0}, INFINITY, RT_MASK_ALL};
        if (set == BENCH_SHADOW) {
            ray.dir = to(add(of(s->light), -1, of(ray.org)));
            ray.tmax = 1;
        } else {
            uint64_t state = stream(s->o, set, first + k);
            vec dir = add(normal, 1, on_ball(&state));
            ray.dir = to(dot(dir, dir) > 0 ? norm(dir) : normal);
            ray.tmax = set == BENCH_AO ? s->reach : INFINITY;
        }
        out[k] = ray;
    }
}

static int make_from_hits(const bench_source *s, int set, bench_rays *out)
{
    uint32_t each = set == BENCH_AO ? 4 : 1;
    size_t n = 0;
    for (size_t i = 0; i < s->primary.count; i++)
        n += s->hits[i].prim_id != RT_INVALID_ID;
    if (!rays_new(out, bench_set_names[set], s->world->name, n * each))
        return out_of_memory();
    n = 0;
    for (size_t i = 0; i < s->primary.count; i++) {
        if (s->hits[i].prim_id != RT_INVALID_ID) {
            from_hit(s, set, i, n, each, out->rays + n);
            n += each;
        }
    }
    out->any = set != BENCH_DIFFUSE;
    out->hints = set == BENCH_SHADOW ? RT_RAYS_COHERENT : 0;
    return BENCH_OK;
}

static int make_random(const bench_source *s, bench_rays *out)
{
    vec low = of(s->world->low), size = add(of(s->world->high), -1, low);
    if (!rays_new(out, "random", s->world->name, (size_t)s->o->width * s->o->height))
        return out_of_memory();
    for (size_t i = 0; i < out->count; i++) {
        uint64_t state = stream(s->o, BENCH_RANDOM, i);
        vec org;
        org.x = low.x + next(&state) * size.x;
        org.y = low.y + next(&state) * size.y;
        org.z = low.z + next(&state) * size.z;
        out->rays[i] = (rt_ray){to(org), 0, to(on_ball(&state)), INFINITY, RT_MASK_ALL};
    }
    return BENCH_OK;
}

int bench_set_make(const bench_source *s, int set, bench_rays *out)
{
    int status;
    if (set == BENCH_PRIMARY)
        status = make_primary(s->o, s->world, out);
    else
        status = set == BENCH_RANDOM ? make_random(s, out) : make_from_hits(s, set, out);
    out->width = s->o->width;
    out->height = s->o->height;
    return status;
}
