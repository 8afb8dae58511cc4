# Makes the target onnxruntime::onnxruntime. In this order: one that is there already, as in a project
# that adds onnxruntime itself; the variables ONNXRUNTIME_INCLUDE_DIR and ONNXRUNTIME_LIBRARY, or
# ONNXRUNTIME_ROOT, a folder with include/ and lib/, such as an unpacked release; find_package.
if(TARGET onnxruntime::onnxruntime)
  return()
endif()
set(ONNXRUNTIME_ROOT "" CACHE PATH "Folder with include/ and lib/ of onnxruntime")
if(NOT ONNXRUNTIME_ROOT AND NOT ONNXRUNTIME_LIBRARY)
  find_package(onnxruntime CONFIG QUIET)
endif()
if(NOT TARGET onnxruntime::onnxruntime)
  if(NOT ONNXRUNTIME_INCLUDE_DIR)
    find_path(ONNXRUNTIME_INCLUDE_DIR onnxruntime_c_api.h
      HINTS "${ONNXRUNTIME_ROOT}/include"
      PATH_SUFFIXES onnxruntime onnxruntime/core/session)
  endif()
  if(NOT ONNXRUNTIME_LIBRARY)
    find_library(ONNXRUNTIME_LIBRARY NAMES onnxruntime libonnxruntime.so.1
      HINTS "${ONNXRUNTIME_ROOT}/lib" "${ONNXRUNTIME_ROOT}/lib64")
  endif()
  if(NOT ONNXRUNTIME_INCLUDE_DIR OR NOT ONNXRUNTIME_LIBRARY)
    message(FATAL_ERROR
      "onnxruntime is not found: header '${ONNXRUNTIME_INCLUDE_DIR}', library "
      "'${ONNXRUNTIME_LIBRARY}'. Install it (Debian 13 and later: libonnxruntime-dev), or unpack one of "
      "its releases and give -DONNXRUNTIME_ROOT=FOLDER.")
  endif()
  add_library(onnxruntime::onnxruntime UNKNOWN IMPORTED)
  set_target_properties(onnxruntime::onnxruntime PROPERTIES
    IMPORTED_LOCATION "${ONNXRUNTIME_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${ONNXRUNTIME_INCLUDE_DIR}")
endif()
