#include <cmath>
#include <exception>
#include <new>
#include <string>

#include "camera.hpp"
#include "decode.hpp"
#include "errors.hpp"
#include "footprints_edge.h"
#include "network.hpp"
#include "obstacles.hpp"
#include "occupancy_grid.hpp"
#include "path_planning.hpp"
#include "prediction.hpp"

namespace fpe = footprints_edge;

struct fpe_model {
    fpe::Network network;
};

struct fpe_prediction {
    fpe::Prediction value;
};

struct fpe_grid {
    fpe::OccupancyGrid value;
};

struct fpe_path {
    fpe::GroundPath value;
};

namespace {

constexpr int MOST_SIDE_PX = 1 << 17;
constexpr double MOST_PX = 178e6;

thread_local std::string last_error;

fpe_status refuse(fpe_status status, const char *message) noexcept {
    try {
        last_error = message;
    } catch (...) {
        last_error.clear();
    }
    return status;
}

/* Runs a function's body; what it throws becomes a status and a message. */
template <typename Body>
fpe_status guarded(Body body) noexcept {
    try {
        body();
        return FPE_OK;
    } catch (const fpe::Failure &failure) {
        return refuse(failure.status, failure.what());
    } catch (const std::bad_alloc &) {
        return refuse(FPE_FAILED, "there is no memory for this");
    } catch (const std::exception &error) {
        return refuse(FPE_FAILED, error.what());
    } catch (...) {
        return refuse(FPE_FAILED, "an unknown error");
    }
}

void require(const void *pointer, const char *name) {
    if (!pointer) throw fpe::Failure(FPE_BAD_ARGUMENT, std::string(name) + " is a null pointer");
}

fpe::Size checked_image(int height, int width) {
    if (height < 1 || width < 1 || height > MOST_SIDE_PX || width > MOST_SIDE_PX ||
        double(height) * width > MOST_PX)
        throw fpe::Failure(FPE_BAD_ARGUMENT,
                           fpe::text("the picture is %d x %d pixels; give sides from 1 to %d, and at "
                                     "most %.0f million pixels",
                                     height, width, MOST_SIDE_PX, MOST_PX / 1e6));
    return {height, width};
}

}  // namespace

const char *fpe_last_error(void) { return last_error.c_str(); }

const char *fpe_version(void) { return FPE_VERSION; }

fpe_camera fpe_camera_from_hfov(double hfov_deg, int height, int width) {
    const bool possible = hfov_deg > 1e-6 && hfov_deg < 180 - 1e-6;
    return fpe::camera_of_focal(possible ? width / 2.0 / std::tan(fpe::radians(hfov_deg) / 2) : NAN,
                                {height, width});
}

fpe_camera fpe_camera_from_focal_35mm(double focal_mm, int height, int width) {
    return fpe::camera_of_focal(focal_mm * std::hypot(height, width) / std::hypot(36.0, 24.0),
                                {height, width});
}

fpe_camera fpe_camera_assumed(int height, int width) {
    const double longer = height > width ? height : width;
    return fpe::camera_of_focal(longer / 2 / std::tan(fpe::radians(60) / 2), {height, width});
}

fpe_status fpe_load(const char *path, int threads, fpe_model **model) {
    return guarded([&] {
        require(path, "path");
        require(model, "model");
        const std::vector<uint8_t> data = fpe::read_file(path);
        *model = new fpe_model{{data.data(), data.size(), path, threads}};
    });
}

fpe_status fpe_load_bytes(const void *data, size_t bytes, const char *name, int threads,
                          fpe_model **model) {
    return guarded([&] {
        require(data, "data");
        require(name, "name");
        require(model, "model");
        *model = new fpe_model{{data, bytes, name, threads}};
    });
}

void fpe_model_free(fpe_model *model) { delete model; }

const char *fpe_model_name(const fpe_model *model) {
    return model->network.metadata().name.c_str();
}

fpe_status fpe_input_size(const fpe_model *model, int image_height, int image_width, int *height,
                          int *width) {
    return guarded([&] {
        require(model, "model");
        require(height, "height");
        require(width, "width");
        const fpe::Size size = model->network.input_size(checked_image(image_height, image_width));
        *height = size.height;
        *width = size.width;
    });
}

fpe_options fpe_default_options(void) { return {0.5, NAN, NAN, NAN, 1, 0, 0}; }

fpe_status fpe_set_gravity(fpe_options *options, double x, double y, double z) {
    return guarded([&] {
        require(options, "options");
        const double length = std::hypot(x, y, z);
        if (!(std::isfinite(length) && length > 0))
            throw fpe::Failure(FPE_BAD_ARGUMENT,
                               fpe::text("gravity is (%g, %g, %g); give its direction in camera axes: "
                                         "x right, y down, z forward",
                                         x, y, z));
        options->pitch_deg = fpe::degrees(std::asin(std::fmax(-1, std::fmin(1, z / length))));
        options->roll_deg = fpe::degrees(std::atan2(x, y));
    });
}

fpe_status fpe_predict(const fpe_model *model, const uint8_t *rgb, int height, int width,
                       const fpe_camera *camera, const fpe_options *options,
                       fpe_prediction **prediction) {
    return guarded([&] {
        require(model, "model");
        require(rgb, "rgb");
        require(prediction, "prediction");
        const fpe::Size image = checked_image(height, width);
        const fpe_options chosen = options ? *options : fpe_default_options();
        if (!(chosen.threshold >= 0 && chosen.threshold <= 1))
            throw fpe::Failure(FPE_BAD_ARGUMENT,
                               fpe::text("the threshold is %g; it is a probability: give 0 to 1",
                                         chosen.threshold));
        const fpe::Pose pose{chosen.camera_height_m, chosen.pitch_deg, chosen.roll_deg};
        fpe::check_pose(pose);
        const fpe::Camera of_image = camera ? *camera : fpe_camera_assumed(height, width);
        fpe::check_camera(of_image);
        const bool is_usual = !chosen.network_height && !chosen.network_width;
        const fpe::Size size = is_usual ? model->network.input_size(image)
                                        : fpe::Size{chosen.network_height, chosen.network_width};
        model->network.check_input_size(size);
        const fpe::Metadata &metadata = model->network.metadata();
        const std::vector<float> output =
            model->network.run(fpe::resize_rgb(rgb, image, size, metadata.filter), size);
        const fpe::Camera of_maps = fpe::scaled(of_image, image, size);
        *prediction = new fpe_prediction{
            fpe::make_prediction(fpe::decode(output, size, metadata, of_maps), of_maps, image,
                                 chosen.threshold, pose, chosen.flatten != 0)};
    });
}

void fpe_prediction_free(fpe_prediction *prediction) { delete prediction; }

void fpe_map_size(const fpe_prediction *prediction, int *height, int *width) {
    *height = prediction->value.maps.size.height;
    *width = prediction->value.maps.size.width;
}

fpe_status fpe_at_size(const fpe_prediction *prediction, int height, int width,
                       fpe_prediction **resized) {
    return guarded([&] {
        require(prediction, "prediction");
        require(resized, "resized");
        *resized =
            new fpe_prediction{fpe::at_size(prediction->value, checked_image(height, width))};
    });
}

const float *fpe_get_map(const fpe_prediction *prediction, fpe_map map) {
    const fpe::Prediction &value = prediction->value;
    const std::vector<float> *found = nullptr;
    switch (map) {
        case FPE_VISIBLE_GROUND_PROBABILITY: found = &value.maps.visible_probability; break;
        case FPE_GROUND_PROBABILITY: found = &value.maps.ground_probability; break;
        case FPE_VISIBLE_DEPTH_M: found = &value.maps.visible_depth_m; break;
        case FPE_GROUND_DEPTH_M: found = &value.ground_depth_m; break;
        case FPE_UNMASKED_GROUND_DEPTH_M: found = &value.maps.unmasked_ground_depth_m; break;
    }
    return found && !found->empty() ? found->data() : nullptr;
}

const uint8_t *fpe_get_mask(const fpe_prediction *prediction, fpe_mask mask) {
    const fpe::Masks &masks = prediction->value.masks;
    const std::vector<uint8_t> *found = nullptr;
    switch (mask) {
        case FPE_VISIBLE_GROUND: found = &masks.visible; break;
        case FPE_GROUND: found = &masks.ground; break;
        case FPE_HIDDEN_GROUND: found = &masks.hidden; break;
    }
    return found && !found->empty() ? found->data() : nullptr;
}

fpe_camera fpe_get_camera(const fpe_prediction *prediction) { return prediction->value.camera; }

fpe_status fpe_ground_plane(const fpe_prediction *prediction, fpe_plane *plane) {
    return guarded([&] {
        require(prediction, "prediction");
        require(plane, "plane");
        const fpe::GroundPlane &found = fpe::ground_plane(prediction->value);
        *plane = {{found.up[0], found.up[1], found.up[2]},
                  found.camera_height_m,
                  found.pitch_deg(),
                  found.roll_deg(),
                  found.error_m};
    });
}

const char *fpe_no_ground_plane_reason(const fpe_prediction *prediction) {
    const fpe::NoGroundPlane *why = prediction->value.no_plane.get();
    return why ? why->reason : nullptr;
}

fpe_status fpe_top_down(const fpe_prediction *prediction, double cell_m, double range_m,
                        double robot_height_m, fpe_grid **grid) {
    return guarded([&] {
        require(prediction, "prediction");
        require(grid, "grid");
        fpe::check_grid(cell_m, range_m);
        *grid = new fpe_grid{fpe::make_grid(prediction->value,
                                            fpe::Obstacles(prediction->value, robot_height_m), cell_m,
                                            range_m)};
    });
}

void fpe_grid_free(fpe_grid *grid) { delete grid; }

void fpe_grid_size(const fpe_grid *grid, int *rows, int *columns) {
    *rows = grid->value.rows;
    *columns = grid->value.columns();
}

const uint8_t *fpe_grid_cells(const fpe_grid *grid) { return grid->value.cells.data(); }

void fpe_grid_place(const fpe_grid *grid, int row, int column, double *forward_m, double *left_m) {
    const fpe::Place place = fpe::centre_of(row, column, grid->value.rows, grid->value.cell_m);
    *forward_m = place.forward;
    *left_m = place.left;
}

float fpe_grid_nearest_obstacle_m(const fpe_grid *grid, double bearing_deg) {
    return fpe::nearest_obstacle_m(grid->value, bearing_deg);
}

fpe_status fpe_scan(const fpe_prediction *prediction, const double *bearings_deg, size_t count,
                    double robot_height_m, float *ranges_m) {
    return guarded([&] {
        require(prediction, "prediction");
        require(bearings_deg, "bearings_deg");
        require(ranges_m, "ranges_m");
        const fpe::Obstacles obstacles(prediction->value, robot_height_m);
        for (size_t i = 0; i < count; i++) ranges_m[i] = obstacles.nearest_m(bearings_deg[i]);
    });
}

fpe_path_options fpe_default_path_options(void) { return {0, 0, 0, FPE_ROBOT_HEIGHT_M}; }

fpe_status fpe_plan(const fpe_prediction *prediction, const double start[2], const double goal[2],
                    const fpe_path_options *options, fpe_path **path) {
    return guarded([&] {
        require(prediction, "prediction");
        require(start, "start");
        require(goal, "goal");
        require(path, "path");
        *path = new fpe_path{fpe::find_path(prediction->value, start, goal,
                                            options ? *options : fpe_default_path_options())};
    });
}

void fpe_path_free(fpe_path *path) { delete path; }

size_t fpe_path_points(const fpe_path *path) { return path->value.hidden.size(); }

const double *fpe_path_places_m(const fpe_path *path) { return path->value.places_m.data(); }

const double *fpe_path_pixels(const fpe_path *path) { return path->value.pixels.data(); }

const uint8_t *fpe_path_hidden(const fpe_path *path) { return path->value.hidden.data(); }

double fpe_path_length_m(const fpe_path *path) { return path->value.length_m; }

double fpe_path_cost(const fpe_path *path) { return path->value.cost; }
