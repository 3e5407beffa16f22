/* SHA-256 (FIPS 180-4) of texts and files, so that what the program has written can be told from what was cut or changed since;
 * sha256sum(1) prints the same digits. */
#include "rtray.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <string.h>
#include <unistd.h>

typedef struct sha256 {
    uint32_t state[8];
    uint64_t size;
    unsigned char block[64];
} sha256;

static const uint32_t K[64] = {0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
                               0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
                               0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
                               0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
                               0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
                               0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
                               0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
                               0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

static uint32_t turn(uint32_t x, int n)
{
    return x >> n | x << (32 - n);
}

static void compress(sha256 *h, const unsigned char *p)
{
    uint32_t w[64], v[8];
    for (int i = 0; i < 16; i++)
        w[i] = (uint32_t)p[4 * i] << 24 | (uint32_t)p[4 * i + 1] << 16 | (uint32_t)p[4 * i + 2] << 8 | p[4 * i + 3];
    for (int i = 16; i < 64; i++) {
        uint32_t a = turn(w[i - 15], 7) ^ turn(w[i - 15], 18) ^ w[i - 15] >> 3;
        uint32_t b = turn(w[i - 2], 17) ^ turn(w[i - 2], 19) ^ w[i - 2] >> 10;
        w[i] = w[i - 16] + a + w[i - 7] + b;
    }
    memcpy(v, h->state, sizeof v);
    for (int i = 0; i < 64; i++) {
        uint32_t s1 = turn(v[4], 6) ^ turn(v[4], 11) ^ turn(v[4], 25), choose = (v[4] & v[5]) ^ (~v[4] & v[6]);
        uint32_t t1 = v[7] + s1 + choose + K[i] + w[i];
        uint32_t s0 = turn(v[0], 2) ^ turn(v[0], 13) ^ turn(v[0], 22), most = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
        memmove(v + 1, v, 7 * sizeof v[0]);
        v[4] += t1;
        v[0] = t1 + s0 + most;
    }
    for (int i = 0; i < 8; i++)
        h->state[i] += v[i];
}

static void begin(sha256 *h)
{
    static const uint32_t first[8] = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
    memcpy(h->state, first, sizeof first);
    h->size = 0;
}

static void add(sha256 *h, const unsigned char *data, size_t size)
{
    while (size > 0) {
        size_t at = (size_t)(h->size % 64), n = size < 64 - at ? size : 64 - at;
        memcpy(h->block + at, data, n);
        h->size += n;
        data += n;
        size -= n;
        if (at + n == 64)
            compress(h, h->block);
    }
}

/* Pushes the digits. */
static void push(lua_State *L, sha256 *h)
{
    uint64_t bits = h->size * 8;
    unsigned char tail[72] = {0x80};
    size_t pad = 64 - (size_t)((h->size + 8) % 64); /* the mark and zeros up to the last eight bytes */
    for (int i = 0; i < 8; i++)
        tail[pad + (size_t)i] = (unsigned char)(bits >> (56 - 8 * i));
    add(h, tail, pad + 8);
    char text[64];
    for (int i = 0; i < 64; i++)
        text[i] = "0123456789abcdef"[h->state[i / 8] >> (28 - 4 * (i % 8)) & 15];
    lua_pushlstring(L, text, sizeof text);
}

/* sha256(text): 64 hexadecimal digits. */
static int of_text(lua_State *L)
{
    size_t size;
    const char *text = luaL_checklstring(L, 1, &size);
    sha256 h;
    begin(&h);
    add(&h, (const unsigned char *)text, size);
    push(L, &h);
    return 1;
}

/* sha256_file(path): digits and size of a file; nil and the reason. */
static int of_file(lua_State *L)
{
    static const size_t room = 1 << 16;
    int fd = open(luaL_checkstring(L, 1), O_RDONLY | O_CLOEXEC), error = errno;
    ssize_t n = fd < 0 ? -1 : 0;
    sha256 h;
    begin(&h);
    unsigned char *data = lua_newuserdatauv(L, room, 0);
    while (fd >= 0 && ((n = read(fd, data, room)) > 0 || (n < 0 && errno == EINTR)))
        add(&h, data, n > 0 ? (size_t)n : 0);
    if (fd >= 0) {
        error = errno;
        close(fd);
    }
    if (n < 0) {
        lua_pushnil(L);
        lua_pushstring(L, strerror(error));
        return 2;
    }
    uint64_t size = h.size;
    push(L, &h);
    lua_pushinteger(L, (lua_Integer)size);
    return 2;
}

void rtray_open_sha256(lua_State *L)
{
    static const luaL_Reg functions[] = {{"sha256", of_text}, {"sha256_file", of_file}, {NULL, NULL}};
    luaL_setfuncs(L, functions, 0);
}
