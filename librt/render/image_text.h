/* Text entries of image files: reading, and the form they have in an HDR file's head. */
#ifndef RTI_IMAGE_TEXT_H
#define RTI_IMAGE_TEXT_H

#include "image.h"

/* The rule for keys of rt_image_set_text. */
rt_status rti_text_check_key(rt_context *ctx, const char *what, const char *key);

/* rt_image_read_texts of bytes in memory. sums false: chunks with a wrong checksum are read as well (a fuzzer cannot guess them). */
rt_status rti_texts_decode(rt_context *ctx, const char *name, const void *bytes, size_t size, bool sums, rt_text_fn entry,
                           void *user);

/* The image's entries and the descriptor's, which replace those of an equal key. *all (NULL: none are needed) holds *count
 * entries, pointing to the originals; free with rti_free(ctx, *all, *size). */
rt_status rti_texts_merge(rt_context *ctx, const rti_text *texts, size_t text_count, const rt_text *more, uint32_t more_count,
                          rti_text **all, size_t *count, size_t *size);

/* Writes the entries as comment lines of an HDR head: "# KEY=VALUE", going on in lines "#+VALUE" so that none is longer than old
 * readers take; '\' stands before itself, newline (n) and carriage return (r). */
rt_status rti_texts_write_hdr(rti_writer *out, const rti_text *texts, size_t count);

#endif
