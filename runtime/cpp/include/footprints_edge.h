/* Walkable ground in a picture, seen and hidden, in metres. The C interface of footprints-edge.

   Functions that can fail return a status; `fpe_last_error` then says what happened, with which value,
   and what to do. No exception leaves the library. A pointer that a getter returns lives as long as
   the object it came from. A model may be used by many threads at a time, and so may a prediction.

   Sizes and shapes are (height, width). Pixel (0, 0) is the centre of the top left pixel. Camera axes:
   x right, y down, z forward. Ground coordinates: x forward and y left, metres, from the point of the
   ground plane straight below the camera (ROS REP-103). */
#ifndef FOOTPRINTS_EDGE_H
#define FOOTPRINTS_EDGE_H

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32) && defined(FPE_SHARED)
#ifdef FPE_BUILDING
#define FPE_API __declspec(dllexport)
#else
#define FPE_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define FPE_API __attribute__((visibility("default")))
#else
#define FPE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fpe_status {
    FPE_OK = 0,
    FPE_BAD_ARGUMENT = 1,    /* a value that cannot be */
    FPE_BAD_MODEL = 2,       /* a file that is missing, damaged or none of footprints-edge; or it fails */
    FPE_MISSING_MAP = 3,     /* the model was converted without the maps that this needs */
    FPE_NO_GROUND_PLANE = 4, /* the picture shows no ground, too little, none that is flat, or the
                                plane cannot be: fpe_no_ground_plane_reason */
    FPE_OUTSIDE = 5,         /* a path's start or goal is outside the picture */
    FPE_OFF_GROUND = 6,      /* a path's start or goal is not on ground, or too close to an obstacle */
    FPE_NO_PATH = 7,         /* no path connects the two */
    FPE_FAILED = 8           /* no memory, or a defect */
} fpe_status;

/* What the last call that failed on this thread says; empty if none did. */
FPE_API const char *fpe_last_error(void);

/* This library's version, such as "0.1.0". */
FPE_API const char *fpe_version(void);

/* ---- Cameras ---- */

/* A pinhole camera, in pixels of one image size. */
typedef struct fpe_camera {
    double fx, fy, cx, cy;
} fpe_camera;

/* From a horizontal field of view, degrees; from a 35 mm equivalent focal length, millimetres, as EXIF
   states it; the assumption for an unknown camera, 60 degrees along the longer side. They never fail:
   a prediction refuses a camera that cannot be. */
FPE_API fpe_camera fpe_camera_from_hfov(double hfov_deg, int height, int width);
FPE_API fpe_camera fpe_camera_from_focal_35mm(double focal_mm, int height, int width);
FPE_API fpe_camera fpe_camera_assumed(int height, int width);

/* ---- Models ---- */

typedef struct fpe_model fpe_model;

/* Loads a model file, .onnx or .ort; `threads` for one prediction, 0 for onnxruntime's choice. The
   graph is onnxruntime's to check: load only files that you trust. */
FPE_API fpe_status fpe_load(const char *path, int threads, fpe_model **model);

/* The same from memory, such as an asset of an app, which is needed no longer then; `name` stands for
   the file in messages. */
FPE_API fpe_status fpe_load_bytes(const void *data, size_t bytes, const char *name, int threads,
                                  fpe_model **model);
FPE_API void fpe_model_free(fpe_model *model);

/* The name that the file's metadata states. */
FPE_API const char *fpe_model_name(const fpe_model *model);

/* The size of the network's input for a picture. */
FPE_API fpe_status fpe_input_size(const fpe_model *model, int image_height, int image_width,
                                  int *height, int *width);

/* ---- Predictions ---- */

typedef struct fpe_prediction fpe_prediction;

typedef struct fpe_options {
    double threshold;       /* probability above which a pixel is ground */
    double camera_height_m; /* of the camera above the ground, if known; else NaN */
    double pitch_deg;       /* downward, from -90 to 90, if known; else NaN */
    double roll_deg;        /* about the optical axis, right side down, if known; else NaN */
    int flatten;            /* lay the ground's depth onto its plane where the ground is flat */
    int network_height;     /* of the network's input, multiples of 32; 0 for the usual size */
    int network_width;
} fpe_options;

/* 0.5; no known pose; flatten; the usual size. */
FPE_API fpe_options fpe_default_options(void);

/* Pitch and roll of a camera that knows the direction of gravity in camera axes, of any length; an
   accelerometer at rest measures the opposite direction. */
FPE_API fpe_status fpe_set_gravity(fpe_options *options, double x, double y, double z);

/* Finds the ground in a picture: 8-bit RGB, upright, height * width * 3 bytes. `camera` is in pixels of
   the picture; NULL assumes one, and all metres are proportional to its focal length. NULL for
   `options` are the default ones. */
FPE_API fpe_status fpe_predict(const fpe_model *model, const uint8_t *rgb, int height, int width,
                               const fpe_camera *camera, const fpe_options *options,
                               fpe_prediction **prediction);
FPE_API void fpe_prediction_free(fpe_prediction *prediction);

/* The size of all maps and masks: that of the network's input. */
FPE_API void fpe_map_size(const fpe_prediction *prediction, int *height, int *width);

/* The same prediction at another size, such as the picture's. Probabilities are interpolated before the
   threshold, depths as inverse depth. */
FPE_API fpe_status fpe_at_size(const fpe_prediction *prediction, int height, int width,
                               fpe_prediction **resized);

typedef enum fpe_map {
    FPE_VISIBLE_GROUND_PROBABILITY = 0, /* the surface seen here is walkable */
    FPE_GROUND_PROBABILITY = 1,         /* the ray meets walkable ground, seen or hidden */
    FPE_VISIBLE_DEPTH_M = 2,            /* metres along the optical axis to the surface seen */
    FPE_GROUND_DEPTH_M = 3,             /* metres along the optical axis to the ground, NaN off it */
    FPE_UNMASKED_GROUND_DEPTH_M = 4     /* the same everywhere, where ground would be */
} fpe_map;

/* height * width floats, row by row; NULL where the model file lacks the map. */
FPE_API const float *fpe_get_map(const fpe_prediction *prediction, fpe_map map);

typedef enum fpe_mask {
    FPE_VISIBLE_GROUND = 0, /* the surface seen here is walkable */
    FPE_GROUND = 1,         /* the ray meets walkable ground, seen or hidden */
    FPE_HIDDEN_GROUND = 2   /* there is ground, but something stands in front of it */
} fpe_mask;

/* height * width bytes, 0 or 1, row by row; NULL where the model file lacks the masks. */
FPE_API const uint8_t *fpe_get_mask(const fpe_prediction *prediction, fpe_mask mask);

/* The camera in pixels of the maps. */
FPE_API fpe_camera fpe_get_camera(const fpe_prediction *prediction);

typedef struct fpe_plane {
    double up[3];           /* the unit normal in camera axes */
    double camera_height_m; /* of the camera above the plane */
    double pitch_deg;       /* downward: 0 looks at the horizon, 90 straight down */
    double roll_deg;        /* right side down */
    double error_m;         /* median distance of the ground from the plane; 0 for a known pose */
} fpe_plane;

/* The plane of the ground. What is known of the pose holds, and the rest is fitted. */
FPE_API fpe_status fpe_ground_plane(const fpe_prediction *prediction, fpe_plane *plane);

/* Why there is no plane, in a word for programs: "no_ground", "few_pixels", "little_ground", "one_line",
   "not_flat", "above_camera" or "impossible_pose"; NULL if there is one, or the model lacks maps for it. */
FPE_API const char *fpe_no_ground_plane_reason(const fpe_prediction *prediction);

/* ---- Navigation ---- */

/* The default height of a robot, metres: it passes beneath higher things. */
#define FPE_ROBOT_HEIGHT_M 1.2

typedef struct fpe_grid fpe_grid;

enum { FPE_UNKNOWN = 0, FPE_OCCUPIED = 1, FPE_FREE = 2, FPE_HIDDEN = 3 }; /* values of cells */

/* The surroundings in bird's-eye view: square cells of `cell_m`, to `range_m` ahead and to each side. */
FPE_API fpe_status fpe_top_down(const fpe_prediction *prediction, double cell_m, double range_m,
                                double robot_height_m, fpe_grid **grid);
FPE_API void fpe_grid_free(fpe_grid *grid);
FPE_API void fpe_grid_size(const fpe_grid *grid, int *rows, int *columns);

/* rows * columns bytes, row by row, from far to near and from left to right. FPE_FREE is visible ground
   without an obstacle, FPE_HIDDEN ground behind something. */
FPE_API const uint8_t *fpe_grid_cells(const fpe_grid *grid);

/* The centre of a cell, metres. */
FPE_API void fpe_grid_place(const fpe_grid *grid, int row, int column, double *forward_m,
                            double *left_m);

/* Metres from the point below the camera to the first occupied cell at a bearing, degrees from straight
   ahead, left positive; infinite without one, NaN for a bearing that is not finite. */
FPE_API float fpe_grid_nearest_obstacle_m(const fpe_grid *grid, double bearing_deg);

/* The same for many bearings, without a grid, as a laser scanner reports it: to 50 m, infinite where no
   obstacle is seen, NaN out of view. */
FPE_API fpe_status fpe_scan(const fpe_prediction *prediction, const double *bearings_deg, size_t count,
                            double robot_height_m, float *ranges_m);

typedef struct fpe_path fpe_path;

typedef struct fpe_path_options {
    int in_metres;         /* start and goal are forward and left, not x and y in the picture */
    int visible_only;      /* stay on visible ground */
    double margin_m;       /* distance to keep from what is not ground, such as half a robot's width */
    double robot_height_m; /* as above */
} fpe_path_options;

/* Pixels; all ground; no margin; FPE_ROBOT_HEIGHT_M. */
FPE_API fpe_path_options fpe_default_path_options(void);

/* The cheapest path over the ground, on the cells of `fpe_top_down`. NULL for `options` are the default
   ones. */
FPE_API fpe_status fpe_plan(const fpe_prediction *prediction, const double start[2],
                            const double goal[2], const fpe_path_options *options, fpe_path **path);
FPE_API void fpe_path_free(fpe_path *path);

/* Points of the path, from start to goal. */
FPE_API size_t fpe_path_points(const fpe_path *path);

/* Two numbers a point: forward and left, metres; x and y in pixels of the picture. */
FPE_API const double *fpe_path_places_m(const fpe_path *path);
FPE_API const double *fpe_path_pixels(const fpe_path *path);

/* A byte a point, 0 or 1: the ground is hidden behind something here. */
FPE_API const uint8_t *fpe_path_hidden(const fpe_path *path);
FPE_API double fpe_path_length_m(const fpe_path *path);

/* The integral of 1.01 minus the ground's probability along the path, metres. */
FPE_API double fpe_path_cost(const fpe_path *path);

#ifdef __cplusplus
}
#endif

#endif
