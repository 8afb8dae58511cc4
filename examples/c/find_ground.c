/* Walkable ground in a picture, with onnxruntime's C library.

       find_ground MODEL.onnx PICTURE.ppm OUT_DIR FX FY HEIGHT WIDTH

   PICTURE is binary PPM (P6), upright; FX and FY are the camera's, in its pixels; HEIGHT and WIDTH
   are the network's. OUT_DIR, which must be there, gets masks and metres as NumPy files, by the
   names of fp-export's test vectors. */

#define _POSIX_C_SOURCE 200112L /* setenv */

#include <math.h>
#include <onnxruntime_c_api.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "resize.h"

static const OrtApi *ort;

static void fail(const char *what) {
    fprintf(stderr, "find_ground: %s\n", what);
    exit(1);
}

static void check(OrtStatus *status) {
    if (status) fail(ort->GetErrorMessage(status));
}

static void *have(void *memory) {
    if (!memory) fail("no memory");
    return memory;
}

/* A binary PPM; the pixels are the caller's to free. */
static uint8_t *read_ppm(const char *path, int *height, int *width) {
    FILE *file = fopen(path, "rb");
    if (!file) fail("the picture cannot be opened");
    if (fscanf(file, "P6 %d %d 255", width, height) != 2) fail("the picture is no 8-bit P6 file");
    if (*width < 1 || *height < 1 || *width > 32768 || *height > 32768) fail("strange picture size");
    fgetc(file);
    size_t size = (size_t)*height * *width * 3;
    uint8_t *rgb = have(malloc(size));
    if (fread(rgb, 1, size, file) != size) fail("the picture ends too early");
    fclose(file);
    return rgb;
}

/* A NumPy file; `type` is |u1 or <f4 (this machine is taken to be little-endian). */
static void write_npy(const char *folder, const char *name, const char *type, const char *shape,
                      const void *values, size_t bytes) {
    char path[4096], header[119];
    snprintf(path, sizeof path, "%s/%s.npy", folder, name);
    int used = snprintf(header, sizeof header,
                        "{'descr': '%s', 'fortran_order': False, 'shape': (%s), }", type, shape);
    memset(header + used, ' ', sizeof header - used);
    header[117] = '\n';
    FILE *file = fopen(path, "wb");
    if (!file) fail("an output cannot be written");
    fwrite("\x93NUMPY\x01\x00\x76\x00", 1, 10, file);
    fwrite(header, 1, 118, file);
    if (fwrite(values, 1, bytes, file) != bytes || fclose(file)) fail("an output cannot be written");
}

/* A fact that the model file states about itself; never freed, the program is short. */
static const char *fact(const OrtModelMetadata *metadata, OrtAllocator *allocator, const char *key) {
    char *value = NULL;
    check(ort->ModelMetadataLookupCustomMetadataMap(metadata, allocator, key, &value));
    if (!value) fail("the model is not one of footprints-edge: it lacks footprints.* metadata");
    return value;
}

int main(int count, char **words) {
    if (count != 8) fail("usage: find_ground MODEL PICTURE.ppm OUT_DIR FX FY HEIGHT WIDTH");
    const char *model = words[1], *folder = words[3];
    double fx = atof(words[4]), fy = atof(words[5]);
    int h = atoi(words[6]), w = atoi(words[7]), height, width;
    uint8_t *rgb = read_ppm(words[2], &height, &width);

    /* onnxruntime reports to its maker unless this is set before it starts; 0 lets it */
    setenv("ORT_DISABLE_TELEMETRY", "1", 0);
    ort = OrtGetApiBase()->GetApi(ORT_API_VERSION);
    if (!ort) fail("the onnxruntime library is older than its header");
    OrtEnv *env;
    OrtSessionOptions *options;
    OrtSession *session;
    OrtAllocator *allocator;
    OrtModelMetadata *metadata;
    check(ort->CreateEnv(ORT_LOGGING_LEVEL_WARNING, "find_ground", &env));
    check(ort->CreateSessionOptions(&options));
    check(ort->CreateSession(env, model, options, &session));
    check(ort->GetAllocatorWithDefaultOptions(&allocator));
    check(ort->SessionGetModelMetadata(session, &metadata));
    double near_m, far_m, focal_px, scale = 1;
    if (sscanf(fact(metadata, allocator, "footprints.depth_range_m"), "%lf,%lf", &near_m, &far_m) != 2)
        fail("footprints.depth_range_m cannot be read");
    if (sscanf(fact(metadata, allocator, "footprints.camera"), "focal_px=%lf", &focal_px) == 1)
        scale = sqrt(fx * w / width * fy * h / height) / focal_px;
    int lanczos = !strcmp(fact(metadata, allocator, "footprints.resize"), "lanczos");

    uint8_t *input = have(resize(rgb, height, width, h, w, lanczos ? LANCZOS : BILINEAR));
    int64_t shape[] = {1, h, w, 3};
    OrtMemoryInfo *memory;
    OrtValue *image, *output = NULL;
    check(ort->CreateCpuMemoryInfo(OrtArenaAllocator, OrtMemTypeDefault, &memory));
    check(ort->CreateTensorWithDataAsOrtValue(memory, input, (size_t)h * w * 3, shape, 4,
                                              ONNX_TENSOR_ELEMENT_DATA_TYPE_UINT8, &image));
    const char *input_names[] = {"image"}, *output_names[] = {"maps"};
    check(ort->Run(session, NULL, input_names, (const OrtValue *const *)&image, 1, output_names, 1,
                   &output));
    float *maps;
    check(ort->GetTensorMutableData(output, (void **)&maps));

    size_t pixels = (size_t)h * w;
    uint8_t *masks = have(malloc(3 * pixels));
    float *metres = have(malloc(2 * pixels * sizeof *metres));
    for (size_t i = 0; i < pixels; i++) {
        int visible = maps[i] > 0.5f, ground = maps[pixels + i] > 0.5f;
        masks[i] = visible;
        masks[pixels + i] = ground;
        masks[2 * pixels + i] = ground && !visible;
        for (int k = 0; k < 2; k++) {
            double disparity = maps[(2 + k) * pixels + i];
            metres[k * pixels + i] = scale / (1 / far_m + (1 / near_m - 1 / far_m) * disparity);
        }
        if (!ground) metres[pixels + i] = NAN;
    }

    char sides[32], of_input[64], of_maps[64];
    snprintf(sides, sizeof sides, "%d, %d", h, w);
    snprintf(of_input, sizeof of_input, "1, %s, 3", sides);
    snprintf(of_maps, sizeof of_maps, "1, 4, %s", sides);
    write_npy(folder, "input", "|u1", of_input, input, 3 * pixels);
    write_npy(folder, "maps", "<f4", of_maps, maps, 4 * pixels * sizeof *maps);
    write_npy(folder, "visible_ground", "|u1", sides, masks, pixels);
    write_npy(folder, "ground", "|u1", sides, masks + pixels, pixels);
    write_npy(folder, "hidden_ground", "|u1", sides, masks + 2 * pixels, pixels);
    write_npy(folder, "visible_depth_m", "<f4", sides, metres, pixels * sizeof *metres);
    write_npy(folder, "ground_depth_m", "<f4", sides, metres + pixels, pixels * sizeof *metres);

    ort->ReleaseValue(output);
    ort->ReleaseValue(image);
    ort->ReleaseMemoryInfo(memory);
    ort->ReleaseModelMetadata(metadata);
    ort->ReleaseSession(session);
    ort->ReleaseSessionOptions(options);
    ort->ReleaseEnv(env);
    free(metres);
    free(masks);
    free(input);
    free(rgb);
    return 0;
}
