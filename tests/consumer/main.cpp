// The same program in C++17, owners in unique_ptr.
#include <librt/rt.h>

#include <cstdio>
#include <memory>

template <auto destroy> struct destroyer {
    template <class T> void operator()(T *p) const { destroy(p); }
};
using context_ptr = std::unique_ptr<rt_context, destroyer<rt_context_destroy>>;
using scene_ptr = std::unique_ptr<rt_scene, destroyer<rt_scene_destroy>>;
using image_ptr = std::unique_ptr<rt_image, destroyer<rt_image_destroy>>;

int main()
{
    rt_context *c = nullptr;
    if (rt_context_create(nullptr, &c) != RT_OK)
        return 1;
    context_ptr context(c);
    rt_scene *s = nullptr;
    if (rt_scene_create(c, &s) != RT_OK)
        return 1;
    scene_ptr scene(s);

    auto sphere = rt_sphere_desc_default();
    sphere.radius = 1;
    auto render = rt_render_desc_default();
    render.width = render.height = 16;
    render.samples = 1;
    rt_image *i = nullptr;
    if (rt_scene_add_sphere(s, &sphere, nullptr) != RT_OK || rt_scene_commit(s, nullptr) != RT_OK || rt_render(s, &render, &i) != RT_OK)
        return 1;
    image_ptr image(i);
    char hash[33];
    rt_image_hash(i, hash);
    std::printf("librt %s %s\n", rt_version(), hash);
}
