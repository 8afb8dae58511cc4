"""The test vectors of the bundled model in every port, as the table of the documentation:
`make port-table`.

On an x86 processor without VNNI an engine's int8 sums saturate, each engine's in its own order,
unless it is told otherwise; those of WebAssembly and Arm do not. So what runs onnxruntime on this
machine is held to the vectors that `fp-export vectors` writes on it, and the others to vectors of
exact sums, which `runtime/js/tests/make_fixtures.py` wrote. The last rows are the engines for
Python as they are, against exact sums: what saturation costs.

    python run.py OUT_DIR [ARM_FOLDER]

ARM_FOLDER is what `tests/arm/fetch.sh` makes; without it the row for Arm is left out.
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import onnxruntime
from PIL import Image

CHECKOUT = Path(__file__).resolve().parents[2]
sys.path += [str(CHECKOUT / "tests" / name) for name in ("support", "arm", "ports")]

from check import on_arm  # noqa: E402 - found by the line above
from cpp_vectors import words_of  # noqa: E402
from differences import main as print_table  # noqa: E402

import footprints_edge as fp  # noqa: E402
from footprints_edge_export.verification.test_vectors import write_vectors  # noqa: E402

EXACT_VECTORS = CHECKOUT / "runtime" / "js" / "tests" / "fixtures" / "vectors"
MODEL = fp.load().path
ENGINES = {
    "OpenVINO in floats": ("openvino", "LP_TRANSFORMS_MODE=NO"),
    "OpenVINO as it is": ("openvino",),
    "onnxruntime as it is": ("onnxruntime",),
}
PREDICT = CHECKOUT / "tests" / "arm" / "predict.py"


def run(*words: object, **environment: object) -> None:
    """Runs a program of the checkout; what it prints is of no interest unless it fails."""
    done = subprocess.run(
        [*map(str, words)],
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=CHECKOUT,
        env={**os.environ, **{name: str(value) for name, value in environment.items()}},
    )
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}\n{done.stdout}")


def in_cpp(vectors: Path, outputs: Path, build: Path) -> None:
    """With the library of onnxruntime's wheel, and the declarations that the tests have for it."""
    build.mkdir(parents=True, exist_ok=True)
    shared = next((Path(onnxruntime.__file__).parent / "capi").glob("libonnxruntime.so*"))
    link = build / "libonnxruntime.so.1"
    link.unlink(missing_ok=True)
    link.symlink_to(shared)
    headers = os.environ.get("ONNXRUNTIME_INCLUDE", CHECKOUT / "tests" / "stand_in")
    given = f"-DONNXRUNTIME_INCLUDE_DIR={headers}", f"-DONNXRUNTIME_LIBRARY={link}"
    run("cmake", "-S", "runtime/cpp", "-B", build, "-DFPE_TESTS=ON", *given)
    run("cmake", "--build", build)
    for entry in json.loads((vectors / "vectors.json").read_text())["vectors"]:
        picture = build / "picture.ppm"
        Image.open(vectors / entry["files"]["image"]).save(picture)
        (outputs / entry["name"]).mkdir(parents=True, exist_ok=True)
        run(build / "run_vectors", MODEL, picture, outputs / entry["name"], *words_of(entry))


def main(folder: Path, arm: Path | None) -> None:
    names = ("Python", "minimal Python", "Node", "C++")
    here = {name: folder / name.replace(" ", "-") for name in names}
    exact = {"browser": folder / "browser"}
    for old in (*here.values(), *(folder / each for each in ("browser", "arm64", *ENGINES))):
        shutil.rmtree(old, ignore_errors=True)
    vectors = folder / "vectors"
    write_vectors(fp.load(threads=1), vectors)
    run(sys.executable, PREDICT, vectors, here["Python"], MODEL)
    minimal = CHECKOUT / "examples" / "embed_minimal.py"
    run(sys.executable, minimal, MODEL, vectors, here["minimal Python"])
    run("node", "examples/node/run-vectors.js", MODEL, vectors, here["Node"])
    in_cpp(vectors, here["C++"], folder / "build-cpp")
    print_table(vectors, here)

    browser = ("npm", "--prefix", "examples/web", "test", "--", "vectors")
    run(*browser, PYTHON=sys.executable, VECTOR_OUTPUTS=exact["browser"])
    if arm is not None:
        exact["arm64 under qemu"] = folder / "arm64"
        on_arm(arm, "cortex-a76", PREDICT, EXACT_VECTORS, exact["arm64 under qemu"], MODEL)
    for name, options in ENGINES.items():
        exact[name] = folder / name
        run(sys.executable, PREDICT, EXACT_VECTORS, exact[name], MODEL, *options)
    print()
    print_table(EXACT_VECTORS, exact)


if __name__ == "__main__":
    given = [Path(word).resolve() for word in sys.argv[1:]]
    main(given[0], given[1] if len(given) > 1 else None)
