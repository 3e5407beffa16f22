#include "binding.h"

/* Shapes: each function takes (scene, description, material id) and returns the geometry's id. */

static rt_geometry_common common(lua_State *L, rt_geometry_common d)
{
    d.material.id = rtl_check_u32(L, 3, "material");
    rtl_field_u32(L, 2, "mask", &d.mask);
    rtl_field_u32(L, 2, "user_id", &d.user_id);
    rtl_field_floats(L, 2, "uv_transform", d.uv_transform, 6);
    return d;
}

static int done(lua_State *L, rtl_context *c, rt_status status, rt_geometry id)
{
    rtl_check(L, c, status);
    lua_pushinteger(L, id.id);
    return 1;
}

static int sphere(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_sphere_desc d = rt_sphere_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "center", &d.center);
    rtl_field_float(L, 2, "radius", &d.radius);
    rt_geometry id;
    rt_status status = rt_scene_add_sphere(scene, &d, &id);
    return done(L, c, status, id);
}

static uint32_t count_of(lua_State *L, const rtl_buffer *b, size_t width, const char *what)
{
    if (b->count % width || b->count / width > UINT32_MAX) {
        rtl_raise(L, "%s has %I numbers; they must be a multiple of %d, and not more than 2^32 items", what,
                  (LUAI_UACINT)b->count, (int)width);
    }
    return (uint32_t)(b->count / width);
}

/* The buffer in `key`, which must have `count` items of `width` values when it is there. */
static const rtl_buffer *items(lua_State *L, const char *key, rtl_type type, uint32_t count, size_t width, const char *of)
{
    const rtl_buffer *b = rtl_field_buffer(L, 2, key, type);
    if (b && b->count != count * width) {
        rtl_raise(L, "%s has %I values, but %I %s need %I", key, (LUAI_UACINT)b->count, (LUAI_UACINT)count, of,
                  (LUAI_UACINT)count * (LUAI_UACINT)width);
    }
    return b;
}

/* The same, as floats, or NULL; and as numbers of materials. */
static const float *floats(lua_State *L, const char *key, uint32_t count, size_t width, const char *of)
{
    const rtl_buffer *b = items(L, key, RTL_F32, count, width, of);
    return b ? b->as.f32 : NULL;
}

static const uint32_t *material_ids(lua_State *L, uint32_t count, const char *of)
{
    const rtl_buffer *b = items(L, "material_ids", RTL_U32, count, 1, of);
    return b ? b->as.u32 : NULL;
}

/* The points in `key`, which must be there: how many. */
static uint32_t points(lua_State *L, const char *key, const float **to)
{
    const rtl_buffer *b = rtl_field_buffer(L, 2, key, RTL_F32);
    if (!b) {
        rtl_raise(L, "%s is missing", key);
    }
    *to = b->as.f32;
    return count_of(L, b, 3, key);
}

static int spheres(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_spheres_desc d = rt_spheres_desc_default();
    d.common = common(L, d.common);
    d.count = points(L, "centers", &d.centers);
    d.radii = floats(L, "radii", d.count, 1, "spheres");
    d.colors = floats(L, "colors", d.count, 3, "spheres");
    d.face_materials = material_ids(L, d.count, "spheres");
    rtl_field_float(L, 2, "radius", &d.radius);
    rt_geometry id;
    rt_status status = rt_scene_add_spheres(scene, &d, &id);
    return done(L, c, status, id);
}

static int plane(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_plane_desc d = rt_plane_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "point", &d.point);
    rtl_field_vec3(L, 2, "normal", &d.normal);
    rtl_field_vec3(L, 2, "u_axis", &d.u_axis);
    rtl_field_float(L, 2, "texture_size", &d.texture_size);
    rtl_field_float(L, 2, "texture_height", &d.texture_height);
    rt_geometry id;
    rt_status status = rt_scene_add_plane(scene, &d, &id);
    return done(L, c, status, id);
}

static int box(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_box_desc d = rt_box_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "low", &d.low);
    rtl_field_vec3(L, 2, "high", &d.high);
    rt_geometry id;
    rt_status status = rt_scene_add_box(scene, &d, &id);
    return done(L, c, status, id);
}

static int cylinder(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_cone_desc d = rt_cone_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "from", &d.from);
    rtl_field_vec3(L, 2, "to", &d.to);
    rtl_field_float(L, 2, "radius", &d.radius0);
    d.radius1 = d.radius0;
    rt_geometry id;
    rt_status status = rt_scene_add_cylinder(scene, &d, &id);
    return done(L, c, status, id);
}

static int cone(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_cone_desc d = rt_cone_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "from", &d.from);
    rtl_field_vec3(L, 2, "to", &d.to);
    rtl_field_float(L, 2, "radius", &d.radius0);
    rtl_field_float(L, 2, "to_radius", &d.radius1);
    rt_geometry id;
    rt_status status = rt_scene_add_cone(scene, &d, &id);
    return done(L, c, status, id);
}

/* Many cylinders or cones. */
static rt_cones_desc cones_of(lua_State *L, const char *what)
{
    rt_cones_desc d = rt_cones_desc_default();
    d.common = common(L, d.common);
    d.count = points(L, "from", &d.from);
    d.to = floats(L, "to", d.count, 3, what);
    d.radii = floats(L, "radii", d.count, 1, what);
    d.colors = floats(L, "colors", d.count, 3, what);
    d.face_materials = material_ids(L, d.count, what);
    rtl_field_float(L, 2, "radius", &d.radius);
    return d;
}

/* What the library would say of an item by its number from 0. */
static void check_each_cone(lua_State *L, const rt_cones_desc *d, const char *noun, int pointed)
{
    for (uint32_t i = 0; i < d->count; i++) {
        const float *a = d->from + 3 * (size_t)i, *b = d->to + 3 * (size_t)i;
        const int same = a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
        const float r = d->radii ? d->radii[i] : d->radius, s = d->to_radii ? d->to_radii[i] : d->to_radius;
        if (same || (pointed && r == 0.0f && s == 0.0f)) {
            lua_pushfstring(
                L, same ? "from and to of %s %I are the same point" : "%s %I has radius 0 at both ends; one must be greater",
                noun, (LUAI_UACINT)i + 1);
            rtl_raise_text(L, lua_tostring(L, -1), RT_ERROR_ARGUMENT);
        }
    }
}

static int cylinders(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_cones_desc d = cones_of(L, "cylinders");
    check_each_cone(L, &d, "cylinder", 0);
    rt_geometry id;
    rt_status status = rt_scene_add_cylinders(scene, &d, &id);
    return done(L, c, status, id);
}

static int cones(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_cones_desc d = cones_of(L, "cones");
    d.to_radii = floats(L, "to_radii", d.count, 1, "cones");
    rtl_field_float(L, 2, "to_radius", &d.to_radius);
    check_each_cone(L, &d, "cone", 1);
    rt_geometry id;
    rt_status status = rt_scene_add_cones(scene, &d, &id);
    return done(L, c, status, id);
}

static int torus(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_torus_desc d = rt_torus_desc_default();
    d.common = common(L, d.common);
    rtl_field_vec3(L, 2, "center", &d.center);
    rtl_field_vec3(L, 2, "axis", &d.axis);
    rtl_field_float(L, 2, "major_radius", &d.major_radius);
    rtl_field_float(L, 2, "minor_radius", &d.minor_radius);
    rt_geometry id;
    rt_status status = rt_scene_add_torus(scene, &d, &id);
    return done(L, c, status, id);
}

static int mesh(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_mesh_desc d = rt_mesh_desc_default();
    d.common = common(L, d.common);
    const rtl_buffer *positions = rtl_field_buffer(L, 2, "vertices", RTL_F32),
                     *indices = rtl_field_buffer(L, 2, "faces", RTL_U32);
    if (!positions || !indices) {
        return rtl_raise(L, "%s is missing", positions ? "faces" : "vertices");
    }
    d.positions = positions->as.f32;
    d.vertex_count = count_of(L, positions, 3, "vertices");
    d.indices = indices->as.u32;
    d.triangle_count = count_of(L, indices, 3, "faces");
    const rtl_buffer *normals = items(L, "normals", RTL_F32, d.vertex_count, 3, "vertices");
    const rtl_buffer *uvs = items(L, "uvs", RTL_F32, d.vertex_count, 2, "vertices");
    const rtl_buffer *colors = items(L, "colors", RTL_F32, d.vertex_count, 3, "vertices");
    const rtl_buffer *materials = items(L, "material_ids", RTL_U32, d.triangle_count, 1, "faces");
    int smooth = 0;
    rtl_field_bool(L, 2, "smooth", &smooth);
    d.normals = normals ? normals->as.f32 : NULL;
    d.uvs = uvs ? uvs->as.f32 : NULL;
    d.colors = colors ? colors->as.f32 : NULL;
    d.face_materials = materials ? materials->as.u32 : NULL;
    rt_geometry id;
    rt_status status = rt_scene_add_mesh(scene, &d, &id);
    if (status == RT_OK && smooth && (status = rt_scene_smooth_mesh(scene, id)) != RT_OK) {
        rt_scene_remove_geometry(scene, id);
    }
    return done(L, c, status, id);
}

static int polyhedron(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_polyhedron_desc d = rt_polyhedron_desc_default();
    d.common = common(L, d.common);
    const rtl_buffer *positions = rtl_field_buffer(L, 2, "vertices", RTL_F32),
                     *sizes = rtl_field_buffer(L, 2, "face_sizes", RTL_U32),
                     *indices = rtl_field_buffer(L, 2, "indices", RTL_U32);
    if (!positions || !sizes || !indices) {
        return rtl_raise(L, "vertices and faces are missing");
    }
    d.positions = positions->as.f32;
    d.vertex_count = count_of(L, positions, 3, "vertices");
    d.face_sizes = sizes->as.u32;
    d.face_count = count_of(L, sizes, 1, "faces");
    d.indices = indices->as.u32;
    d.index_count = indices->count;
    rt_geometry id;
    rt_status status = rt_scene_add_polyhedron(scene, &d, &id);
    return done(L, c, status, id);
}

/* mesh_file(scene, description, material id) -> first geometry, count, triangles, vertices */
static int mesh_file(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_import_desc d = rt_import_desc_default();
    d.common = common(L, d.common);
    rtl_field_floats(L, 2, "transform", d.transform.m, 12);
    rtl_field_bool(L, 2, "ignore_materials", &d.ignore_materials);
    rtl_field_bool(L, 2, "smooth", &d.smooth);
    rtl_field_float(L, 2, "smooth_angle", &d.smooth_angle_deg);
    lua_getfield(L, 2, "path");
    const char *path = rtl_check_path(L, -1);
    rt_import_result r;
    rtl_check(L, c, rt_scene_import(scene, path, &d, &r));
    lua_pushinteger(L, r.first.id);
    lua_pushinteger(L, r.geometry_count);
    lua_pushinteger(L, (lua_Integer)r.triangles);
    lua_pushinteger(L, (lua_Integer)r.vertices);
    return 4;
}

/* set_vertices(scene, geometry, { vertices, normals or nil, smooth: make normals of the faces }) */
static int set_vertices(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_geometry geometry = {rtl_check_u32(L, 2, "geometry")};
    luaL_checktype(L, 3, LUA_TTABLE);
    const rtl_buffer *positions = rtl_field_buffer(L, 3, "vertices", RTL_F32),
                     *normals = rtl_field_buffer(L, 3, "normals", RTL_F32);
    if (!positions) {
        return rtl_raise(L, "vertices is missing");
    }
    uint32_t count = count_of(L, positions, 3, "vertices");
    if (normals && normals->count != positions->count) {
        return rtl_raise(L, "normals has %I values, but %I vertices need %I", (LUAI_UACINT)normals->count, (LUAI_UACINT)count,
                         (LUAI_UACINT)positions->count);
    }
    int smooth = 0;
    rtl_field_bool(L, 3, "smooth", &smooth);
    rtl_check(L, c, rt_scene_set_mesh_positions(scene, geometry, positions->as.f32, normals ? normals->as.f32 : NULL, count));
    if (smooth) {
        rtl_check(L, c, rt_scene_smooth_mesh(scene, geometry));
    }
    return 0;
}

/* instance(scene, description, material id | nil, child) -> id */
static int instance(lua_State *L)
{
    rtl_context *c;
    rt_scene *scene = rtl_check_scene(L, 1, &c);
    rt_instance_desc d = rt_instance_desc_default();
    d.child = rtl_check_scene(L, 4, NULL);
    rtl_field_floats(L, 2, "transform", d.transform.m, 12);
    if (lua_getfield(L, 2, "motion") == LUA_TTABLE) { /* 12 numbers a place */
        d.motion_count = (uint32_t)(lua_rawlen(L, -1) / 12);
        rt_transform *places = lua_newuserdatauv(L, d.motion_count * sizeof *places, 0);
        for (uint32_t i = 0; i < 12 * d.motion_count; i++) {
            lua_rawgeti(L, -2, (lua_Integer)i + 1);
            places[i / 12].m[i % 12] = (float)lua_tonumber(L, -1);
            lua_pop(L, 1);
        }
        d.motion = places; /* stays on the stack */
    }
    if (!lua_isnil(L, 3)) {
        d.material.id = rtl_check_u32(L, 3, "material");
    }
    rtl_field_u32(L, 2, "mask", &d.mask);
    rtl_field_u32(L, 2, "user_id", &d.user_id);
    rt_instance id;
    rtl_check(L, c, rt_scene_add_instance(scene, &d, &id));
    lua_pushinteger(L, id.id);
    return 1;
}

void rtl_open_geometry(lua_State *L)
{
    static const luaL_Reg functions[] = {{"add_sphere", sphere},     {"add_spheres", spheres},       {"add_plane", plane},
                                         {"add_box", box},           {"add_cylinder", cylinder},     {"add_cylinders", cylinders},
                                         {"add_cone", cone},         {"add_cones", cones},           {"add_torus", torus},
                                         {"add_mesh", mesh},         {"add_polyhedron", polyhedron}, {"add_mesh_file", mesh_file},
                                         {"add_instance", instance}, {"set_vertices", set_vertices}, {NULL, NULL}};
    rtl_add_functions(L, functions);
}
