/* The nearest free ground in a picture, by the C interface of footprints-edge.

       nearest_ground MODEL.onnx PICTURE.ppm [CAMERA_HEIGHT_M]

   PICTURE is binary PPM (P6), upright. Of the camera no more is known than its height, if given. */
#include <footprints_edge.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(fpe_status status) {
    if (status == FPE_OK) return;
    fprintf(stderr, "nearest_ground: %s\n", fpe_last_error());
    exit(1);
}

static void fail(const char *path, const char *what) {
    fprintf(stderr, "nearest_ground: %s %s\n", path, what);
    exit(1);
}

/* The pixels are the caller's to free. */
static uint8_t *read_ppm(const char *path, int *height, int *width) {
    FILE *file = fopen(path, "rb");
    if (!file) fail(path, "cannot be opened");
    int most;
    if (fscanf(file, "P6 %d %d %d", width, height, &most) != 3 || most != 255)
        fail(path, "is no 8-bit P6 file");
    if (*width < 1 || *height < 1 || *width > 32768 || *height > 32768) fail(path, "has no size");
    fgetc(file);
    size_t size = (size_t)*height * *width * 3;
    uint8_t *rgb = malloc(size);
    if (!rgb || fread(rgb, 1, size, file) != size) fail(path, "ends too early");
    fclose(file);
    return rgb;
}

int main(int count, char **words) {
    if (count != 3 && count != 4) fail("usage:", "nearest_ground MODEL PICTURE.ppm [HEIGHT_M]");
    int height, width, rows, columns;
    uint8_t *rgb = read_ppm(words[2], &height, &width);
    fpe_options options = fpe_default_options();
    if (count == 4) options.camera_height_m = atof(words[3]);
    fpe_model *model;
    fpe_prediction *prediction;
    fpe_grid *grid;
    check(fpe_load(words[1], 0, &model));
    check(fpe_predict(model, rgb, height, width, NULL, &options, &prediction));
    check(fpe_top_down(prediction, 0.05, 10, FPE_ROBOT_HEIGHT_M, &grid));

    const uint8_t *cells = fpe_grid_cells(grid);
    double nearest_m = INFINITY, ahead_m = 0, left_m = 0, x, y;
    fpe_grid_size(grid, &rows, &columns);
    for (int row = 0; row < rows; row++)
        for (int column = 0; column < columns; column++) {
            fpe_grid_place(grid, row, column, &x, &y);
            if (cells[row * columns + column] != FPE_FREE || hypot(x, y) >= nearest_m) continue;
            nearest_m = hypot(x, y), ahead_m = x, left_m = y;
        }
    if (isinf(nearest_m))
        printf("no free ground within 10 m\n");
    else
        printf("nearest free ground: %.2f m ahead, %.2f m to the %s\n", ahead_m, fabs(left_m),
               left_m < 0 ? "right" : "left");
    fpe_grid_free(grid);
    fpe_prediction_free(prediction);
    fpe_model_free(model);
    free(rgb);
    return 0;
}
