/* Files of rays, to trade sets with other programs. Everything is little-endian; a file is 128 + 32 count bytes:
 *
 *   0  char[8]   "RTRAYS\r\n"
 *   8  u32       version, 1
 *  12  u32       kind: 0 closest hit, 1 any hit
 *  16  u32       hints: 1 coherent, 2 one origin; other bits are 0
 *  20  u32[2]    width and height of the image that the rays were made for; 0: of none
 *  28  u32       0
 *  32  u64       count, 1 ... 2^32 - 1
 *  40  u64       FNV-1a hash (64 bits) of all bytes from 128 on
 *  48  char[16]  name of the set, padded with NUL: letters, digits, '.', '-', '_'
 *  64  char[64]  name of the scene, likewise
 * 128  f32[8]    for each ray org x y z, tmin, dir x y z, tmax: finite but for tmax, which may be infinite; dir not zero, tmin >=
 * 0
 *
 * A file is a stranger's: what is not as above is refused with a sentence.
 */
#include "rays.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HEAD = 128, RECORD = 32 };
static const char magic[8] = {'R', 'T', 'R', 'A', 'Y', 'S', '\r', '\n'};

static uint64_t get(const unsigned char *p, int bytes)
{
    uint64_t x = 0;
    for (int i = bytes - 1; i >= 0; i--)
        x = x << 8 | p[i];
    return x;
}

static void put(unsigned char *p, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        p[i] = (unsigned char)(x >> (8 * i));
}

static float get_float(const unsigned char *p)
{
    uint32_t bits = (uint32_t)get(p, 4);
    float f;
    memcpy(&f, &bits, sizeof f);
    return f;
}

static void put_float(unsigned char *p, float f)
{
    uint32_t bits;
    memcpy(&bits, &f, sizeof bits);
    put(p, bits, 4);
}

static uint64_t fnv(uint64_t hash, const unsigned char *p, size_t size)
{
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ p[i]) * 0x100000001b3u;
    return hash;
}
#define FNV_START 0xcbf29ce484222325u

uint64_t bench_rays_hash(const void *data, size_t size)
{
    return fnv(FNV_START, data, size);
}

static bool name_of(const unsigned char *p, size_t size, char *out)
{
    size_t n = 0;
    while (n < size && p[n]) {
        unsigned char c = p[n];
        if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' || c == '_'))
            return false;
        out[n++] = (char)c;
    }
    for (size_t i = n; i < size; i++)
        if (p[i])
            return false;
    if (n == 0 || n == size)
        return false;
    out[n] = '\0';
    return true;
}

static const char *bad_head(const unsigned char *p, size_t size, bench_rays *out)
{
    uint64_t count;
    if (size < HEAD)
        return "it is shorter than the 128 bytes that a file of rays begins with";
    if (memcmp(p, magic, sizeof magic) != 0)
        return "it is no file of rays: the first 8 bytes are others";
    if (get(p + 8, 4) != 1)
        return "its version is not 1";
    if (get(p + 12, 4) > 1)
        return "its kind is neither 0 (closest hit) nor 1 (any hit)";
    if (get(p + 16, 4) > 3)
        return "it has hints that are not known";
    if (get(p + 28, 4) != 0)
        return "the word at 28 is not 0";
    count = get(p + 32, 8);
    if (count < 1 || count > UINT32_MAX)
        return "it counts no rays, or more than 2^32 - 1";
    if ((size - HEAD) / RECORD != count || (size - HEAD) % RECORD != 0)
        return "its size is not the one that its count of rays asks for";
    if (!name_of(p + 48, 16, out->set) || !name_of(p + 64, 64, out->scene))
        return "a name is empty, or has other characters than letters, digits, '.', '-', '_'";
    if (bench_rays_hash(p + HEAD, size - HEAD) != get(p + 40, 8))
        return "its rays are not those that its hash was made of: the file is damaged";
    out->count = (size_t)count;
    out->any = get(p + 12, 4) == 1;
    out->hints = (uint32_t)get(p + 16, 4);
    out->width = (uint32_t)get(p + 20, 4);
    out->height = (uint32_t)get(p + 24, 4);
    return NULL;
}

static bool get_ray(const unsigned char *p, rt_ray *out)
{
    float f[8];
    for (int i = 0; i < 8; i++)
        f[i] = get_float(p + 4 * i);
    *out = (rt_ray){{f[0], f[1], f[2]}, f[3], {f[4], f[5], f[6]}, f[7], RT_MASK_ALL};
    for (int i = 0; i < 7; i++)
        if (!isfinite(f[i]))
            return false;
    return !isnan(f[7]) && f[3] >= 0 && (f[4] != 0 || f[5] != 0 || f[6] != 0);
}

bool bench_rays_parse(const void *data, size_t size, bench_rays *out, char *why, size_t why_size)
{
    const unsigned char *p = data;
    const char *wrong;
    memset(out, 0, sizeof *out);
    wrong = bad_head(p, size, out);
    if (!wrong && !(out->rays = malloc(out->count * sizeof *out->rays)))
        wrong = "there is no memory for its rays";
    if (wrong) {
        snprintf(why, why_size, "%s", wrong);
        return false;
    }
    for (size_t i = 0; i < out->count; i++) {
        if (!get_ray(p + HEAD + i * RECORD, &out->rays[i])) {
            snprintf(why, why_size, "ray %zu has a number that is not finite, a negative tmin, or no direction", i);
            bench_rays_free(out);
            return false;
        }
    }
    return true;
}

int bench_rays_read(const char *path, bench_rays *out)
{
    char quoted[400], why[200];
    FILE *f = fopen(path, "rb");
    unsigned char *data = NULL;
    size_t size = 0, room = 0, got = 1;
    bool ok = f != NULL;
    memset(out, 0, sizeof *out);
    while (ok && got > 0) { /* not by its length: it may be a pipe */
        if (size == room) {
            room = room ? 2 * room : 1 << 20;
            unsigned char *more = realloc(data, room);
            ok = more != NULL;
            data = more ? more : data;
        }
        got = ok ? fread(data + size, 1, room - size, f) : 0;
        size += got;
    }
    bench_quote(quoted, sizeof quoted, path);
    if (!f || !ok || ferror(f))
        bench_fail(BENCH_FILE, "%s cannot be read: %s", quoted, strerror(errno));
    else if (!(ok = bench_rays_parse(data, size, out, why, sizeof why)))
        bench_fail(BENCH_FILE, "%s: %s", quoted, why);
    else
        ok = true;
    if (f && ferror(f))
        ok = false;
    if (f)
        fclose(f);
    free(data);
    return ok ? BENCH_OK : BENCH_FILE;
}

static void put_ray(unsigned char *p, const rt_ray *r)
{
    float f[8] = {r->org.x, r->org.y, r->org.z, r->tmin, r->dir.x, r->dir.y, r->dir.z, r->tmax};
    for (int i = 0; i < 8; i++)
        put_float(p + 4 * i, f[i]);
}

int bench_rays_write(const char *path, const bench_rays *rays)
{
    unsigned char head[HEAD] = {0}, ray[RECORD];
    char quoted[400];
    uint64_t hash = FNV_START;
    FILE *f = fopen(path, "wb");
    bool ok = f != NULL;
    for (size_t i = 0; i < rays->count; i++) {
        put_ray(ray, &rays->rays[i]);
        hash = fnv(hash, ray, RECORD);
    }
    memcpy(head, magic, sizeof magic);
    put(head + 8, 1, 4);
    put(head + 12, rays->any, 4);
    put(head + 16, rays->hints, 4);
    put(head + 20, rays->width, 4);
    put(head + 24, rays->height, 4);
    put(head + 32, rays->count, 8);
    put(head + 40, hash, 8);
    memcpy(head + 48, rays->set, strlen(rays->set));
    memcpy(head + 64, rays->scene, strlen(rays->scene));
    ok = ok && fwrite(head, 1, HEAD, f) == HEAD;
    for (size_t i = 0; i < rays->count && ok; i++) {
        put_ray(ray, &rays->rays[i]);
        ok = fwrite(ray, 1, RECORD, f) == RECORD;
    }
    if (f && fclose(f) != 0)
        ok = false;
    return ok ? BENCH_OK
              : bench_fail(f ? BENCH_MACHINE : BENCH_FILE, "%s cannot be written: %s", bench_quote(quoted, sizeof quoted, path),
                           strerror(errno));
}
