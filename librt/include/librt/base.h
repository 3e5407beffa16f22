/** librt: status, memory, tasks, context.
 *
 *  Conventions of every header here. Right-handed space; angles in degrees; colours linear RGB; lengths in the scene's own unit.
 *  Descriptors: `rt_x_desc d = rt_x_desc_default();` then set fields; a descriptor whose struct_size is 0 was not made so and is refused
 *  with a sentence. The default of a field is 0 (no file, no name) where its comment gives no other. New fields are added at the end, so a caller compiled against an older header goes on working. Objects are
 *  opaque; create is paired with destroy, and destroy(NULL) does nothing. Calls that can fail return rt_status; the sentence is in
 *  rt_context_error. They answer ARGUMENT to a NULL in an object's place; what returns no rt_status is to be given none. The library never exits, prints, sets a locale or installs a signal handler, and it keeps no pointer of the
 *  caller's unless a function says so. Any number of contexts may live at once; nothing is global
 *  but each thread's last sentence about what failed without a context.
 *
 *  Signals are left to the host's threads: the library's own have all of them blocked but those that a thread sends itself by what it
 *  does (SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPIPE, SIGSEGV, SIGSYS, SIGTRAP, SIGXFSZ) and SIGPROF. So has what a hook starts there.
 *
 *  Calls compute rounding to nearest, with denormals, whatever floating-point environment their thread is in, and leave it as it was.
 *  Those that trace or render want up to 96 KiB of the thread's stack. A child of fork() may not use or destroy a context that has
 *  computed with several workers: its threads stayed with the parent.
 */
#ifndef LIBRT_BASE_H
#define LIBRT_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(RT_STATIC)
#define RT_API
#else
#define RT_API __attribute__((visibility("default")))
#endif

#define RT_VERSION_MAJOR 0
#define RT_VERSION_MINOR 1
#define RT_VERSION_PATCH 0
#define RT_INVALID_ID 0xffffffffu

typedef enum rt_status {
    RT_OK = 0,
    RT_ERROR_ARGUMENT,     /**< an argument is out of its range, or a descriptor was not initialised */
    RT_ERROR_STATE,        /**< the call does not fit now: not committed, job running */
    RT_ERROR_MEMORY,       /**< the allocator gave NULL */
    RT_ERROR_MEMORY_LIMIT, /**< more than the context's limit, or than the machine has free */
    RT_ERROR_IO,           /**< a file cannot be opened, read or written */
    RT_ERROR_FORMAT,       /**< a file's content is broken or not understood */
    RT_ERROR_UNSUPPORTED,  /**< a valid wish that this build or file version cannot fulfil */
    RT_ERROR_CANCELLED,    /**< rt_job_cancel, or a progress callback asked for it */
    RT_ERROR_THREAD        /**< the system gave no thread */
} rt_status;

typedef struct rt_context rt_context;
typedef struct rt_scene rt_scene;
typedef struct rt_image rt_image;
typedef struct rt_job rt_job;

typedef struct rt_vec3 {
    float x, y, z;
} rt_vec3;

/** Row-major 3x4 affine map: world = m[0..2][0..2] * p + m[.][3]. */
typedef struct rt_transform {
    float m[12];
} rt_transform;

/** Allocator in the shape of Lua's: new_size 0 frees and returns NULL; ptr NULL allocates (old_size is 0); else resizes. Blocks are aligned
 *  as malloc's are. old_size is exact. The library resizes to less only, and where that is refused (NULL, ptr as it was) it takes another
 *  block. Those of 2 MiB and more that scenes keep are asked to lie in huge pages (Linux: madvise). Called from any thread that computes, at
 *  the same time: it must be thread-safe. */
typedef void *(*rt_allocate_fn)(void *user, void *ptr, size_t old_size, size_t new_size);
/** The allocator of a context that is given none, for allocators that only count or limit: malloc, realloc and free; a block of 2 MiB and more
 *  lies in huge pages where the system has them, so that it is cleared and read faster; the last of them may hold up to 2 MiB more
 *  than was asked for, a third of the block at most, which nothing counts. user, old_size are not looked at.
 *  Errors NULL: no memory; ptr stays as it is. Threads any number. Owner the caller owns the block. */
RT_API void *rt_allocate(void *user, void *ptr, size_t old_size, size_t new_size);

typedef enum rt_log_level { RT_LOG_ERROR = 0, RT_LOG_WARNING, RT_LOG_INFO, RT_LOG_DEBUG } rt_log_level;

/** One line without a newline. Called on the thread that has something to say, one at a time per context. */
typedef void (*rt_log_fn)(void *user, rt_log_level level, const char *message);

/** Lends the host's task system: run task(data, i) for every i in [0, count), at the same time where possible, and return when all
 *  have returned. May be called from several threads and from inside a task. */
typedef void (*rt_parallel_fn)(void *user, uint32_t count, void (*task)(void *data, uint32_t index), void *data);

/** What an open hook is asked for: a file to read, or the folder that a file is to be made in. */
typedef enum rt_open_mode { RT_OPEN_READ = 0, RT_OPEN_FOLDER } rt_open_mode;
#define RT_OPEN_DEFAULT (-2)

/** Opens files in the library's place: meshes, what they name (material files, textures), images and saved scenes. For hosts that keep files to
 *  some folders, or hand out descriptors that were opened elsewhere.
 *  path     in   as the caller or a file named it; "-" (standard output) is never asked
 *  mode     in   RT_OPEN_READ: a descriptor to read from; it must be a regular file. RT_OPEN_FOLDER: a descriptor of the folder in which the file
 *                that path's last part names is made and put in place by renaming; links there are replaced, not followed
 *  why      out  [why_size] the reason of a refusal, a part of a sentence with its NUL; empty: errno tells
 *  Returns a descriptor that the library closes, -1 for a refusal (RT_ERROR_IO), or RT_OPEN_DEFAULT: as without a hook.
 *  Threads any that reads or writes a file, at the same time */
typedef int (*rt_open_fn)(void *user, const char *path, rt_open_mode mode, char *why, size_t why_size);

typedef struct rt_context_desc {
    uint32_t struct_size;
    uint32_t workers; /**< threads that compute; 0: the CPUs this process may use (affinity, cgroup quota); 1: only the caller's. At most 1024 */
    rt_allocate_fn allocate; /**< NULL: rt_allocate */
    void *allocate_user;
    rt_log_fn log; /**< NULL: silent */
    void *log_user;
    rt_parallel_fn parallel; /**< NULL: own threads, started on first need, ended with the context */
    void *parallel_user;
    uint64_t memory_limit; /**< bytes this context may hold at once; 0: no limit of its own */
    rt_open_fn open;       /**< NULL: files are opened by their names with the rights of the process */
    void *open_user;
} rt_context_desc;

/** Descriptor with every default written. */
RT_API rt_context_desc rt_context_desc_default(void);

/** Makes a context.
 *  desc     in   NULL: the defaults
 *  context  out  set to NULL on error
 *  Errors   ARGUMENT (struct_size, workers > 1024), MEMORY
 *  Threads  any
 *  Owner    the caller: rt_context_destroy, after everything made from it */
RT_API rt_status rt_context_create(const rt_context_desc *desc, rt_context **context);

/** Ends the context's threads and frees it. Scenes, images and jobs made from it must be destroyed before. NULL is fine. */
RT_API void rt_context_destroy(rt_context *context);

/** Copies the calling thread's last message, a sentence that names the argument and the value, cut to size with its NUL.
 *  context NULL: of what failed without a context, rt_context_create above all, and calls that were given NULL for an object.
 *  Returns the whole length without NUL; 0 when there was no error on this thread. buffer may be NULL when size is 0.
 *  Threads any; each thread sees its own message (the 64 threads that failed last are remembered). */
RT_API size_t rt_context_error(const rt_context *context, char *buffer, size_t size);

/** Number of workers this context computes with (never 0). */
RT_API uint32_t rt_context_workers(const rt_context *context);

/** Instruction set of the loops that take the time: "generic", "sse42", "avx2", "avx512", "avx512_vbmi2" or "neon". The context took the best one that this
 *  build, processor and system have when it was made; the environment variable RT_ISA names a lower one (another value gives a warning in the log and
 *  the best). Results are the same bits with each. Owner: a constant string. Threads any. */
RT_API const char *rt_context_isa(const rt_context *context);

/** Bytes held now and at most since creation, through the allocator hook. Either pointer may be NULL. */
RT_API void rt_context_memory(const rt_context *context, uint64_t *now, uint64_t *peak);

/** What the scenes of a context cost and what they took over from earlier ones. Mesh files, images and trees that were made once are kept in the
 *  context and found again by content: a mesh or texture file by its bytes (when its device, inode, size and times of change are those of the last reading, the bytes are
 *  not read again), a tree by its geometry and the builder's settings. What is kept for later takes at most half of the context's memory limit (2 GiB without one), beside the
 *  working memory of renders and queries (rt_context_drop_kept), goes by last use, and makes room when memory is short. Material libraries of OBJ files are small and always read. */
typedef struct rt_context_work_stats {
    uint64_t files_read;      /**< mesh and image files that were read and parsed */
    uint64_t files_kept;      /**< that were not: what was made of the same content before was taken */
    uint64_t trees_built;     /**< over geometry */
    uint64_t top_trees_built; /**< over instances */
    uint64_t trees_kept;      /**< of both, found instead of built */
    uint64_t trees_refitted;  /**< fitted to vertices that have moved instead of built (rt_commit_desc.refit) */
    double read_seconds, build_seconds; /**< what reading files, and building and refitting trees took */
    double saved_seconds;               /**< what it had taken to make what was found */
} rt_context_work_stats;
/** Counts since the context was made; differences tell what one commit did. Threads any. */
RT_API rt_context_work_stats rt_context_work(const rt_context *context);
/** Lets go of all that is only kept for later: files and trees, and the working memory of queries and renders (that of as many workers as the context
 *  has, and the pixels of one picture up to 256 MiB). Never needed: for programs that want the memory for something else. Threads any. */
RT_API void rt_context_drop_kept(rt_context *context);

/** The name of a status, as "RT_ERROR_IO"; "unknown status" for other numbers. Never NULL. */
RT_API const char *rt_status_name(rt_status status);

/** "0.1.0", the library's own version at run time. */
RT_API const char *rt_version(void);

/** What this build was made with, as "lua=5.4 stb=yes png=yes ...": one line for bug reports. */
RT_API const char *rt_build_info(void);

/** The instruction set that a context takes when it is made now: rt_context_isa tells what that means. Owner: a constant string. Threads any. */
RT_API const char *rt_isa(void);

/** CPUs this process may use: affinity mask and cgroup quota, at least 1. */
RT_API uint32_t rt_cpu_count(void);

/** Bytes a program may still take: free memory of the machine and of its cgroup, the smaller. */
RT_API uint64_t rt_memory_available(void);

#ifdef __cplusplus
}
#endif
#endif
