/* Cutting one polygon into triangles. */
#ifndef RTI_POLYGON_H
#define RTI_POLYGON_H

#include <stdint.h>

#define RTI_POLYGON_SCRATCH 6 /* words of scratch a corner */

/* Ear clipping. positions: float[3] a vertex; corners [n], n >= 3, indices into it; scratch: [RTI_POLYGON_SCRATCH n]; triangles
 * out: [3 (n - 2)], always that many, wound as the polygon is. Simple polygons that are near to planar come out exact; crossing
 * or folded ones come out as some n - 2 triangles of their corners. Linear time, bounded by a few thousand steps a corner: a
 * corner is looked at again only when a neighbour is cut, and a grid finds the corners that may lie in its ear. Source  Meisters
 * 1975; Eberly, Triangulation by Ear Clipping, 2002 (the queue); first in, first out keeps fans from becoming slivers. */
void rti_polygon_triangulate(const float *positions, const uint32_t *corners, uint32_t n, uint32_t *scratch, uint32_t *triangles);

#endif
