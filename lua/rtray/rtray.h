/** The rtray program: what its C files share. The program is Lua (lua/rtray/ *.lua, embedded); C gives it a state, signals and
 * the system. */
#ifndef RTRAY_H
#define RTRAY_H

#include <stddef.h>

#include <librt/rt.h>

#include <lauxlib.h>
#include <lua.h>

/** Embedded Lua files of the program; a NULL name ends them. */
typedef struct rtray_file {
    const char *name; /**< as for require: "rtray.render" */
    const unsigned char *text;
    size_t size;
} rtray_file;
extern const rtray_file rtray_files[];

/** The module rt, from the binding. [-0, +1], raises. */
int luaopen_rt(lua_State *L);

/** The module rtray.sys: terminal, files, clock, processes. [-0, +1], raises. */
int rtray_open_sys(lua_State *L);
/** Adds the functions about signals to the table on the top of the stack. [-0, +0], raises. */
void rtray_open_signals(lua_State *L);
/** Adds sha256 and sha256_file to the table on the top of the stack. [-0, +0], raises. */
void rtray_open_sha256(lua_State *L);
/** Adds what processes need that share a folder to the table on the top of the stack. [-0, +0], raises. */
void rtray_open_claim(lua_State *L);
/** SIGINT and SIGTERM end the running Lua code by an error, or are only noted while sys.defer(true) holds; a second one ends the
 * process at once. */
void rtray_catch_signals(lua_State *L);
/** Ends the process by the signal that was caught, so that the shell sees it; returns when none was. */
void rtray_end_by_signal(void);
/** Takes back what the limit of time has asked for. */
void rtray_forget_time(void);

/** The open hook of the renderer's context (guard.c). Threads: any. */
int rtray_guard_open(void *user, const char *path, rt_open_mode mode, char *why, size_t why_size);
/** Allocator of the Lua state and of the renderer's context, on one account (limits.c). Threads: any. */
void *rtray_allocate(void *user, void *ptr, size_t old_size, size_t new_size);
/** Add their functions to the table on the top of the stack. [-0, +0], raises. */
void rtray_open_guard(lua_State *L);
void rtray_open_limits(lua_State *L);
/** Adds the ray benchmark (tests/bench/rays) to the table on the top of the stack. [-0, +0], raises. */
void rtray_open_bench_rays(lua_State *L);

#endif
