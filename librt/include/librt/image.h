/** librt: images. Linear float RGBA in rows from the top, with text entries. */
#ifndef LIBRT_IMAGE_H
#define LIBRT_IMAGE_H

#include "librt/base.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Black, transparent. width, height 1 ... 1048576, memory within the context's limit and what the machine has free. Errors ARGUMENT, MEMORY, MEMORY_LIMIT. Owner the caller. */
RT_API rt_status rt_image_create(rt_context *context, uint32_t width, uint32_t height, rt_image **image);
RT_API void rt_image_destroy(rt_image *image);
RT_API uint32_t rt_image_width(const rt_image *image);
RT_API uint32_t rt_image_height(const rt_image *image);
/** The pixels: float[4] a pixel (linear R, G, B, coverage), row-major from the top left, no padding (but the image of a
 *  render into a caller's buffer stands in that buffer, pixels_stride from row to row). Valid until destroy. */
RT_API float *rt_image_pixels(rt_image *image);
RT_API const float *rt_image_pixels_const(const rt_image *image);

/** A text entry (metadata), kept in order; an equal key replaces. It goes into PNG text chunks and the comments of an HDR file's head; other formats
 *  hold none. The key has 1 ... 79 printable ASCII characters, no space at either end and no two in a row (PNG's rule); the value any bytes, UTF-8 for
 *  others to read it. Errors MEMORY, ARGUMENT (the key). */
RT_API rt_status rt_image_set_text(rt_image *image, const char *key, const char *value);
RT_API const char *rt_image_get_text(const rt_image *image, const char *key); /* NULL: none */

/** Reads PNG, JPEG, GIF, BMP, TGA, HDR (8-bit values are taken as sRGB). The size is checked against the memory limit before decoding; cut files are refused.
 *  Pixels alone: the file's texts are rt_image_read_texts'. Errors IO, FORMAT, MEMORY, UNSUPPORTED (built without a reader). */
RT_API rt_status rt_image_load(rt_context *context, const char *path, rt_image **image);

typedef struct rt_text {
    const char *key, *value; /**< as for rt_image_set_text */
} rt_text;

/** Called for each entry; the strings live until it returns. Non-zero: no more entries are wanted. */
typedef int (*rt_text_fn)(void *user, const char *key, const char *value);
/** Reads the text entries of an image file in their order, pixels aside: PNG's tEXt, zTXt and iTXt chunks as UTF-8, and of an HDR file what librt wrote
 *  into its comments and the variables of its head (KEY=VALUE, FORMAT left out). JPEG, GIF, BMP and TGA have none: no call, OK. A value ends at its first
 *  NUL byte. At most 64 MiB of one entry are read, whatever the file promises; a damaged file may have told entries before the error.
 *  Errors IO, FORMAT (no image, cut, checksum wrong: the sentence names the byte), MEMORY, ARGUMENT. Threads any. */
RT_API rt_status rt_image_read_texts(rt_context *context, const char *path, rt_text_fn entry, void *user);

typedef enum rt_tone { RT_TONE_NONE = 0, RT_TONE_FILMIC } rt_tone;
typedef struct rt_save_desc {
    uint32_t struct_size;
    const char *format; /**< "png", "jpg", "bmp", "tga", "hdr"; NULL: by the path's ending */
    float exposure;     /**< stops: values are multiplied by 2^exposure */
    rt_tone tone;       /**< curve before the sRGB encoding (not for hdr) */
    uint32_t bits;      /**< PNG: 8 or 16 */
    uint32_t quality;   /**< JPEG: 1 ... 100 */
    int alpha;          /**< PNG, TGA: keep the coverage as alpha; colours stay as they are, in a render mixed with the background's */
    int no_text;        /**< leave the text entries out */
    const rt_text *texts; /**< [text_count] entries beside the image's own, which an equal key replaces; copied into the file */
    uint32_t text_count;
} rt_save_desc;
RT_API rt_save_desc rt_save_desc_default(void);
/** Writes the file beside the target and renames it when whole; "-" is standard output (format needed). Without libpng, PNG has 8 bits.
 *  Errors IO (disk full, no such folder; the old file stays), UNSUPPORTED (format unknown or not built; named), ARGUMENT. */
RT_API rt_status rt_image_save(const rt_image *image, const char *path, const rt_save_desc *desc);

/** Hash of size and float pixels, bit for bit: 32 hex digits and NUL. */
RT_API void rt_image_hash(const rt_image *image, char text[33]);

typedef struct rt_image_difference {
    uint64_t differing_pixels;  /**< any channel, any bit (after the encoding to 8 bits when both come from 8-bit files, otherwise as floats) */
    uint32_t first_x, first_y;  /**< the first of them in reading order */
    double max_abs, mse, psnr;  /**< over RGB as sRGB-encoded values in 0 ... 1; psnr is infinite when equal */
} rt_image_difference;
/** Errors ARGUMENT when the sizes differ (the sentence names them). difference_map: NULL or receives an image of |a - b|. */
RT_API rt_status rt_image_compare(const rt_image *a, const rt_image *b, rt_image_difference *difference, rt_image **difference_map);
/** Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of two images of one size: 1 when equal, less the less alike, never below -1. Of the luma
 *  0.2126 R + 0.7152 G + 0.0722 B of sRGB-encoded values in 0 ... 1, with the paper's Gaussian window of 11 x 11 pixels (deviation 1.5), K1 0.01, K2 0.03, no
 *  downsampling; the mean over all windows that lie inside, as in the authors' own program. In an image with a side below 11, and in the map, windows are
 *  cut at the border and their weights made up. map: NULL or receives the local value of each pixel, in all three channels.
 *  Errors ARGUMENT when the sizes differ, MEMORY. Threads any. */
RT_API rt_status rt_image_ssim(const rt_image *a, const rt_image *b, double *ssim, rt_image **map);
/** FLIP (Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild 2020): the difference that a person sees who flips between two images of one size
 *  on a screen; 0 where they are equal, at most 1, the same for (a, b) and (b, a). Of linear values clamped to 0 ... 1 (FLIP for LDR images; a tone curve is
 *  applied before). pixels_per_degree: of the eye's view, 1 ... 1000; 0 is 67.02, the authors' default: 3840 pixels on 0.7 m seen from 0.7 m. Filters reach 8
 *  minutes of arc; beyond the border the outermost pixels go on. mean: NULL or receives the mean over all pixels; map: NULL or receives the value of each
 *  pixel, in all three channels. The same bits on every machine. Time grows with pixels_per_degree.
 *  Errors ARGUMENT when the sizes differ or pixels_per_degree is out of range, MEMORY. Threads any. */
RT_API rt_status rt_image_flip(const rt_image *a, const rt_image *b, double pixels_per_degree, double *mean, rt_image **map);

#ifdef __cplusplus
}
#endif
#endif
