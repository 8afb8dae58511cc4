"""Help of every command: complete, and without heavy imports, so that it is quick."""

import json
import subprocess
import sys

import pytest

COMMANDS = {
    "accuracy": ("--images", "--walkable", "--frames", "--boxes", "--voxels", "--fresh"),
    "planning": ("--paths", "--seed", "--held-out"),
    "occupancy": ("--model", "--every"),
    "flicker": ("--model", "--every"),
    "video": ("--threads", "--length"),
    "latency": ("--threads", "--trials", "--output", "--cache", "--edge-checkpoint"),
    "frame": ("--model", "--threads", "--trials", "--photos"),
    "table": ("--threads", "--trials", "--output", "--cache", "--edge-checkpoint"),
    "trade-off": ("--model", "--threads", "--trials", "--output"),
    "roofline": ("--threads", "--trials", "--output", "--cache", "--edge-checkpoint"),
    "passes": ("--checkpoint", "--photos"),
    "reduced-decoding": ("--model",),
    "label-speed": (),
}
HEAVY = {"numpy", "PIL", "onnxruntime", "torch", "onnx", "tqdm", "matplotlib", "cv2"}

PROGRAM = """
import contextlib, io, json, sys
from footprints_edge_bench.cli import main
for command in ["", *sys.argv[1:]]:
    sys.argv = ["fp-bench", *command.split(), "--help"]
    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        main()
    print(json.dumps([command, text.getvalue(), sorted(sys.modules)]))
"""


@pytest.fixture(scope="module")
def said():
    """The help of each command, "" for all, and the modules loaded by then: of one process."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *COMMANDS], capture_output=True, text=True, check=True
    )
    lines = map(json.loads, done.stdout.splitlines())
    return {command: (text, set(modules)) for command, text, modules in lines}


def test_every_command_is_listed(said):
    text, modules = said[""]
    assert all(f"\n  {name} " in text for name in COMMANDS)
    assert "..." not in text.split("Commands:")[1]  # summaries fit on their line
    assert not modules & HEAVY


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_names_its_options(said, name):
    text, modules = said[name]
    assert all(option in text for option in COMMANDS[name])
    assert "Exit codes: 0 done" in text
    assert not modules & HEAVY
