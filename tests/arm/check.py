"""The model's files on 64-bit Arm, emulated, against this machine: `make test-arm`.

Each file's maps on Arm are held to the test vectors that the same file gives here, with the
tolerances for ports. All are also compared with the maps that the float32 file gives here. int8
files run here with exact sums (session.x64quantprecision), as on Arm: x86 without VNNI saturates.

    python check.py ARM_FOLDER [--photos FOLDER] [--cpu NAME]

ARM_FOLDER is what fetch.sh makes. PHOTOS calibrate the file for arm64, which is left out without.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import footprints_edge as fp
from footprints_edge.geometry.camera import disparity_to_depth
from footprints_edge_export.verification.check_vectors import check_vectors
from footprints_edge_export.verification.test_vectors import write_vectors

CHECKOUT = Path(__file__).resolve().parents[2]
EXACT = {"session.x64quantprecision": "1"}


def convert(file: Path, *options: object) -> Path:
    checkpoint = CHECKOUT / "models" / "weights" / "edge.pt"
    words = [sys.executable, "-m", "footprints_edge_export.cli", "convert", checkpoint, "-o", file]
    subprocess.run([*map(str, [*words, "--arch", "edge", *options])], check=True)
    return file


def on_arm(arm: Path, cpu: str, *words: object) -> None:
    """Runs Python there."""
    python = next((arm / "root" / "usr" / "bin").glob("python3.??"))
    emulator = arm / "emulator" / "usr" / "bin" / "qemu-aarch64"
    path = os.pathsep.join(map(str, (CHECKOUT / "runtime", CHECKOUT / "export", arm / "site")))
    environment = {**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [emulator, "-cpu", cpu, "-L", arm / "root", python, *words]
    subprocess.run([*map(str, command)], check=True, env=environment)


def off(maps: np.ndarray, expected: np.ndarray) -> tuple[float, float, float, float]:
    """Mean difference of the two probabilities, median relative difference of the two depths."""
    probabilities = np.abs(maps[0, :2] - expected[0, :2]).mean(axis=(1, 2))
    depths = [disparity_to_depth(m[0, 2:]) for m in (maps, expected)]
    relative = np.median(np.abs(depths[0] / depths[1] - 1), axis=(1, 2))
    return (*map(float, probabilities), *map(float, relative))


def row(label: str, pairs: list[tuple[np.ndarray, np.ndarray]]) -> str:
    mean = np.mean([off(*pair) for pair in pairs], axis=0)
    return f"| {label} | {mean[0]:.4f} | {mean[1]:.4f} | {mean[2]:.2%} | {mean[3]:.2%} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("arm", type=Path)
    parser.add_argument("--photos", type=Path, help="folder of photos to calibrate on")
    parser.add_argument("--cpu", default="cortex-a76", help="emulated CPU")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        files = {"float32": convert(work / "float32.onnx", "--precision", "fp32")}
        files["default"] = fp.load().path
        if given.photos is not None:
            options = ("--target", "arm64", "--precision", "int8", "--calibration", given.photos)
            files["arm64"] = convert(work / "arm64.onnx", *options)
        return check(given.arm.resolve(), given.cpu, files, work)


def maps_of(folder: Path) -> list[np.ndarray]:
    """Of all vectors in a folder, by name."""
    return [np.load(file) for file in sorted(folder.glob("*/maps.npy"))]


def check(arm: Path, cpu: str, files: dict[str, Path], work: Path) -> int:
    failed, lines = [], []
    exact: list[np.ndarray] = []
    for name, file in files.items():
        vectors, outputs = work / name / "vectors", work / name / "arm"
        write_vectors(fp.load(file, threads=1, session_options=EXACT), vectors)
        on_arm(arm, cpu, CHECKOUT / "tests" / "arm" / "predict.py", vectors, outputs, file)
        findings = check_vectors(vectors, outputs)
        failed += [f"{name}: {finding}" for finding in findings if not finding.holds]
        here, there = (maps_of(folder) for folder in (vectors, outputs))
        exact = exact or here  # the first file is the float32 one
        pairs = (
            (f"{name}: Arm with x86", there, here),
            (f"{name}: Arm with float32 on x86", there, exact),
            (f"{name}: x86 with float32 on x86", here, exact),
        )
        lines += [row(label, list(zip(a, b, strict=True))) for label, a, b in pairs]
    print(f"\n{cpu}, mean over {len(exact)} vectors:\n")
    print("| compared | p | p* | visible depth | ground depth |")
    print("| --- | ---: | ---: | ---: | ---: |")
    print("\n".join(lines))
    print("\n".join(failed) if failed else "\nall comparisons hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
