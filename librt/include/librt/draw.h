/** librt: drawing into images. Resampling, rectangles, pictures in pictures, labels: what contact sheets and annotated frames need. All of it is
 *  in linear light, and gives the same bits on every machine. */
#ifndef LIBRT_DRAW_H
#define LIBRT_DRAW_H

#include "librt/image.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rt_resample {
    RT_RESAMPLE_AUTO = 0, /**< Mitchell: smooth, hardly rings */
    RT_RESAMPLE_BOX,      /**< the mean of what a pixel covers; enlarged: squares of the old pixels */
    RT_RESAMPLE_MITCHELL, /**< Mitchell and Netravali 1988, B = C = 1/3 */
    RT_RESAMPLE_LANCZOS   /**< Lanczos of three lobes: sharpest; what it overshoots is cut at the neighbours' range */
} rt_resample;

/** An image of another size, in linear light. Each side is treated by itself; shrinking widens the filter, so nothing is skipped.
 *  width, height 1 ... 1048576. Values that are no finite numbers are left out of the means (0 where nothing else is). Text entries are not taken
 *  over. A result of the same size is a copy.
 *  Errors ARGUMENT, MEMORY, MEMORY_LIMIT. Owner the caller. Threads: any, while nobody writes to the image. */
RT_API rt_status rt_image_resample(const rt_image *image, uint32_t width, uint32_t height, rt_resample filter, rt_image **resampled);

/** Sets the pixels of a rectangle to (r, g, b, coverage); x, y in pixels from the top left. What lies outside of the image is left out.
 *  Errors none. */
RT_API void rt_image_fill(rt_image *image, int32_t x, int32_t y, uint32_t width, uint32_t height, const float rgba[4]);

/** Copies the pixels of `other` with its top left corner at (x, y). What lies outside of the image is left out. Errors ARGUMENT (an image in
 *  itself). */
RT_API rt_status rt_image_place(rt_image *image, const rt_image *other, int32_t x, int32_t y);

typedef enum rt_color_map {
    RT_COLOR_MAP_GREY = 0, /**< black to white, even to the eye */
    RT_COLOR_MAP_VIRIDIS,  /**< dark blue, green, yellow */
    RT_COLOR_MAP_MAGMA     /**< black, purple, orange, pale yellow */
} rt_color_map;

/** The linear colour of a value: x 0 ... 1, clamped; NaN is 0. Lightness rises evenly, so a picture reads in grey and with any colour vision. The same
 *  bits on every machine. Errors none (an unknown map is grey). Threads any. */
RT_API rt_vec3 rt_color_map_at(rt_color_map map, float x);
/** A picture of an image's values: the largest of R, G, B of each pixel, `low` as 0 and `high` as 1, in the colours of the map; coverage is kept.
 *  Errors ARGUMENT (low not below high), MEMORY. Owner the caller. Threads any, while nobody writes to the image. */
RT_API rt_status rt_image_color_map(const rt_image *image, rt_color_map map, float low, float high, rt_image **colored);

typedef struct rt_label_desc {
    uint32_t struct_size;
    float x, y;     /**< the top left corner of the text, in pixels; -1e6 ... 1e6 */
    float size;     /**< height of a line in pixels, 4 ... 1000; capitals are two thirds of it */
    float weight;   /**< thickness of the strokes, 1 is regular; 0.25 ... 4 */
    rt_vec3 color;  /**< linear */
    float opacity;  /**< 0 ... 1 */
} rt_label_desc;
RT_API rt_label_desc rt_label_desc_default(void); /**< size 16, weight 1, white, opaque, at 0, 0 */

/** Draws UTF-8 text in the built-in stroke font: ASCII, the letters of Latin-1 and a few signs (en and em dash, ellipsis, multiplication sign,
 *  micro, arrows, ...); any other character, and each byte that is no UTF-8, is an empty box. A newline begins a new line, a tab is four spaces.
 *  Errors ARGUMENT. Threads: one a time an image. */
RT_API rt_status rt_image_label(rt_image *image, const char *text, const rt_label_desc *desc);

/** Width and height in pixels that the text takes with these desc->size and desc->weight (NULL: the default). Either may be NULL. Errors none: a
 *  size that is no number gives 0. */
RT_API void rt_label_size(const char *text, const rt_label_desc *desc, float *width, float *height);

#ifdef __cplusplus
}
#endif
#endif
