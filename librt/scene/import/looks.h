/* Looks of a model: reading the libraries they stand in, and making materials of them. */
#ifndef RTI_LOOKS_H
#define RTI_LOOKS_H

#include "librt/scene.h"
#include "model.h"

/* Reads the material libraries that the mesh at path names, from beside it. A library that cannot be read is a warning. */
rt_status rti_looks_read(rti_model *model, const char *path);

/* What a look becomes, without textures:
 *   color           Kd (white when a texture stands in place of a black Kd, which many exporters write)
 *   transparency    1 - d (or Tr)
 *   reflectiveness  the mean of Ks for illum 3 ... 9 (ray-traced reflection)
 *   diffusion       what those two leave of 1
 *   refractiveness  Ni for illum 4, 6, 7 and 9 (glass, refraction); otherwise 1: dissolved, not bent
 *   specular        the mean of Ks, for illum 2 and more or none given; shininess Ns, at least 1
 *   emission        Ke: a Ke above 0 makes the material emissive
 *   Ka, Tf, bump and other maps have no place. */
rt_material_desc rti_look_material(const rti_look *look);

/* Adds a material for each defined look, with its textures (a missing one is a warning); materials [look_count] out. */
rt_status rti_looks_add(rt_scene *scene, rti_model *model, const char *path, rt_material *materials);

#endif
