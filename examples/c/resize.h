/* Antialiased resizing with the arithmetic of Pillow's Image.resize; see docs/porting.md. */
#ifndef RESIZE_H
#define RESIZE_H

#include <stdint.h>

enum filter { BILINEAR, LANCZOS };

/* Resizes an RGB picture of 8 bits. The result, height * width * 3 bytes, is the caller's to free;
   NULL if there is no memory. */
uint8_t *resize(const uint8_t *rgb, int from_height, int from_width, int height, int width,
                enum filter filter);

#endif
