/* Images written row by row: what rt_image_save stands on, and what renders too large for the memory write their bands through.
 */
#ifndef RTI_SAVE_H
#define RTI_SAVE_H

#include "image.h"

typedef struct rti_row_writer rti_row_writer;

/* Begins a file of width x height pixels. The format is desc->format or the path's ending; desc NULL: defaults. The texts must
 * live until close. PNG, BMP, TGA and HDR hold one row in memory, JPEG the whole picture (3 bytes a pixel). The same pixels give
 * the same bytes: no file carries a date. PNG and TGA take the fourth channel as alpha when desc->alpha is set, colours as they
 * are (not divided by it). Errors IO, ARGUMENT, UNSUPPORTED, MEMORY; *writer is NULL then. */
rt_status rti_rows_open(rt_context *ctx, const char *path, uint32_t width, uint32_t height, const rt_save_desc *desc,
                        const rti_text *texts, size_t text_count, rti_row_writer **writer);
/* The next rows from the top: float[4 * width] each, linear. The first error is kept and returned again. */
rt_status rti_rows_write(rti_row_writer *writer, const float *rgba, uint32_t row_count);
/* Ends and frees. keep false, an earlier error, or rows missing (STATE): a file of that name stays as it was. */
rt_status rti_rows_close(rti_row_writer *writer, bool keep);

#endif
