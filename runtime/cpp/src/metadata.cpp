#include "metadata.hpp"

#include <locale>
#include <sstream>

#include "errors.hpp"

namespace footprints_edge {
namespace {

const char *const CONVERT = "fp-export convert CHECKPOINT -o OUT.onnx --arch edge";
constexpr size_t MOST_TEXT = 1000; /* longest value of a key */

/* Reads numbers with a point, whatever the language of the program. */
bool read_numbers(const std::string &text, double *first, double *second) {
    std::istringstream stream(text);
    stream.imbue(std::locale::classic());
    char comma = ',';
    if (!(stream >> *first)) return false;
    if (second && !(stream >> comma >> *second)) return false;
    return comma == ',' && stream.peek() == std::istringstream::traits_type::eof();
}

}  // namespace

Metadata read_metadata(const std::function<std::string(const char *)> &value_of,
                       const std::string &file) {
    const auto fact = [&](const char *key) {
        const std::string value = value_of(key);
        if (value.empty())
            throw Failure(FPE_BAD_MODEL,
                          text("%s is no model of footprints-edge: it lacks the metadata %s; convert "
                               "one with: %s",
                               file.c_str(), key, CONVERT));
        if (value.size() > MOST_TEXT)
            throw Failure(FPE_BAD_MODEL,
                          text("%s: %s has %zu characters; expected at most %zu; convert the model "
                               "again with: %s",
                               file.c_str(), key, value.size(), MOST_TEXT, CONVERT));
        return value;
    };
    const auto refuse = [&](const char *key, const std::string &value, const char *expected) {
        throw Failure(FPE_BAD_MODEL,
                      text("%s: %s is '%.40s', expected %s; convert the model again with: %s",
                           file.c_str(), key, value.c_str(), expected, CONVERT));
    };
    Metadata found{};
    const std::string format = fact("footprints.format");
    if (format != "1") refuse("footprints.format", format, "1, which this version reads");
    found.name = fact("footprints.name");
    const std::string range = fact("footprints.depth_range_m");
    if (!(read_numbers(range, &found.nearest_m, &found.farthest_m) && found.nearest_m >= 1e-3 &&
          found.nearest_m < found.farthest_m && found.farthest_m <= 1e6))
        refuse("footprints.depth_range_m", range, "metres as 'nearest,farthest' such as '0.1,100'");
    const std::string camera = fact("footprints.camera"), prefix = "focal_px=";
    if (camera != "none" &&
        !(camera.compare(0, prefix.size(), prefix) == 0 &&
          read_numbers(camera.substr(prefix.size()), &found.focal_px, nullptr) &&
          found.focal_px >= 1 && found.focal_px <= 1e6))
        refuse("footprints.camera", camera, "'none' or a value such as 'focal_px=400'");
    const std::string filter = fact("footprints.resize");
    if (filter == "lanczos")
        found.filter = Filter::lanczos;
    else if (filter == "hamming")
        found.filter = Filter::hamming;
    else if (filter == "bilinear")
        found.filter = Filter::bilinear;
    else
        refuse("footprints.resize", filter, "lanczos, hamming or bilinear, which this version has");
    const std::string outputs = value_of("footprints.outputs"); /* only files that lack maps have it */
    found.has_masks = outputs.empty() || outputs == "all" || outputs == "masks";
    found.has_depths = outputs.empty() || outputs == "all" || outputs == "depths";
    if (!found.has_masks && !found.has_depths)
        refuse("footprints.outputs", outputs, "all, masks or depths");
    return found;
}

}  // namespace footprints_edge
