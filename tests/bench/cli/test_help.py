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
    "roofline": ("--threads", "--trials", "--output", "--cache", "--edge-checkpoint"),
    "passes": ("--checkpoint", "--photos"),
    "reduced-decoding": ("--model",),
    "label-speed": (),
}
HEAVY = {"numpy", "PIL", "onnxruntime", "torch", "onnx", "tqdm", "matplotlib", "cv2"}

PROGRAM = """
import json, sys
from footprints_edge_bench.cli import main
sys.argv = ["fp-bench", *sys.argv[1:], "--help"]
try:
    main()
finally:
    print(json.dumps(sorted(sys.modules)), file=sys.stderr)
"""


def help_of(*names):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *names], capture_output=True, text=True, check=True
    )
    return done.stdout, set(json.loads(done.stderr))


def test_every_command_is_listed():
    text, modules = help_of()
    assert all(f"\n  {name} " in text for name in COMMANDS)
    assert "..." not in text.split("Commands:")[1]  # summaries fit on their line
    assert not modules & HEAVY


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_a_command_names_its_options(name):
    text, modules = help_of(name)
    assert all(option in text for option in COMMANDS[name])
    assert "Exit codes: 0 done" in text
    assert not modules & HEAVY
