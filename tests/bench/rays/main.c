/* The ray benchmark as a program of its own: C alone, no Lua. */
#include "rays.h"

int main(int argc, char **argv)
{
    return bench_rays_main(argc, argv, NULL);
}
