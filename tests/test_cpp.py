"""The C++ library, built with sanitizers, held against the test vectors and the Python runtime."""

import json
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
from cpp_vectors import words_of
from painted_room import painted
from PIL import Image

import footprints_edge as fp
from footprints_edge.errors import GroundPlaneError
from footprints_edge.inputs.preprocessing import FILTERS
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
"""Where onnxruntime's declarations are from, the best first; the tests' names say which."""

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
def library(request, once):
    """The wheel of onnxruntime brings its shared library, but no header."""
    capi = Path(onnxruntime.__file__).parent / "capi"
    shared = next(capi.glob("libonnxruntime.so*"), None)
    if shared is None or not all(map(shutil.which, ("cmake", "c++", "pkg-config"))):
        pytest.skip("needs cmake, a C++ compiler, pkg-config, and a wheel of onnxruntime for Linux")

    def make(folder):
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

    return once(f"library-{request.param}", make)


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


def run_vectors(library, model, vectors, outputs):
    """What the library makes of vectors, compared with them; nothing may be missing."""
    picture = outputs / "picture.ppm"
    for entry in json.loads((vectors / "vectors.json").read_text())["vectors"]:
        (outputs / entry["name"]).mkdir()
        Image.open(vectors / entry["files"]["image"]).save(picture)
        words = words_of(entry)
        run(library.run_vectors, model.path, picture, outputs / entry["name"], *words)
    findings = check_vectors(vectors, outputs)
    assert {"input", "path_m of the port's maps"} <= {finding.quantity for finding in findings}
    assert not any("not checked" in str(finding) for finding in findings)
    return [str(finding) for finding in findings if not finding.holds]


def test_the_library_gives_the_vectors(library, model, vectors, tmp_path):
    assert run_vectors(library, model, vectors, tmp_path) == []


def test_the_library_gives_a_painted_room(library, tmp_path):
    """Whose maps no engine rounds."""
    model, photo = painted(tmp_path)
    write_vectors(model, tmp_path / "vectors", photo)
    (tmp_path / "out").mkdir()
    assert run_vectors(library, model, tmp_path / "vectors", tmp_path / "out") == []


def nearest_free(prediction):
    """Forward and left of the nearest cell of free ground, metres, as the examples print it."""
    grid = prediction.top_down()
    free = grid.places_m[grid.free]
    ahead_m, left_m = free[np.linalg.norm(free, axis=1).argmin()]
    side = "right" if left_m < 0 else "left"
    return f"nearest free ground: {ahead_m:.2f} m ahead, {abs(left_m):.2f} m to the {side}\n"


def agrees(said, expected):
    """Whether two such lines agree to a cell and a half, and in the side."""
    numbers = [[float(n) for n in re.findall(r"[0-9.]+(?= m)", line)] for line in (said, expected)]
    same_side = said.split()[-1] == expected.split()[-1]
    return same_side and numbers[0] == pytest.approx(numbers[1], abs=0.08)


@pytest.fixture(scope="module")
def expected(model, room):
    """What the Python runtime says of the photo; without EXIF, as the programs see it."""
    rgb = np.asarray(Image.open(room))
    return {
        height: nearest_free(model.predict(rgb, camera_height_m=height)) for height in (None, 1.2)
    }


def compiled(library, source, program):
    """A program in C, built against the installed library."""
    compiler = [
        *("cc", "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"),
        *SANITIZED.split(),
    ]
    flags = run(
        *("pkg-config", "--cflags", "--libs", "footprints_edge"),
        env={**os.environ, "PKG_CONFIG_PATH": str(library.prefix / "lib" / "pkgconfig")},
    ).split()
    rpath = f"-Wl,-rpath,{library.onnxruntime.parent}"
    run(*compiler, source, *flags, rpath, "-o", program)
    return program


def test_the_c_example_says_what_python_says(library, model, room, expected, tmp_path):
    program = compiled(library, EXAMPLES / "c" / "nearest_ground.c", tmp_path / "nearest_ground")
    assert agrees(run(program, model.path, room), expected[None])
    assert agrees(run(program, model.path, room, "1.2"), expected[1.2])


def test_the_c_example_refuses_a_deep_picture(library, model, tmp_path):
    """Its 16 bits are not taken for 8."""
    (tmp_path / "deep.ppm").write_bytes(b"P6 4 4 65535 " + bytes(96))
    program = compiled(library, EXAMPLES / "c" / "nearest_ground.c", tmp_path / "nearest_ground")
    done = subprocess.run(
        [program, model.path, tmp_path / "deep.ppm"], check=False, capture_output=True, text=True
    )
    assert done.returncode == 1
    assert "is no 8-bit P6 file" in done.stderr


ODD_CALLS = r"""
#include <footprints_edge.h>
#include <math.h>
#include <stdio.h>

int main(int count, char **words) {
    static uint8_t rgb[96 * 128 * 3];
    fpe_model *model;
    fpe_prediction *seen, *known;
    fpe_grid *grid;
    fpe_options options = fpe_default_options();
    int rows, columns;
    if (count != 2 || fpe_load(words[1], 1, &model)) return 1;
    printf("%d ", fpe_input_size(model, 96, 128, NULL, &columns));
    printf("%d ", fpe_input_size(model, 96, 0, &rows, &columns));
    options.threshold = 1; /* nothing is ground */
    if (fpe_predict(model, rgb, 96, 128, NULL, &options, &seen)) return 1;
    fpe_plane plane;
    int is_refused = fpe_ground_plane(seen, &plane) == FPE_NO_GROUND_PLANE;
    printf("%d %s ", is_refused, fpe_no_ground_plane_reason(seen));
    options.camera_height_m = 1.4, options.pitch_deg = 20, options.roll_deg = 0;
    if (fpe_predict(model, rgb, 96, 128, NULL, &options, &known)) return 1;
    printf("%d ", fpe_no_ground_plane_reason(known) == NULL);
    const double ranges_m[] = {1.1, 1.0}, cells_m[] = {0.1, 0.3};
    for (int i = 0; i < 2; i++) {
        if (fpe_top_down(known, cells_m[i], ranges_m[i], FPE_ROBOT_HEIGHT_M, &grid)) return 1;
        fpe_grid_size(grid, &rows, &columns);
        printf("%d %d ", rows, isnan(fpe_grid_nearest_obstacle_m(grid, NAN)) != 0);
        fpe_grid_free(grid);
    }
    fpe_prediction_free(seen);
    fpe_prediction_free(known);
    fpe_model_free(model);
    return 0;
}
"""


def test_odd_calls_from_c_are_answered_as_in_python(library, model, tmp_path):
    (tmp_path / "odd_calls.c").write_text(ODD_CALLS)
    program = compiled(library, tmp_path / "odd_calls.c", tmp_path / "odd_calls")
    prediction = model.predict(
        np.zeros((96, 128, 3), np.uint8), camera_height_m=1.4, pitch_deg=20, roll_deg=0
    )
    rows = [prediction.top_down(*sizes).cells.shape[0] for sizes in ((0.1, 1.1), (0.3, 1.0))]
    with pytest.raises(GroundPlaneError) as refusal:
        model.predict(np.zeros((96, 128, 3), np.uint8), threshold=1).ground_plane()
    expected = f"1 1 1 {refusal.value.reason} 1 {rows[0]} 1 {rows[1]} 1"
    assert run(program, model.path).split() == expected.split()


def blocks(page):
    """The code of a page of the documentation, by the file that it is to be kept in."""
    found = re.findall(r'```\w+ title="([^"]+)"\n(.*?)```', page.read_text(), re.DOTALL)
    return dict(found)


def test_a_stranger_gets_metres_from_an_empty_folder(library, model, room, expected, tmp_path):
    """The page's own files, in a folder with nothing else, and the installed library."""
    for name, text in blocks(CHECKOUT / "docs" / "native.md").items():
        (tmp_path / name).write_text(text)
    assert {path.name for path in tmp_path.iterdir()} == {"CMakeLists.txt", "main.cpp"}
    run(
        *("cmake", "-S", tmp_path, "-B", tmp_path / "build", "-DCMAKE_BUILD_TYPE=None"),
        f"-DCMAKE_PREFIX_PATH={library.prefix}",
        f"-DCMAKE_CXX_FLAGS={SANITIZED}",
    )
    run("cmake", "--build", tmp_path / "build")
    assert agrees(run(tmp_path / "build" / "ground", model.path, room), expected[None])


def refused(library, *words):
    done = subprocess.run(
        [*map(str, (library.run_vectors, *words))], check=False, capture_output=True, text=True
    )
    assert done.returncode == 1
    return done.stderr


CAMERA = ["500", "500", "320", "180", "64", "96", "nan", "nan", "nan", "0.05", "6", "1.2"]


def test_it_says_which_file_is_wrong_and_why(library, room, tmp_path):
    (tmp_path / "text.onnx").write_text("no model")
    for name, why in (
        ("text.onnx", "is damaged, not an ONNX model"),
        ("none.onnx", "No such file"),
    ):
        said = refused(library, tmp_path / name, room, tmp_path, *CAMERA)
        assert str(tmp_path / name) in said
        assert why in said


def with_facts(model, path, **facts):
    """The bundled file with other metadata; None takes a key away."""
    proto = onnx.load(model.path)
    props = {prop.key: prop.value for prop in proto.metadata_props}
    props |= {f"footprints.{key}": value for key, value in facts.items()}
    onnx.helper.set_model_props(proto, {k: v for k, v in props.items() if v is not None})
    onnx.save(proto, path)
    return path


@pytest.mark.parametrize(
    ("facts", "says"),
    [
        ({"format": None}, "is no model of footprints-edge: it lacks the metadata"),
        ({"format": "2"}, "footprints.format is '2'"),
        ({"resize": "cubic"}, "footprints.resize is 'cubic'"),
        ({"depth_range_m": "100,0.1"}, "footprints.depth_range_m is '100,0.1'"),
        ({"camera": "focal_px=0"}, "footprints.camera is 'focal_px=0'"),
        ({"outputs": "masks"}, "gives maps of another shape"),
    ],
)
def test_it_refuses_metadata_that_cannot_be(library, model, room, tmp_path, facts, says):
    file = with_facts(model, tmp_path / "file.onnx", **facts)
    said = refused(library, file, room, tmp_path, *CAMERA)
    assert str(file) in said
    assert says in said


@pytest.mark.parametrize("name", FILTERS)
def test_its_filters_are_pillows(library, model, room, tmp_path, name):
    file = with_facts(model, tmp_path / "file.onnx", resize=name)
    run(library.run_vectors, file, room, tmp_path, *CAMERA)
    width, height = int(CAMERA[5]), int(CAMERA[4])
    expected = Image.open(room).resize((width, height), Image.Resampling[name.upper()])
    np.testing.assert_array_equal(np.load(tmp_path / "input.npy")[0], np.asarray(expected))


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        (0, "-500", "fx -500"),
        (4, "65", "cannot be 65 x 96"),
        (6, "-1", "camera height is -1"),
        (7, "91", "pitch is 91"),
        (8, "-181", "roll is -181"),
        (9, "0", "the cell is 0 m"),
        (11, "0.1", "robot's height is 0.1"),
    ],
)
def test_it_says_which_number_cannot_be(library, model, room, tmp_path, place, value, says):
    words = CAMERA.copy()
    if place >= 9:  # there is a grid, whatever the picture shows
        words[6:9] = "1.4", "20", "0"
    words[place] = value
    assert says in refused(library, model.path, room, tmp_path, *words)


def test_it_is_of_the_version_of_the_python_package():
    cmake = (SOURCES / "CMakeLists.txt").read_text()
    version = re.search(r"footprints_edge VERSION ([0-9.]+)", cmake)[1]
    assert f'version = "{version}"' in (CHECKOUT / "pyproject.toml").read_text()
