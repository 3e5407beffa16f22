/* Finished bands of rt_render_to_file, kept on disk until the image is whole: a head with the key, then a record a band, each
 * brought to disk before the next begins. A record that is cut or has a wrong hash at the file's end is one that was being
 * written: it is dropped. */
#ifndef RTI_BAND_FILE_H
#define RTI_BAND_FILE_H

#include "checkpoint.h"
#include "save.h"

typedef struct rti_band_file {
    rt_context *ctx;
    rti_place place, inner_place;
    char *inner; /* PATH.band: the checkpoint of the band that is being rendered */
    size_t inner_size;
    uint64_t size; /* of what is good */
    uint32_t width, height, rows; /* rows: finished */
} rti_band_file;

/* Opens or makes it, and writes the rows it holds to the image's writer. Errors IO, FORMAT, STATE (of another render). */
rt_status rti_bands_open(rt_context *ctx, const char *path, const rti_check_key *key, uint32_t width, uint32_t height,
                         rti_row_writer *writer, rti_band_file *file);
/* The next rows: dense, float[4 * width] each. */
rt_status rti_bands_add(rti_band_file *file, const float *rgba, uint32_t rows);
/* whole: both files are removed. */
void rti_bands_close(rti_band_file *file, bool whole);

#endif
