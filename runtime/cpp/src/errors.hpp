/* What can go wrong, on its way to the C interface, which no exception leaves. */
#pragma once

#include <cstdio>
#include <stdexcept>
#include <string>

#include "footprints_edge.h"

namespace footprints_edge {

struct Failure : std::runtime_error {
    Failure(fpe_status why, const std::string &message)
        : std::runtime_error(message), status(why) {}
    fpe_status status;
};

/* There is no ground plane; `reason` is a word of docs/porting-metres.md. */
struct NoGroundPlane : Failure {
    NoGroundPlane(const char *word, const std::string &message)
        : Failure(FPE_NO_GROUND_PLANE, message), reason(word) {}
    const char *reason;
};

/* A message by the rules of printf. */
template <typename... Values>
std::string text(const char *format, Values... values) {
    const int length = std::snprintf(nullptr, 0, format, values...);
    std::string result(length < 0 ? 0 : static_cast<size_t>(length), '\0');
    std::snprintf(result.data(), result.size() + 1, format, values...);
    return result;
}

}  // namespace footprints_edge
