"""The C++ library, built with sanitizers, held against the test vectors and the Python runtime."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
import pytest
from PIL import Image

import footprints_edge as fp
from footprints_edge_export.verification.check_vectors import check_vectors
from footprints_edge_export.verification.test_vectors import write_vectors

CHECKOUT = Path(__file__).resolve().parents[1]
SOURCES = CHECKOUT / "runtime" / "cpp"
EXAMPLES = CHECKOUT / "examples"
SANITIZED = "-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer -O1"

_INSTALLED = Path("/usr/include/onnxruntime")
HEADERS = {
    "named_headers": os.environ.get("ONNXRUNTIME_INCLUDE"),
    "headers_of_a_package": _INSTALLED if _INSTALLED.is_dir() else None,
    "stand_in_headers": CHECKOUT / "tests" / "stand_in",
}
"""Where the declarations of onnxruntime are from, the best first; the name is in the tests' names."""

WHICH = next(name for name, folder in HEADERS.items() if folder)


def run(*words, **options):
    done = subprocess.run(
        [*map(str, words)], check=False, capture_output=True, text=True, timeout=600, **options
    )
    assert done.returncode == 0, f"{' '.join(map(str, words))}\n{done.stdout}\n{done.stderr}"
    return done.stdout


@dataclass(frozen=True)
class Library:
    """The library, installed into a folder of its own, and the program for vectors."""

    prefix: Path
    run_vectors: Path
    onnxruntime: Path


@pytest.fixture(scope="module", params=[WHICH])
def library(request, tmp_path_factory):
    """The wheel of onnxruntime brings its shared library, but no header."""
    capi = Path(onnxruntime.__file__).parent / "capi"
    shared = next(capi.glob("libonnxruntime.so*"), None)
    if shared is None or not all(map(shutil.which, ("cmake", "c++", "pkg-config"))):
        pytest.skip("needs cmake, a C++ compiler, pkg-config, and a wheel of onnxruntime for Linux")
    folder = tmp_path_factory.mktemp("cpp")
    (folder / "libonnxruntime.so.1").symlink_to(shared)  # the name that it goes by
    build, prefix = folder / "build", folder / "prefix"
    run(
        *("cmake", "-S", SOURCES, "-B", build, "-DFPE_TESTS=ON", "-DCMAKE_BUILD_TYPE=None"),
        f"-DCMAKE_INSTALL_PREFIX={prefix}",
        f"-DCMAKE_CXX_FLAGS={SANITIZED} -Werror",
        f"-DONNXRUNTIME_INCLUDE_DIR={HEADERS[request.param]}",
        f"-DONNXRUNTIME_LIBRARY={folder / 'libonnxruntime.so.1'}",
    )
    run("cmake", "--build", build, "--parallel", "2")
    run("cmake", "--install", build)
    return Library(prefix, build / "run_vectors", folder / "libonnxruntime.so.1")


@pytest.fixture(scope="module")
def model():
    return fp.load(threads=1)


@pytest.fixture(scope="module")
def vectors(model, tmp_path_factory):
    folder = tmp_path_factory.mktemp("vectors")
    write_vectors(model, folder)
    return folder


@pytest.fixture(scope="module")
def room(tmp_path_factory):
    """A photo as PPM."""
    path = tmp_path_factory.mktemp("room") / "room.ppm"
    Image.open(EXAMPLES / "room.jpg").save(path)
    return path


def words_of(entry):
    """What `run_vectors` is told of a vector, in its order."""
    camera, pose, grid = entry["image_intrinsics_px"], entry["known_pose"], entry["grid"]
    known = [pose[key] for key in ("camera_height_m", "pitch_deg", "roll_deg")]
    path = entry["path"]
    return [
        *(camera[key] for key in ("fx", "fy", "cx", "cy")),
        *entry["network_size_px"],
        *("nan" if each is None else each for each in known),
        *(grid["cell_m"], grid["range_m"], grid["robot_height_m"]),
        *([] if path is None else [*path["start_px"], *path["goal_px"], path["margin_m"]]),
    ]


def test_the_library_gives_the_vectors(library, model, vectors, tmp_path):
    for entry in json.loads((vectors / "vectors.json").read_text())["vectors"]:
        picture, outputs = tmp_path / "picture.ppm", tmp_path / "out" / entry["name"]
        outputs.mkdir(parents=True)
        Image.open(vectors / entry["files"]["image"]).save(picture)
        run(library.run_vectors, model.path, picture, outputs, *words_of(entry))
    findings = check_vectors(vectors, tmp_path / "out")
    assert {"input", "path_m"} <= {finding.quantity for finding in findings}
    assert [str(finding) for finding in findings if not finding.holds] == []


def outside_programs(library, tmp_path):
    """The two examples: C by pkg-config, C++ by CMake."""
    shown = run(
        *("pkg-config", "--cflags", "--libs", "footprints_edge"),
        env={**os.environ, "PKG_CONFIG_PATH": str(library.prefix / "lib" / "pkgconfig")},
    )
    return shown.split()


def nearest_free(prediction):
    """Forward and left of the nearest cell of free ground, metres."""
    grid = prediction.top_down()
    free = grid.places_m[grid.free]
    return free[np.linalg.norm(free, axis=1).argmin()]
