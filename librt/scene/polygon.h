/* Cutting one polygon into triangles. */
#ifndef RTI_POLYGON_H
#define RTI_POLYGON_H

#include <stdint.h>

/* Ear clipping. positions: float[3] a vertex; corners [n], n >= 3, indices into it; scratch: [3 n]; triangles out: [3 (n - 2)],
 * always that many, wound as the polygon is. Simple polygons that are near to planar come out exact; crossing or folded ones come
 * out as some n - 2 triangles of their corners. O(n r) for r reflex corners. Source  Meisters 1975; the rotation to the next ear
 * after each cut keeps fans from becoming slivers (Held 2001). */
void rti_polygon_triangulate(const float *positions, const uint32_t *corners, uint32_t n, uint32_t *scratch, uint32_t *triangles);

#endif
