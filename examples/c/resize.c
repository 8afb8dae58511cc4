#include "resize.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FRACTION_BITS = 32 - 8 - 2 }; /* of the weights: room for 8 bits, a sign and overshoot */

static const double PI = 3.14159265358979323846;

static double sinc(double x) { return x == 0 ? 1 : sin(PI * x) / (PI * x); }

static double weight_at(double x, enum filter filter) {
    if (filter == LANCZOS) return x >= -3 && x < 3 ? sinc(x) * sinc(x / 3) : 0;
    return fabs(x) < 1 ? 1 - fabs(x) : 0;
}

/* Resizes along one axis: `lines` lines of `from` pixels, `step` bytes from pixel to pixel, `pitch`
   bytes from line to line. Returns 0 if there is no memory. */
static int resize_lines(const uint8_t *source, int from, int source_step, int source_pitch,
                        uint8_t *result, int to, int step, int pitch, int lines,
                        enum filter filter) {
    double scale = (double)from / to, stretch = scale > 1 ? scale : 1;
    double reach = (filter == LANCZOS ? 3 : 1) * stretch;
    int most = 2 * (int)ceil(reach) + 1;
    double *exact = malloc(most * sizeof *exact);
    int32_t *weights = malloc(most * sizeof *weights);
    for (int i = 0; exact && weights && i < to; i++) {
        double centre = (i + 0.5) * scale, total = 0;
        int first = (int)(centre - reach + 0.5), end = (int)(centre + reach + 0.5);
        if (first < 0) first = 0;
        if (end > from) end = from;
        for (int j = first; j < end; j++)
            total += exact[j - first] = weight_at((j - centre + 0.5) / stretch, filter);
        for (int j = 0; j < end - first; j++)
            weights[j] = (int32_t)lround(exact[j] / total * (1 << FRACTION_BITS));
        for (int line = 0; line < lines; line++)
            for (int c = 0; c < 3; c++) {
                const uint8_t *read = source + line * source_pitch + first * source_step + c;
                int32_t sum = 1 << (FRACTION_BITS - 1);
                for (int j = 0; j < end - first; j++) sum += read[j * source_step] * weights[j];
                sum >>= FRACTION_BITS;
                result[line * pitch + i * step + c] = sum < 0 ? 0 : sum > 255 ? 255 : sum;
            }
    }
    int done = exact && weights;
    free(exact);
    free(weights);
    return done;
}

uint8_t *resize(const uint8_t *rgb, int from_height, int from_width, int height, int width,
                enum filter filter) {
    uint8_t *narrow = malloc((size_t)from_height * width * 3);
    uint8_t *result = malloc((size_t)height * width * 3);
    int done = narrow && result;
    if (done && from_width == width)
        memcpy(narrow, rgb, (size_t)from_height * width * 3);
    else if (done)
        done = resize_lines(rgb, from_width, 3, from_width * 3, narrow, width, 3, width * 3,
                            from_height, filter);
    if (done && from_height == height)
        memcpy(result, narrow, (size_t)height * width * 3);
    else if (done)
        done = resize_lines(narrow, from_height, width * 3, 3, result, height, width * 3, 3, width,
                            filter);
    free(narrow);
    if (done) return result;
    free(result);
    return NULL;
}
