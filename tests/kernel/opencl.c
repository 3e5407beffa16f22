/* The kernel headers through an OpenCL driver: they and the tracers' walks build as CL 1.2 and 3.0, structs have the sizes they
 * have here, and where the device's floats are ours (denormals, correctly rounded division and root) every result is the same to
 * the bit. usage: opencl KERNEL_DIR TEST_DIR. Exit 77: no device to ask. */
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <stdio.h>
#include <stdlib.h>

#include "probe.h"

enum { ITEMS = 40000, SIZES = 14 };

typedef struct device {
    cl_device_id id;
    cl_context context;
    cl_command_queue queue;
    char name[256];
} device;

static void need(cl_int status, const char *what)
{
    if (status == CL_SUCCESS)
        return;
    fprintf(stderr, "%s: OpenCL error %d\n", what, (int)status);
    exit(1);
}

static device open_device(void)
{
    device d = {0};
    cl_platform_id platform[8];
    cl_uint platforms = 0;
    cl_int status;
    if (clGetPlatformIDs(8, platform, &platforms) != CL_SUCCESS)
        platforms = 0;
    for (cl_uint i = 0; i < platforms && i < 8 && !d.id; i++)
        if (clGetDeviceIDs(platform[i], CL_DEVICE_TYPE_ALL, 1, &d.id, NULL) != CL_SUCCESS)
            d.id = NULL;
    if (!d.id) {
        printf("skipped: no OpenCL device\n");
        exit(77);
    }
    clGetDeviceInfo(d.id, CL_DEVICE_NAME, sizeof d.name - 1, d.name, NULL);
    d.context = clCreateContext(NULL, 1, &d.id, NULL, NULL, &status);
    need(status, "context");
    d.queue = clCreateCommandQueue(d.context, d.id, 0, &status);
    need(status, "queue");
    return d;
}

/* Denormals and correctly rounded division are options in OpenCL; without them only the build is judged. */
static int exact(const device *d)
{
    cl_device_fp_config config = 0;
    clGetDeviceInfo(d->id, CL_DEVICE_SINGLE_FP_CONFIG, sizeof config, &config, NULL);
    return (config & CL_FP_DENORM) && (config & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT);
}

static cl_program build(const device *d, const char *source, const char *standard, const char *kernel_dir, const char *test_dir)
{
    char options[4096];
    cl_int status;
    cl_program program = clCreateProgramWithSource(d->context, 1, &source, NULL, &status);
    need(status, "program");
    snprintf(options, sizeof options, "-cl-std=%s %s -I%s -I%s", standard,
             exact(d) ? "-cl-fp32-correctly-rounded-divide-sqrt" : "", kernel_dir, test_dir);
    if (clBuildProgram(program, 1, &d->id, options, NULL, NULL) != CL_SUCCESS) {
        static char log[65536];
        clGetProgramBuildInfo(program, d->id, CL_PROGRAM_BUILD_LOG, sizeof log - 1, log, NULL);
        fprintf(stderr, "%s does not build:\n%s\n", standard, log);
        exit(1);
    }
    return program;
}

static cl_mem buffer(const device *d, size_t size, void *data)
{
    cl_int status;
    cl_mem m = clCreateBuffer(d->context, CL_MEM_READ_WRITE | (data ? CL_MEM_COPY_HOST_PTR : 0), size, data, &status);
    need(status, "buffer");
    return m;
}

static float unit(rtk_u32 *state)
{
    *state = rtk_mix(*state + 0x9e3779b9u);
    return rtk_unit_float(*state);
}

static rtk_vec3 vec(rtk_u32 *state, float size)
{
    float x = size * (2 * unit(state) - 1), y = size * (2 * unit(state) - 1), z = size * (2 * unit(state) - 1);
    return rtk_v3(x, y, z);
}

/* Rays from near and far at triangles and shapes in a box of 2, some of each odd kind. */
static void make_items(rtk_ray *rays, rtk_tri *tris, rtk_shape *shapes)
{
    rtk_u32 s = 1;
    for (int i = 0; i < ITEMS; i++) {
        rtk_vec3 v[3], target, c = vec(&s, 0.5f), n = rtk_unit(vec(&s, 1));
        for (int k = 0; k < 3; k++)
            v[k] = vec(&s, 1);
        if (i % 7 == 0)
            v[2] = rtk_madd(v[0], unit(&s), rtk_sub(v[1], v[0]));
        target = i % 3 == 0 ? v[0] : (i % 3 == 1 ? rtk_scale(rtk_add(v[0], v[1]), 0.5f) : c);
        rays[i].org = vec(&s, i % 5 == 0 ? 1e5f : 3.0f);
        rays[i].dir = rtk_sub(target, rays[i].org);
        if (i % 11 == 0)
            rays[i].dir.x = 0.0f;
        rays[i].tmin = -RTK_INF;
        rays[i].tmax = RTK_INF;
        rays[i].mask = ~0u;
        memset(&tris[i], 0, sizeof tris[i]);
        memcpy(tris[i].v0, &v[0], sizeof v[0]);
        memcpy(tris[i].v1, &v[1], sizeof v[1]);
        memcpy(tris[i].v2, &v[2], sizeof v[2]);
        memset(&shapes[i], 0, sizeof shapes[i]);
        shapes[i].type = (rtk_u32)i % RTK_SHAPE_PLANE;
        memcpy(shapes[i].p, &c, sizeof c);
        shapes[i].p[3] = 0.2f + 0.5f * unit(&s);
        if (shapes[i].type == RTK_SHAPE_TORUS)
            memcpy(shapes[i].p + 4, &n, sizeof n);
        else if (shapes[i].type == RTK_SHAPE_BOX)
            c = rtk_add(c, rtk_v3(0.3f, unit(&s), 0.7f)), memcpy(shapes[i].p + 3, &c, sizeof c);
        else
            c = rtk_madd(c, 0.7f, n), memcpy(shapes[i].p + 4, &c, sizeof c);
        if (shapes[i].type != RTK_SHAPE_BOX)
            shapes[i].p[7] = 0.15f * unit(&s);
    }
}

static void judge_sizes(const device *d, cl_program program)
{
    const rtk_u32 want[SIZES] = {
        sizeof(rtk_ray),      sizeof(rtk_tri),     sizeof(rtk_shape),   sizeof(rtk_geom),           sizeof(rtk_material),
        sizeof(rtk_instance), sizeof(rtk_light),   sizeof(rtk_world),   sizeof(rtk_texture_header), sizeof(rtk_tree_header),
        sizeof(rtk_kdnode),   sizeof(rtk_octnode), sizeof(rtk_bvhnode), sizeof(rtk_bvhblock)};
    rtk_u32 got[SIZES];
    cl_int status;
    cl_kernel kernel = clCreateKernel(program, "sizes", &status);
    cl_mem out = buffer(d, sizeof got, NULL);
    size_t one = 1;
    need(status, "kernel sizes");
    clSetKernelArg(kernel, 0, sizeof out, &out);
    need(clEnqueueNDRangeKernel(d->queue, kernel, 1, NULL, &one, NULL, 0, NULL, NULL), "run");
    need(clEnqueueReadBuffer(d->queue, out, CL_TRUE, 0, sizeof got, got, 0, NULL, NULL), "read");
    for (int i = 0; i < SIZES; i++)
        if (got[i] != want[i]) {
            fprintf(stderr, "struct %d has %u bytes there, %u here\n", i, got[i], want[i]);
            exit(1);
        }
    clReleaseMemObject(out);
    clReleaseKernel(kernel);
}

/* Words that differ; tells of the first. */
static int judge_bits(const device *d, cl_program program, cl_mem rays, cl_mem tris, cl_mem shapes, const rtk_u32 *want,
                      rtk_u32 *got)
{
    const size_t items = ITEMS, bytes = (size_t)ITEMS * PROBE_WORDS * sizeof *got;
    cl_int status;
    cl_kernel kernel = clCreateKernel(program, "probe", &status);
    cl_mem out = buffer(d, bytes, NULL);
    int wrong = 0;
    need(status, "kernel probe");
    clSetKernelArg(kernel, 0, sizeof rays, &rays);
    clSetKernelArg(kernel, 1, sizeof tris, &tris);
    clSetKernelArg(kernel, 2, sizeof shapes, &shapes);
    clSetKernelArg(kernel, 3, sizeof out, &out);
    need(clEnqueueNDRangeKernel(d->queue, kernel, 1, NULL, &items, NULL, 0, NULL, NULL), "run");
    need(clEnqueueReadBuffer(d->queue, out, CL_TRUE, 0, bytes, got, 0, NULL, NULL), "read");
    for (size_t i = 0; i < (size_t)ITEMS * PROBE_WORDS; i++)
        if (got[i] != want[i] && wrong++ == 0)
            fprintf(stderr, "item %zu, word %zu: %08x there, %08x here\n", i / PROBE_WORDS, i % PROBE_WORDS, got[i], want[i]);
    clReleaseMemObject(out);
    clReleaseKernel(kernel);
    return wrong;
}

int main(int argc, char **argv)
{
    static rtk_ray rays[ITEMS];
    static rtk_tri tris[ITEMS];
    static rtk_shape shapes[ITEMS];
    static rtk_u32 want[ITEMS * PROBE_WORDS], got[ITEMS * PROBE_WORDS];
    static const char *const standards[] = {"CL1.2", "CL3.0"};
    int hits = 0, wrong = 0;
    if (argc != 3)
        return 2;
    device d = open_device();
    make_items(rays, tris, shapes);
    for (rtk_u32 i = 0; i < ITEMS; i++) {
        probe_item(i, rays, tris, shapes, want + i * PROBE_WORDS);
        hits += want[i * PROBE_WORDS + 13] != 0 || want[i * PROBE_WORDS + 16] != 0;
    }
    cl_mem r = buffer(&d, sizeof rays, rays), t = buffer(&d, sizeof tris, tris), s = buffer(&d, sizeof shapes, shapes);
    for (int k = 0; k < 2; k++) {
        cl_program program = build(&d, "#include \"probe.cl\"\n", standards[k], argv[1], argv[2]);
        clReleaseProgram(build(&d, "#include \"../walks.h\"\n", standards[k], argv[1], argv[2]));
        judge_sizes(&d, program);
        int bad = judge_bits(&d, program, r, t, s, want, got);
        printf("%s as %s: %d of %d words differ (%d items with hits)\n", d.name, standards[k], bad, ITEMS * PROBE_WORDS, hits);
        wrong += exact(&d) ? bad : 0;
        clReleaseProgram(program);
    }
    clReleaseMemObject(r);
    clReleaseMemObject(t);
    clReleaseMemObject(s);
    clReleaseCommandQueue(d.queue);
    clReleaseContext(d.context);
    return wrong != 0 || hits < ITEMS / 4;
}
