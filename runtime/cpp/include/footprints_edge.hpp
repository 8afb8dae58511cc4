/* Walkable ground in a picture, seen and hidden, in metres: the C interface (footprints_edge.h, which
   says what everything means) with objects that free themselves, and exceptions instead of statuses.

       footprints_edge::Model model("edge.onnx");
       auto ground = model.predict(rgb, height, width);
       auto grid = ground.top_down();
*/
#ifndef FOOTPRINTS_EDGE_HPP
#define FOOTPRINTS_EDGE_HPP

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "footprints_edge.h"

namespace footprints_edge {

/* What a call that failed says, and its kind. */
class Error : public std::runtime_error {
  public:
    explicit Error(fpe_status kind) : std::runtime_error(fpe_last_error()), status(kind) {}
    fpe_status status;
};

inline void check(fpe_status status) {
    if (status != FPE_OK) throw Error(status);
}

using Camera = fpe_camera;
using Plane = fpe_plane;

/* Rows and columns of values, row by row; lives as long as the object it came from. Empty where the
   model file lacks it. */
template <typename Value>
struct View {
    const Value *values = nullptr;
    int rows = 0, columns = 0;
    const Value &at(int row, int column) const { return values[size_t(row) * columns + column]; }
    const Value *begin() const { return values; }
    const Value *end() const { return values ? values + size_t(rows) * columns : values; }
    bool empty() const { return !values; }
};

struct Point {
    double first, second; /* x and y in the picture, or forward and left in metres */
};

struct Free {
    void operator()(fpe_model *object) const { fpe_model_free(object); }
    void operator()(fpe_prediction *object) const { fpe_prediction_free(object); }
    void operator()(fpe_grid *object) const { fpe_grid_free(object); }
    void operator()(fpe_path *object) const { fpe_path_free(object); }
};

/* An occupancy grid in bird's-eye view. */
class Grid {
  public:
    explicit Grid(fpe_grid *grid) : grid_(grid) {}
    View<uint8_t> cells() const {
        View<uint8_t> view{fpe_grid_cells(grid_.get())};
        fpe_grid_size(grid_.get(), &view.rows, &view.columns);
        return view;
    }

    /* The centre of a cell: forward and left, metres. */
    Point place(int row, int column) const {
        Point place{};
        fpe_grid_place(grid_.get(), row, column, &place.first, &place.second);
        return place;
    }

    /* Metres to the first occupied cell at a bearing, degrees, left positive; infinite without one,
       NaN for a bearing that is not finite. */
    float nearest_obstacle_m(double bearing_deg) const {
        return fpe_grid_nearest_obstacle_m(grid_.get(), bearing_deg);
    }

  private:
    std::unique_ptr<fpe_grid, Free> grid_;
};

/* A path over the ground, from start to goal. */
struct Path {
    std::vector<Point> places_m, pixels;
    std::vector<bool> hidden;
    double length_m, cost;
};

/* Walkable ground in a picture. */
class Prediction {
  public:
    explicit Prediction(fpe_prediction *prediction) : prediction_(prediction) {}
    View<float> map(fpe_map which) const { return view(fpe_get_map(prediction_.get(), which)); }
    View<uint8_t> mask(fpe_mask which) const { return view(fpe_get_mask(prediction_.get(), which)); }
    Camera camera() const { return fpe_get_camera(prediction_.get()); }

    Plane ground_plane() const {
        Plane plane{};
        check(fpe_ground_plane(prediction_.get(), &plane));
        return plane;
    }

    /* Why there is none, in a word; empty if there is one, or the model lacks maps for it. */
    std::string no_ground_plane_reason() const {
        const char *word = fpe_no_ground_plane_reason(prediction_.get());
        return word ? word : "";
    }

    Prediction at_size(int height, int width) const {
        fpe_prediction *resized = nullptr;
        check(fpe_at_size(prediction_.get(), height, width, &resized));
        return Prediction(resized);
    }

    Grid top_down(double cell_m = 0.05, double range_m = 10,
                  double robot_height_m = FPE_ROBOT_HEIGHT_M) const {
        fpe_grid *grid = nullptr;
        check(fpe_top_down(prediction_.get(), cell_m, range_m, robot_height_m, &grid));
        return Grid(grid);
    }

    std::vector<float> scan(const std::vector<double> &bearings_deg,
                            double robot_height_m = FPE_ROBOT_HEIGHT_M) const {
        std::vector<float> ranges_m(bearings_deg.size());
        if (!ranges_m.empty())
            check(fpe_scan(prediction_.get(), bearings_deg.data(), bearings_deg.size(),
                           robot_height_m, ranges_m.data()));
        return ranges_m;
    }

    Path plan(Point start, Point goal,
              const fpe_path_options &options = fpe_default_path_options()) const {
        const double from[] = {start.first, start.second}, to[] = {goal.first, goal.second};
        fpe_path *made = nullptr;
        check(fpe_plan(prediction_.get(), from, to, &options, &made));
        const std::unique_ptr<fpe_path, Free> path(made);
        Path result{{}, {}, {}, fpe_path_length_m(made), fpe_path_cost(made)};
        for (size_t i = 0; i < fpe_path_points(made); i++) {
            const double *place = fpe_path_places_m(made) + 2 * i, *pixel = fpe_path_pixels(made) + 2 * i;
            result.places_m.push_back({place[0], place[1]});
            result.pixels.push_back({pixel[0], pixel[1]});
            result.hidden.push_back(fpe_path_hidden(made)[i] != 0);
        }
        return result;
    }

  private:
    template <typename Value>
    View<Value> view(const Value *values) const {
        View<Value> result{values};
        fpe_map_size(prediction_.get(), &result.rows, &result.columns);
        return result;
    }

    std::unique_ptr<fpe_prediction, Free> prediction_;
};

/* A loaded model; many threads may share it. */
class Model {
  public:
    explicit Model(const std::string &path, int threads = 0) {
        fpe_model *model = nullptr;
        check(fpe_load(path.c_str(), threads, &model));
        model_.reset(model);
    }

    Model(const void *data, size_t bytes, const std::string &name, int threads = 0) {
        fpe_model *model = nullptr;
        check(fpe_load_bytes(data, bytes, name.c_str(), threads, &model));
        model_.reset(model);
    }

    std::string name() const { return fpe_model_name(model_.get()); }

    /* `rgb` is height * width * 3 bytes, upright; no camera assumes one. */
    Prediction predict(const uint8_t *rgb, int height, int width,
                       const std::optional<Camera> &camera = std::nullopt,
                       const fpe_options &options = fpe_default_options()) const {
        fpe_prediction *prediction = nullptr;
        check(fpe_predict(model_.get(), rgb, height, width, camera ? &*camera : nullptr, &options,
                          &prediction));
        return Prediction(prediction);
    }

  private:
    std::unique_ptr<fpe_model, Free> model_;
};

}  // namespace footprints_edge

#endif
