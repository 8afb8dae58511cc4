"""Allowed imports, and the cost of importing."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import footprints_edge

PACKAGE = Path(footprints_edge.__file__).parent
HEAVY = ("torch", "onnx", "cv2", "typer", "matplotlib", "scipy", "skimage")


def run(code, *arguments):
    return subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True
    ).stdout


def imported_by(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path} imports relatively"
            yield node.module.split(".")[0]


def test_each_file_imports_only_allowed_packages():
    for path in PACKAGE.rglob("*.py"):
        names = set(imported_by(path))
        own = {"numpy", "PIL", "footprints_edge", "onnxruntime", "typer"} | sys.stdlib_module_names
        if path.name == "path_planning.py":  # the extra `plan`
            own |= {"scipy"}
        if path.name == "opencv.py":  # the extra `video`
            own |= {"cv2"}
        if path.name == "calibration.py":  # the extra `video`
            own |= {"yaml"}
        if path.name == "encoders.py":  # the extra `video`
            own |= {"av"}
        if path.name == "rosbags_library.py":  # the extra `ros`
            own |= {"rosbags"}
        if path.name == "on_ray.py":  # the extra `ray`
            own |= {"ray"}
        if path.name == "openvino.py":  # the extra `openvino`
            own |= {"openvino"}
        assert names <= own, path
        assert "onnxruntime" not in names or path.name == "onnxruntime_engine.py"
        assert "typer" not in names or path.parent.name == "cli"


def test_a_prediction_loads_nothing_heavy(tiny_path, picture, tmp_path):
    from PIL import Image

    Image.fromarray(picture).save(tmp_path / "a.png")
    code = """
import json, sys
import footprints_edge as fp
prediction = fp.load(sys.argv[1]).predict(sys.argv[2])
prediction.save(sys.argv[3], ["overlay", "npz", "png16", "json", "ply"])
print(json.dumps(sorted(sys.modules)))
"""
    loaded = json.loads(run(code, str(tiny_path), str(tmp_path / "a.png"), str(tmp_path)))
    assert "onnxruntime" in loaded
    assert not set(HEAVY) & set(loaded)


def test_the_public_names_are_all_there():
    for name in footprints_edge.__all__:
        assert getattr(footprints_edge, name) is not None
        assert name in dir(footprints_edge)
    with pytest.raises(AttributeError, match="nonsense"):
        footprints_edge.nonsense  # noqa: B018


def test_importing_the_package_imports_none_of_its_parts():
    code = "import sys, footprints_edge; print('numpy' in sys.modules, 'PIL' in sys.modules)"
    assert run(code).split() == ["False", "False"]


def best_s(*commands, repeats=5):
    """Least processor time of each command: what else runs on the machine takes no part."""

    def spent_s():
        spent = os.times()
        return spent.children_user + spent.children_system

    best = [float("inf")] * len(commands)
    for _ in range(repeats):
        for index, command in enumerate(commands):
            before_s = spent_s()
            subprocess.run([sys.executable, *command], capture_output=True, check=True)
            best[index] = min(best[index], spent_s() - before_s)
    return best


def test_importing_the_package_is_quick():
    bare_s, import_s = best_s(["-c", "pass"], ["-c", "import footprints_edge"])
    assert import_s - bare_s <= 0.25


def test_help_and_version_are_no_slower_than_loading_the_runtime():
    said = [(command, word) for command in ("infer", "models") for word in ("--help", "--version")]
    commands = [
        ["-c", "import numpy, onnxruntime"],
        *(["-m", f"footprints_edge.cli.{command}", word] for command, word in said),
    ]
    best, slower = [float("inf")] * len(commands), {}
    for _ in range(5):  # a busy machine makes single starts slow, and none fast
        best = [min(pair) for pair in zip(best, best_s(*commands, repeats=3), strict=True)]
        slower = {of: s for of, s in zip(said, best[1:], strict=True) if s > best[0]}
        if not slower:
            break
    assert slower == {}
