/* What the machine is and how late it is. */
#if defined(__linux__)
#define _GNU_SOURCE /* sched_getaffinity, madvise */
#include <sched.h>
#include <sys/mman.h>
#endif
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base.h"

double rti_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double rti_thread_cpu(void)
{
    struct timespec t;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) != 0)
        return 0;
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void rti_sleep(double seconds)
{
    struct timespec t;
    if (!(seconds > 0))
        return;
    if (seconds > 1e6)
        seconds = 1e6;
    t.tv_sec = (time_t)seconds;
    t.tv_nsec = (long)((seconds - (double)t.tv_sec) * 1e9);
    nanosleep(&t, NULL);
}

/* Trees and triangles are read all over: with pages of 4 KiB every other read of a large one misses the processor's page table
 * cache. */
#define HUGE_PAGE ((size_t)2 << 20)

void *rti_alloc_large(size_t size)
{
    size_t tail = size % HUGE_PAGE;
    void *p;
    if (size < HUGE_PAGE)
        return malloc(size);
    /* A last page is worth it that is half used, or that leaves no more than a quarter of the block empty: in pages of 4 KiB the
     * last 700 KiB of a picture of 1000x700 pixels took ten times what the system takes to clear a huge one. */
    if (tail != 0 && (tail >= HUGE_PAGE / 2 || HUGE_PAGE - tail <= size / 4) && size <= SIZE_MAX - HUGE_PAGE)
        size += HUGE_PAGE - tail;
    p = NULL;
    if (posix_memalign(&p, HUGE_PAGE, size) != 0)
        return NULL;
#ifdef MADV_HUGEPAGE
    madvise(p, size, MADV_HUGEPAGE); /* a wish */
#endif
    return p;
}

#define FEW 4u /* workers; two meet at a page now and then */

typedef struct touching {
    char *blocks[2];
    size_t pages; /* of the first */
} touching;

static void touch_page(void *data, uint32_t index)
{
    const touching *t = data;
    const bool second = index >= t->pages;
    *(volatile char *)&t->blocks[second][(second ? index - t->pages : index) * HUGE_PAGE] = 0;
}

void rti_touch_large(rt_context *ctx, void *a, size_t a_size, void *b, size_t b_size)
{
    touching t = {{a, b}, (a_size + HUGE_PAGE - 1) / HUGE_PAGE};
    const size_t pages = t.pages + (b_size + HUGE_PAGE - 1) / HUGE_PAGE;
    if (rt_context_workers(ctx) >= FEW && pages > 2 && pages <= RTI_PARALLEL_MOST)
        rti_parallel(ctx, (uint32_t)pages, touch_page, &t);
}

/* First line of a small file of the system, NUL-ended; false when it cannot be read. */
static bool read_line(const char *path, char *buffer, size_t size)
{
    FILE *f = fopen(path, "r");
    bool ok;
    if (!f)
        return false;
    ok = fgets(buffer, (int)size, f) != NULL;
    fclose(f);
    return ok;
}

#if defined(__linux__) && !defined(MADV_COLLAPSE)
#define MADV_COLLAPSE 25 /* Linux 6.1; C libraries name it later */
#endif

/* (In a process that had other scenes before, a tree of 13 MB lay in pages of 4 KiB: rays took 1.1 to 1.5 times as long.) Where
 * huge pages are off for the whole system this asks for none, though collapsing would not look. */
void rti_settle_large(const void *block, size_t size)
{
#if defined(MADV_HUGEPAGE) && defined(MADV_COLLAPSE)
    const uintptr_t at = (uintptr_t)block; /* behind a header of an allocator's, at most */
    const uintptr_t begin = (at + HUGE_PAGE - 4096) / HUGE_PAGE * HUGE_PAGE, end = (at + size) / HUGE_PAGE * HUGE_PAGE;
    char setting[64];
    if (size < HUGE_PAGE || end <= begin)
        return;
    if (!read_line("/sys/kernel/mm/transparent_hugepage/enabled", setting, sizeof setting) || strstr(setting, "[never]"))
        return;
    madvise((void *)begin, end - begin, MADV_HUGEPAGE); /* nothing is lost where it is refused */
    madvise((void *)begin, end - begin, MADV_COLLAPSE);
#else
    (void)block;
    (void)size;
#endif
}

static bool read_number(const char *path, uint64_t *out)
{
    char line[64];
    const char *s = line;
    int64_t x;
    if (!read_line(path, line, sizeof line) || !rti_parse_int(&s, line + strlen(line), &x) || x < 0)
        return false; /* "max" is no number: no limit */
    *out = (uint64_t)x;
    return true;
}

/* CPUs' worth of time that the control group grants; 0: no bound. */
static uint32_t cgroup_cpus(void)
{
    char line[96];
    const char *s = line, *end;
    int64_t quota, period;
    uint64_t q, p;
    if (read_line("/sys/fs/cgroup/cpu.max", line, sizeof line)) {
        end = line + strlen(line);
        if (!rti_parse_int(&s, end, &quota))
            return 0;
        while (s < end && *s == ' ')
            s++;
        if (!rti_parse_int(&s, end, &period))
            return 0;
    } else if (read_number("/sys/fs/cgroup/cpu/cpu.cfs_quota_us", &q) &&
               read_number("/sys/fs/cgroup/cpu/cpu.cfs_period_us", &p)) {
        quota = (int64_t)q;
        period = (int64_t)p;
    } else {
        return 0;
    }
    if (quota <= 0 || period <= 0)
        return 0;
    return (uint32_t)((quota + period - 1) / period);
}

uint32_t rt_cpu_count(void)
{
    long n = 0;
    uint32_t granted = cgroup_cpus();
#if defined(__linux__)
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        n = CPU_COUNT(&set);
#endif
    if (n <= 0)
        n = sysconf(_SC_NPROCESSORS_ONLN);
    if (n <= 0)
        n = 1;
    if (n > 1024)
        n = 1024;
    return granted && granted < (uint32_t)n ? granted : (uint32_t)n;
}

uint64_t rti_core_cache(void)
{
    long n = 0;
#ifdef _SC_LEVEL2_CACHE_SIZE
    n = sysconf(_SC_LEVEL2_CACHE_SIZE);
#endif
    return n > 0 ? (uint64_t)n : 0;
}

static uint64_t machine_memory(void)
{
    FILE *f = fopen("/proc/meminfo", "r");
    char line[128];
    uint64_t found = 0;
    if (f) {
        while (fgets(line, sizeof line, f)) {
            const char *s = line + 13;
            int64_t kib;
            if (strncmp(line, "MemAvailable:", 13) != 0)
                continue;
            while (*s == ' ')
                s++;
            if (rti_parse_int(&s, line + strlen(line), &kib) && kib >= 0)
                found = (uint64_t)kib * 1024;
            break;
        }
        fclose(f);
    }
    if (!found) {
        long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
        if (pages > 0 && page > 0)
            found = (uint64_t)pages * (uint64_t)page;
    }
    return found ? found : UINT64_MAX;
}

uint64_t rt_memory_available(void)
{
    uint64_t free_bytes = machine_memory(), limit = 0, used = 0;
    bool grouped = (read_number("/sys/fs/cgroup/memory.max", &limit) && read_number("/sys/fs/cgroup/memory.current", &used)) ||
                   (read_number("/sys/fs/cgroup/memory/memory.limit_in_bytes", &limit) &&
                    read_number("/sys/fs/cgroup/memory/memory.usage_in_bytes", &used));
    if (grouped) {
        uint64_t left = limit > used ? limit - used : 0;
        if (left < free_bytes)
            free_bytes = left;
    }
    return free_bytes;
}
