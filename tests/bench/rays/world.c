/* Opens what is measured: a scene by name, a mesh file, a saved snapshot, or a scene that the front made; and its view. */
#include "rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int library(const bench_world *w, rt_status status)
{
    char sentence[512] = "";
    if (status == RT_OK)
        return BENCH_OK;
    if (w->ctx)
        rt_context_error(w->ctx, sentence, sizeof sentence);
    return bench_fail(status == RT_ERROR_MEMORY || status == RT_ERROR_MEMORY_LIMIT ? BENCH_MACHINE : BENCH_FILE, "%s",
                      sentence[0] ? sentence : rt_status_name(status));
}

/* ---- names ---- */

static bool is_word(const char *name)
{
    return !strchr(name, '/') && !strchr(name, '.');
}

/* The last part of the path without its ending, cut to fit; what a file's name may not hold becomes '_'. */
static void short_name(const char *path, char *out, size_t size)
{
    const char *slash = strrchr(path, '/'), *from = slash ? slash + 1 : path, *dot = strrchr(from, '.');
    size_t length = dot && dot != from ? (size_t)(dot - from) : strlen(from), n = 0;
    for (size_t i = 0; i < length && n + 1 < size; i++) {
        unsigned char c = (unsigned char)from[i];
        out[n++] = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '_' || c == '.'
                       ? (char)c
                       : '_';
    }
    out[n] = '\0';
    if (n == 0)
        snprintf(out, size, "scene");
}

static bool exists(const char *path)
{
    FILE *f = fopen(path, "rb");
    if (f)
        fclose(f);
    return f != NULL;
}

static bool path_of(const bench_options *o, const char *name, char *out, size_t size)
{
    const char *folder = o->folder ? o->folder : getenv("LIBRT_SCENES");
    if (!folder || !*folder)
        folder = "../shared/scenes";
    if (!is_word(name))
        return (size_t)snprintf(out, size, "%s", name) < size;
    return (size_t)snprintf(out, size, "%s/%s.ply", folder, name) < size;
}

/* ---- geometry ---- */

static bool is_snapshot(const char *path)
{
    char head[8] = "";
    FILE *f = fopen(path, "rb");
    bool is = f && fread(head, 1, sizeof head, f) == sizeof head && memcmp(head, "librtsnp", 8) == 0;
    if (f)
        fclose(f);
    return is;
}

static int read_geometry(const bench_options *o, const char *name, bench_world *w)
{
    char path[4096], quoted[400];
    int status;
    if (strcmp(name, "sphere") == 0) {
        status = library(w, rt_scene_create(w->ctx, &w->scene));
        return status == BENCH_OK ? bench_sphere_add(w->scene) : status;
    }
    if (bench_spheres_named(name)) {
        status = library(w, rt_scene_create(w->ctx, &w->scene));
        return status == BENCH_OK ? bench_spheres_add(name, w->scene, &w->balls, &w->ball_count) : status;
    }
    if (!path_of(o, name, path, sizeof path) || !exists(path))
        return bench_fail(BENCH_FILE, "%s cannot be read%s", bench_quote(quoted, sizeof quoted, path),
                          is_word(name) ? "; --scenes FOLDER or LIBRT_SCENES says where the meshes are" : "");
    if (is_snapshot(path))
        return library(w, rt_scene_load(w->ctx, path, &w->scene));
    status = library(w, rt_scene_create(w->ctx, &w->scene));
    return status == BENCH_OK ? library(w, rt_scene_import(w->scene, path, NULL, NULL)) : status;
}

/* ---- the view ---- */

static int view_of_scene(const bench_options *o, bench_world *w)
{
    rt_camera_desc c = rt_camera_desc_default();
    int status = BENCH_OK;
    if (!w->lent)
        status = library(w, rt_scene_frame_camera(w->scene, (float)o->width / (float)o->height));
    if (status == BENCH_OK)
        status = library(w, rt_scene_get_camera(w->scene, &c));
    if (status == BENCH_OK && c.type != RT_CAMERA_PINHOLE)
        return bench_fail(BENCH_FILE, "the scene's camera is no pinhole; --eye, --at and --fov give another");
    w->view =
        (bench_view){{c.eye.x, c.eye.y, c.eye.z}, {c.look_at.x, c.look_at.y, c.look_at.z}, {c.up.x, c.up.y, c.up.z}, c.fov_deg};
    return status;
}

static int view_of_file(const bench_options *o, const char *name, bench_world *w)
{
    char path[4096];
    if (o->cameras) {
        int found = bench_camera_find(o->cameras, w->name, false, &w->view);
        return found != 0 ? found : bench_fail(-1, "%s has no camera called %s", o->cameras, w->name);
    }
    if (!path_of(o, name, path, sizeof path - 16))
        return 0;
    char *slash = strrchr(path, '/');
    strcpy(slash ? slash + 1 : path, "cameras.json");
    return bench_camera_find(path, w->name, true, &w->view);
}

static int view_of(const bench_options *o, const char *name, bench_world *w)
{
    static const bench_view sphere = {{0, 0, 3}, {0, 0, 0}, {0, 1, 0}, 45};
    static const bench_view spheres = {{0.75, 1.125, 2.125}, {0, 0, 0}, {0, 1, 0}, 40};
    int found = 0, status = BENCH_OK;
    if (strcmp(name, "sphere") == 0 && !o->cameras) {
        w->view = sphere;
        found = 1;
    } else if (w->balls && !o->cameras) {
        w->view = spheres;
        found = 1;
    } else if (o->cameras || !w->lent) {
        found = view_of_file(o, name, w);
    }
    if (found < 0)
        return BENCH_FILE;
    if (found == 0 && !(o->has_eye && o->view.vfov > 0))
        status = view_of_scene(o, w);
    if (o->has_eye) {
        memcpy(w->view.eye, o->view.eye, sizeof w->view.eye);
        memcpy(w->view.at, o->view.at, sizeof w->view.at);
        memcpy(w->view.up, o->view.up, sizeof w->view.up);
    }
    if (o->view.vfov > 0)
        w->view.vfov = o->view.vfov;
    return status;
}

/* ---- open, close ---- */

static void extend(bench_world *w, rt_vec3 p)
{
    w->low = (rt_vec3){fminf(w->low.x, p.x), fminf(w->low.y, p.y), fminf(w->low.z, p.z)};
    w->high = (rt_vec3){fmaxf(w->high.x, p.x), fmaxf(w->high.y, p.y), fmaxf(w->high.z, p.z)};
}

/* Also of a loaded snapshot, which has no description to ask. */
static int bounds_of_triangles(bench_world *w)
{
    rt_triangle some[512];
    w->low = (rt_vec3){INFINITY, INFINITY, INFINITY};
    w->high = (rt_vec3){-INFINITY, -INFINITY, -INFINITY};
    for (uint64_t first = 0; first < w->triangles; first += 512) {
        uint64_t n = w->triangles - first < 512 ? w->triangles - first : 512;
        rt_scene_get_triangles(w->scene, first, some, (size_t)n);
        for (uint64_t i = 0; i < n; i++) {
            extend(w, some[i].v0);
            extend(w, some[i].v1);
            extend(w, some[i].v2);
        }
    }
    return BENCH_OK;
}

static int describe(bench_world *w)
{
    rt_scene_info info;
    int status = library(w, rt_scene_get_info(w->scene, &info));
    if (status != BENCH_OK)
        return status;
    w->triangles = rt_scene_get_triangles(w->scene, 0, NULL, 0);
    w->plain = info.shapes == 0 && info.planes == 0 && info.instances == 0;
    if (w->triangles == 0 && info.shapes == 0 && info.instances == 0)
        return bench_fail(BENCH_FILE, "%s holds nothing that a ray could meet", w->name);
    if (w->plain)
        return bounds_of_triangles(w);
    status = library(w, rt_scene_bounds(w->scene, &w->low, &w->high));
    if (status == BENCH_OK && !(w->low.x <= w->high.x))
        return bench_fail(BENCH_FILE, "%s has no bounds", w->name);
    return status;
}

int bench_world_open(const bench_options *o, const bench_front *front, const char *name, uint32_t workers, bench_world *w)
{
    rt_context_desc desc = rt_context_desc_default();
    int status = BENCH_OK;
    memset(w, 0, sizeof *w);
    short_name(name, w->name, sizeof w->name);
    if (front && front->open)
        status = front->open(front->user, name, &w->scene);
    if (status != BENCH_OK)
        return status;
    w->lent = w->scene != NULL;
    if (w->lent) {
        w->ctx = rt_scene_context(w->scene);
        w->workers = rt_context_workers(w->ctx);
    } else {
        desc.workers = w->workers = workers;
        status = library(w, rt_context_create(&desc, &w->ctx));
        if (status == BENCH_OK)
            status = read_geometry(o, name, w);
        if (status == BENCH_OK) { /* a loaded snapshot is committed already, and says so */
            rt_status committed = rt_scene_commit(w->scene, NULL);
            status = committed == RT_ERROR_STATE ? BENCH_OK : library(w, committed);
        }
    }
    if (status == BENCH_OK)
        status = describe(w);
    if (status == BENCH_OK)
        status = view_of(o, name, w);
    return status;
}

void bench_world_close(bench_world *w)
{
    if (!w->lent) {
        rt_scene_destroy(w->scene);
        rt_context_destroy(w->ctx);
    }
    free(w->balls);
    memset(w, 0, sizeof *w);
}
