/* Where the headers of Embree 3 are not installed: a sentence that says so. */
#include "rays.h"

struct bench_embree {
    int none;
};

int bench_embree_open(bench_embree **embree)
{
    *embree = NULL;
    return bench_fail(BENCH_MACHINE, "--against embree: this build had no headers of Embree 3 (Debian: libembree-dev)");
}
void bench_embree_close(bench_embree *embree)
{
    (void)embree;
}
const char *bench_embree_version(const bench_embree *embree)
{
    (void)embree;
    return "";
}
int bench_embree_add(bench_embree *embree, const bench_options *o, const bench_world *world, bench_entrants *entrants)
{
    (void)embree;
    (void)o;
    (void)world;
    (void)entrants;
    return BENCH_MACHINE;
}
void bench_embree_drop(bench_embree *embree)
{
    (void)embree;
}
