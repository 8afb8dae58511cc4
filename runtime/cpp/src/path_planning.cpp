#include "path_planning.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <string>

#include "errors.hpp"
#include "obstacles.hpp"
#include "occupancy_grid.hpp"

namespace footprints_edge {
namespace {

constexpr float STEP_COST = 0.01f; /* where probabilities round to 1, the shortest path wins */
constexpr double CELL_M = 0.05;
constexpr int CELLS_AHEAD = 400; /* larger cells where the ends are farther away */
constexpr double FARTHEST_M = 100;
constexpr double DETOUR = 1.25, DETOUR_M = 2; /* the grid reaches beyond the farther end */

struct Cell {
    int row, column;
};

double distance(Place a, Place b) { return std::hypot(b.forward - a.forward, b.left - a.left); }

Place between(Place a, Place b, double share) {
    return {a.forward + share * (b.forward - a.forward), a.left + share * (b.left - a.left)};
}

/* A start or goal: in view, and on ground. */
struct End {
    std::string where; /* for messages */
    Place place;
    size_t pixel;
};

End end_of(const Prediction &prediction, const PlaneMap &plane, const Obstacles &obstacles,
           const double given[2], const fpe_path_options &options, const char *name) {
    const Size maps = prediction.maps.size, image = prediction.image;
    End end{text("the %s (%g, %g) %s", name, given[0], given[1], options.in_metres ? "m" : "px"),
            {given[0], given[1]},
            0};
    if (!std::isfinite(given[0]) || !std::isfinite(given[1]))
        throw Failure(FPE_BAD_ARGUMENT, end.where + " is no point; give two finite numbers");
    const Pixel at = options.in_metres
                         ? plane.to_pixel(end.place)
                         : Pixel{(given[0] + 0.5) * maps.width / image.width - 0.5,
                                 (given[1] + 0.5) * maps.height / image.height - 0.5};
    if (!(at.x >= -0.5 && at.x < maps.width - 0.5 && at.y >= -0.5 && at.y < maps.height - 0.5))
        throw Failure(FPE_OUTSIDE, text("%s is outside the picture of %d x %d px; choose a point in "
                                        "view",
                                        end.where.c_str(), image.width, image.height));
    end.pixel = size_t(std::floor(at.y + 0.5)) * maps.width + size_t(std::floor(at.x + 0.5));
    const bool visible = options.visible_only;
    if (!(visible ? prediction.masks.visible : prediction.masks.ground)[end.pixel])
        throw Failure(FPE_OFF_GROUND,
                      text("%s is not on %sground (probability %.2f, threshold %g); choose another "
                           "point",
                           end.where.c_str(), visible ? "visible " : "",
                           double((visible ? prediction.maps.visible_probability
                                           : prediction.maps.ground_probability)[end.pixel]),
                           prediction.threshold));
    if (obstacles.raised()[end.pixel])
        throw Failure(FPE_OFF_GROUND,
                      end.where + " is not on ground: what is seen there lies too high above the "
                                  "ground plane, such as a table top; choose another point");
    if (!options.in_metres) end.place = plane.at_pixel(at);
    if (!(std::hypot(end.place.forward, end.place.left) <= FARTHEST_M))
        throw Failure(FPE_OFF_GROUND,
                      text("%s is at the horizon of the ground plane, or more than %g m away; choose "
                           "a nearer point",
                           end.where.c_str(), FARTHEST_M));
    return end;
}

/* A grid with the cost of a metre in each cell, negative where no path may go. */
struct Terrain {
    OccupancyGrid grid;
    std::vector<double> cost;

    size_t index(Cell cell) const { return size_t(cell.row) * grid.columns() + cell.column; }

    Cell cell_of(Place place) const {
        const double row = std::floor(grid.rows - place.forward / grid.cell_m);
        const double column = std::floor(grid.rows - place.left / grid.cell_m);
        return {int(std::clamp(row, 0.0, grid.rows - 1.0)),
                int(std::clamp(column, 0.0, grid.columns() - 1.0))};
    }
};

/* Distances along one line, squared: the least of (i - j)^2 + values[j]. */
void lower_envelope(std::vector<double> &values) {
    const int count = int(values.size());
    std::vector<int> places(count);
    std::vector<double> starts(count);
    int last = -1;
    for (int j = 0; j < count; j++) {
        if (std::isinf(values[j])) continue;
        double start = -INFINITY;
        while (last >= 0) { /* where the new parabola falls below the last one */
            const double i = places[last];
            start = (values[j] + double(j) * j - values[places[last]] - i * i) / (2 * (j - i));
            if (start > starts[last]) break;
            last--;
        }
        last++;
        places[last] = j;
        starts[last] = last ? start : -INFINITY;
    }
    if (last < 0) return;
    std::vector<double> result(count);
    for (int i = 0, which = 0; i < count; i++) {
        while (which < last && starts[which + 1] <= i) which++;
        const double away = i - places[which];
        result[i] = away * away + values[places[which]];
    }
    values = result;
}

/* The distance of every cell to the nearest closed one, in cells. */
std::vector<double> distances(const std::vector<uint8_t> &closed, int rows, int columns) {
    std::vector<double> squares(closed.size()), line(rows);
    for (int column = 0; column < columns; column++) {
        for (int row = 0; row < rows; row++)
            line[row] = closed[size_t(row) * columns + column] ? 0 : INFINITY;
        lower_envelope(line);
        for (int row = 0; row < rows; row++) squares[size_t(row) * columns + column] = line[row];
    }
    line.resize(columns);
    for (int row = 0; row < rows; row++) {
        const auto begin = squares.begin() + std::ptrdiff_t(row) * columns;
        std::copy(begin, begin + columns, line.begin());
        lower_envelope(line);
        std::copy(line.begin(), line.end(), begin);
    }
    for (double &value : squares) value = std::sqrt(value);
    return squares;
}

/* The cheapest route from cell to cell, to all eight neighbours; empty if there is none. A diagonal
   step touches two more cells, at their corners; both must be open. */
std::vector<Cell> cheapest_route(const Terrain &terrain, Cell start, Cell goal) {
    const int rows = terrain.grid.rows, columns = terrain.grid.columns();
    std::vector<double> total(terrain.cost.size(), std::numeric_limits<double>::infinity());
    std::vector<int> before(terrain.cost.size(), -1);
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open;
    const int from = int(terrain.index(start)), to = int(terrain.index(goal));
    total[from] = 0;
    open.push({0, from});
    while (!open.empty()) {
        const auto [so_far, here] = open.top();
        open.pop();
        if (here == to) break;
        if (so_far > total[here]) continue;
        const int row = here / columns, column = here % columns;
        for (int down = -1; down <= 1; down++)
            for (int right = -1; right <= 1; right++) {
                const int r = row + down, c = column + right;
                if ((!down && !right) || r < 0 || r >= rows || c < 0 || c >= columns) continue;
                const int there = r * columns + c;
                if (terrain.cost[there] < 0 || terrain.cost[row * columns + c] < 0 ||
                    terrain.cost[r * columns + column] < 0)
                    continue;
                const double step = down && right ? std::sqrt(2.0) : 1;
                const double sum = so_far + step * (terrain.cost[here] + terrain.cost[there]) / 2;
                if (sum < total[there]) {
                    total[there] = sum;
                    before[there] = here;
                    open.push({sum, there});
                }
            }
    }
    std::vector<Cell> route;
    if (std::isinf(total[to])) return route;
    for (int here = to; here >= 0; here = before[here])
        route.push_back({here / columns, here % columns});
    std::reverse(route.begin(), route.end());
    return route;
}

/* Points along straight lines between corners, at most a step apart. */
std::vector<Place> dense(const std::vector<Place> &corners, double step_m) {
    std::vector<Place> points{corners[0]};
    for (size_t i = 1; i < corners.size(); i++) {
        const int count =
            std::max(1, int(std::ceil(distance(corners[i - 1], corners[i]) / step_m)));
        for (int k = 1; k <= count; k++)
            points.push_back(between(corners[i - 1], corners[i], double(k) / count));
    }
    return points;
}

/* The cost of straight lines between corners; infinite if one leaves or touches what is closed. A line
   is followed in steps, which may cut a cell's corner or meet it exactly. So the cells beside a
   diagonal passage, within three steps, must be open as well. */
double line_cost(const std::vector<Place> &corners, const Terrain &terrain) {
    double total = 0;
    for (size_t i = 1; i < corners.size(); i++) {
        const std::vector<Place> points =
            dense({corners[i - 1], corners[i]}, terrain.grid.cell_m / 4);
        std::vector<Cell> at;
        for (size_t k = 1; k < points.size(); k++)
            at.push_back(terrain.cell_of(between(points[k - 1], points[k], 0.5)));
        for (size_t k = 0; k < at.size(); k++) {
            const Cell cell = at[k], later = at[std::min(k + 2, at.size() - 1)];
            const double cost = terrain.cost[terrain.index(cell)];
            if (cost < 0 || terrain.cost[terrain.index({cell.row, later.column})] < 0 ||
                terrain.cost[terrain.index({later.row, cell.column})] < 0)
                return INFINITY;
            total += cost * distance(points[k], points[k + 1]);
        }
    }
    return total;
}

/* Replaces steps from cell to cell by straight lines, where these are open and no dearer. */
std::vector<Place> shortened(const std::vector<Place> &corners, const Terrain &terrain) {
    std::vector<double> steps;
    for (size_t i = 1; i < corners.size(); i++)
        steps.push_back(line_cost({corners[i - 1], corners[i]}, terrain));
    std::vector<Place> kept{corners[0]};
    for (size_t begin = 0; begin + 1 < corners.size();) {
        size_t end = begin + 1;
        double detour = steps[begin];
        while (end + 1 < corners.size()) {
            const double longer = detour + steps[end];
            if (!(line_cost({corners[begin], corners[end + 1]}, terrain) <= longer * (1 + 1e-6)))
                break;
            end++;
            detour = longer;
        }
        kept.push_back(corners[end]);
        begin = end;
    }
    return kept;
}

}  // namespace

GroundPath find_path(const Prediction &prediction, const double start[2], const double goal[2],
                     const fpe_path_options &options) {
    const double margin_m = options.margin_m;
    if (!(std::isfinite(margin_m) && margin_m >= 0))
        throw Failure(FPE_BAD_ARGUMENT, text("the margin is %g; give metres, 0 or more", margin_m));
    const PlaneMap plane(ground_plane(prediction), prediction.camera);
    const Obstacles obstacles(prediction, options.robot_height_m);
    const End ends[] = {end_of(prediction, plane, obstacles, start, options, "start"),
                        end_of(prediction, plane, obstacles, goal, options, "goal")};
    double farther_m = 0;
    for (const End &end : ends)
        farther_m = std::max(farther_m, std::hypot(end.place.forward, end.place.left));
    const double reach_m = DETOUR * farther_m + DETOUR_M;
    const double cell_m = std::max(CELL_M, reach_m / CELLS_AHEAD);

    Terrain terrain{make_grid(prediction, obstacles, cell_m, reach_m), {}};
    OccupancyGrid &grid = terrain.grid;
    Cell cells[2];
    for (int i = 0; i < 2; i++) {
        cells[i] = terrain.cell_of(ends[i].place);
        uint8_t &value = grid.cells[terrain.index(cells[i])];
        if (value == FPE_UNKNOWN) /* its centre is not in view, or beyond the ground's edge */
            value = prediction.masks.visible[ends[i].pixel] ? FPE_FREE : FPE_HIDDEN;
    }
    const auto is_open = [&](size_t cell) {
        return options.visible_only ? grid.cells[cell] == FPE_FREE : grid.cells[cell] >= FPE_FREE;
    };
    const std::vector<float> &probability = options.visible_only
                                                ? prediction.maps.visible_probability
                                                : prediction.maps.ground_probability;
    const Size maps = prediction.maps.size;
    std::vector<uint8_t> closed(grid.cells.size());
    for (int row = 0; row < grid.rows; row++)
        for (int column = 0; column < grid.columns(); column++) {
            const size_t cell = terrain.index({row, column});
            const Pixel at = plane.to_pixel(centre_of(row, column, grid.rows, cell_m));
            const double x = std::floor(at.x + 0.5), y = std::floor(at.y + 0.5);
            const bool in_view = x >= 0 && x < maps.width && y >= 0 && y < maps.height;
            terrain.cost.push_back(
                in_view ? 1 - probability[size_t(y) * maps.width + size_t(x)] + STEP_COST : 1);
            /* the picture's border is no obstacle */
            closed[cell] = (in_view && !is_open(cell)) || grid.cells[cell] == FPE_OCCUPIED;
            if (!is_open(cell)) terrain.cost[cell] = -1;
        }
    if (margin_m > 0) {
        const std::vector<double> away = distances(closed, grid.rows, grid.columns());
        for (size_t cell = 0; cell < away.size(); cell++) /* one may reach beyond its cell's centre */
            if (!((away[cell] - 1) * cell_m >= margin_m)) terrain.cost[cell] = -1;
    }
    for (int i = 0; i < 2; i++) {
        const size_t cell = terrain.index(cells[i]);
        if (!is_open(cell))
            throw Failure(FPE_OFF_GROUND, ends[i].where + " is " +
                                              (grid.cells[cell] == FPE_OCCUPIED
                                                   ? "where an obstacle stands"
                                                   : "not on visible ground") +
                                              "; choose another point");
        if (terrain.cost[cell] < 0)
            throw Failure(FPE_OFF_GROUND,
                          text("%s is closer than the margin of %g m to an obstacle; choose another "
                               "point, or a smaller margin",
                               ends[i].where.c_str(), margin_m));
    }
    const std::vector<Cell> route = cheapest_route(terrain, cells[0], cells[1]);
    if (route.empty())
        throw Failure(FPE_NO_PATH,
                      text("no path on %sground connects %s and %s with a margin of %g m; try a "
                           "smaller margin, a lower threshold, or other points",
                           options.visible_only ? "visible " : "", ends[0].where.c_str() + 4,
                           ends[1].where.c_str() + 4, margin_m));
    // An end's line to the next cell may cut the corner of a closed one; to its own cell it cannot.
    std::vector<Place> corners{ends[0].place};
    for (const Cell &cell : route)
        corners.push_back(centre_of(cell.row, cell.column, grid.rows, cell_m));
    corners.push_back(ends[1].place);

    corners = shortened(corners, terrain);
    const std::vector<Place> points = dense(corners, cell_m);
    GroundPath path{{}, {}, {}, line_cost(corners, terrain), 0};
    const Size image = prediction.image;
    for (size_t i = 0; i < points.size(); i++) {
        const Pixel at = plane.to_pixel(points[i]);
        path.places_m.insert(path.places_m.end(), {points[i].forward, points[i].left});
        path.pixels.insert(path.pixels.end(), {(at.x + 0.5) * image.width / maps.width - 0.5,
                                               (at.y + 0.5) * image.height / maps.height - 0.5});
        path.hidden.push_back(grid.cells[terrain.index(terrain.cell_of(points[i]))] == FPE_HIDDEN);
        if (i) path.length_m += distance(points[i - 1], points[i]);
    }
    return path;
}

}  // namespace footprints_edge
