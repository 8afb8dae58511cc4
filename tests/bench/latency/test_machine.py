"""What is said about the machine, from made-up files of the system."""

import platform
import subprocess

import numpy as np
import onnxruntime

from footprints_edge_bench.latency.machine import commit, machine, versions

CPUINFO = """processor\t: 0
model name\t: A Quick One 9000
flags\t\t: fpu avx2 fma avx512f avx512_vnni sse

processor\t: 1
model name\t: A Quick One 9000
"""


def test_facts_are_read_from_the_system(tmp_path):
    (tmp_path / "proc").mkdir()
    (tmp_path / "proc/cpuinfo").write_text(CPUINFO)
    (tmp_path / "proc/meminfo").write_text("MemTotal:       24576 kB\nMemFree: 1 kB\n")
    (tmp_path / "proc/loadavg").write_text("1.25 2.00 3.00 1/100 1234\n")
    frequency = tmp_path / "sys/devices/system/cpu/cpu0/cpufreq"
    frequency.mkdir(parents=True)
    (frequency / "scaling_governor").write_text("performance\n")
    found = machine(tmp_path)
    assert found.cpu == "A Quick One 9000"
    assert found.flags == ("avx2", "fma", "avx512f", "avx512_vnni")  # those that matter, in order
    assert found.memory_bytes == 24576 * 1024
    assert found.load == 1.25
    assert found.governor == "performance"
    assert found.python == platform.python_version()
    text = found.as_markdown()
    for word in (
        "A Quick One 9000",
        "avx512_vnni",
        "performance",
        "1.2",
        f"numpy {np.__version__}",
    ):
        assert word in text


def test_a_system_that_tells_nothing_is_no_failure(tmp_path):
    found = machine(tmp_path)
    assert (found.flags, found.load, found.memory_bytes) == ((), None, None)
    assert found.governor == "unknown"
    assert found.usable_cores >= 1
    assert "unknown" in found.as_markdown()


def test_versions_are_those_of_the_modules():
    found = versions()
    assert found["onnxruntime"] == onnxruntime.__version__
    assert found["numpy"] == np.__version__


def test_the_commit_says_whether_files_were_changed(tmp_path):
    assert commit(tmp_path) == "unknown"

    def git(*arguments):
        identity = ["-c", "user.name=x", "-c", "user.email=x@x"]
        subprocess.run(["git", "-C", tmp_path, *identity, *arguments], check=True)

    (tmp_path / "a").write_text("1")
    git("init", "-q")
    git("add", "a")
    git("commit", "-qm", "first")
    clean = commit(tmp_path)
    assert len(clean) >= 12
    assert clean.isalnum()
    (tmp_path / "a").write_text("2")
    assert commit(tmp_path) == clean + "+"
