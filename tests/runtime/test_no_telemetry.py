"""Nothing is reported to anybody, and nothing is kept in the home folder.

Each program runs with an empty home folder and without `CI`, which would switch the reports of both
engines off by itself.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]
ROOM = CHECKOUT / "examples" / "room.jpg"
CHOICES = {"CI", "TF_BUILD", "JENKINS_URL", "ORT_DISABLE_TELEMETRY", "XDG_CACHE_HOME"}

LOAD = "import footprints_edge as fp; fp.load(threads=1)"
PROGRAMS = {
    "import": "import footprints_edge, onnxruntime",
    "load": LOAD,
    "fp-infer": f"from footprints_edge.cli.infer import main; "
    f"import sys; sys.argv = ['fp-infer', {str(ROOM)!r}, '-o', 'out', '--format', 'json']; main()",
    "fp-models": "from footprints_edge.cli.models import main; "
    "import sys; sys.argv = ['fp-models', 'verify']; main()",
    "fp-export": "import footprints_edge_export.quantization.quantize",
    "fp-bench": "import footprints_edge_bench, onnxruntime",
    "example": f"import runpy, sys, footprints_edge.model_files.registry as r; "
    f"sys.argv = ['embed_minimal.py', str(r.resolve()), {str(ROOM)!r}]; "
    f"runpy.run_path({str(CHECKOUT / 'examples' / 'embed_minimal.py')!r})",
}


def run(code, folder, before=(), **environment):
    """Runs a program; the files that it leaves in its home folder."""
    home = folder / "home"
    home.mkdir()
    kept = {name: value for name, value in os.environ.items() if name not in CHOICES}
    kept |= {"HOME": str(home), "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    subprocess.run(
        [*before, sys.executable, "-c", code],
        check=True,
        cwd=folder,
        env=kept | environment,
        capture_output=True,
        timeout=100,
    )
    return [str(path.relative_to(home)) for path in home.rglob("*") if path.is_file()]


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_leaves_nothing_in_the_home_folder(name, tmp_path):
    if name == "fp-export":
        pytest.importorskip("onnx")
    assert run(PROGRAMS[name], tmp_path) == []


def test_whoever_sets_the_variable_has_chosen(tmp_path):
    code = "import os, footprints_edge; assert os.environ['ORT_DISABLE_TELEMETRY'] == '0'"
    run(code, tmp_path, ORT_DISABLE_TELEMETRY="0")


def test_openvino_leaves_nothing_in_the_home_folder(tmp_path):
    pytest.importorskip("openvino", reason="the extra openvino is not installed")
    assert run("import footprints_edge as fp; fp.load(engine='openvino')", tmp_path) == []


def test_no_network_is_looked_for(tmp_path):
    """Only a trace of the system calls shows that: a failed look-up leaves nothing else."""
    if shutil.which("strace") is None or shutil.which("unshare") is None:
        pytest.skip("strace and unshare are needed to see what a process asks the network for")
    trace = tmp_path / "trace"
    strace = ["unshare", "-rn", "strace", "-f", "-e", "trace=connect", "-o", str(trace)]
    if subprocess.run([*strace, "true"], check=False, capture_output=True).returncode:
        pytest.skip("this machine allows no network namespace or no trace")
    assert run(LOAD + ".predict(" + repr(str(ROOM)) + ")", tmp_path, strace) == []
    asked = [line for line in trace.read_text().splitlines() if "connect(" in line]
    assert asked == []
