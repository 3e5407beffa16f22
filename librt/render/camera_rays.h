/* The source of the wavefront. */
#ifndef RTI_CAMERA_RAYS_H
#define RTI_CAMERA_RAYS_H

#include "wavefront.h"

/* Fills the batch from its start with at most `room` camera rays, opening tiles as needed; returns how many. Fewer than
 * room - RTK_BLOCK only when there are no tiles or no free slots left. */
uint32_t rti_make_camera_rays(rti_worker *worker, uint32_t room);

#endif
