"""Spoils files of every kind for some minutes; `make fuzz MINUTES=10`.

    python tests/fuzz/run.py [--minutes 10] [--seed 0] [--only models] [--keep FOLDER]

Each kind has a process of its own, which may die. What fails is kept in tests/fuzz/corpus, as small
as Hypothesis gets it; once cured, it stays there, and the tests try it again. The last line of
each kind says how many files were tried. Exit code 1 if something failed.
"""

import argparse
import faulthandler
import hashlib
import resource
import signal
import subprocess
import sys
import time
import traceback
from pathlib import Path

HERE = Path(__file__).resolve().parent
KINDS = (
    *("pictures", "exif", "models", "checkpoints", "calibrations", "sequences"),
    *("packs", "views"),
)

LIMIT_S = 60
"""An input that takes more of a core's time has failed, as one that waits for ten times as long."""

LIMIT_BYTES = 12 * 2**30
"""Address space of a process, most of which its libraries only reserve."""

_FAILED = 10  # of a worker that has ended well; the watchdog ends it with 1

EXAMPLES = 50
"""Inputs from one seed of Hypothesis."""


def main() -> int:
    """Runs all kinds of files one after the other."""
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=KINDS, help="one kind of files")
    parser.add_argument("--keep", type=Path, default=HERE / "corpus", help="for what fails")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.worker:
        resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
        return work(given.worker, given.minutes, given.seed, given.keep)
    kinds = [given.only] if given.only else list(KINDS)
    failed = [
        kind
        for kind in kinds
        if not watched(kind, given.minutes / len(kinds), given.seed, given.keep)
    ]
    print(f"failed: {', '.join(failed)}" if failed else "nothing failed")
    return bool(failed)


def watched(kind: str, minutes: float, seed: int, keep: Path) -> bool:
    """Runs one kind in a process of its own until its time is over, again where it dies."""
    ends, whole = time.monotonic() + 60 * minutes, True
    while True:
        left = max(0.0, (ends - time.monotonic()) / 60)
        done = subprocess.run(worker(kind, left, seed, keep), check=False)
        last = keep / f".last-{kind}"
        if done.returncode not in {0, _FAILED}:  # it died, or its watchdog ended it
            name = kept(keep, kind, last.read_bytes() if last.exists() else b"")
            print(f"{kind}: the process ended with {done.returncode}; kept {name}", flush=True)
        last.unlink(missing_ok=True)
        whole = whole and done.returncode == 0
        seed += 1_000_000
        if done.returncode in {0, _FAILED} or time.monotonic() > ends:
            return whole


def worker(kind: str, minutes: float, seed: int, keep: Path) -> list[str]:
    """The command of a process for one kind."""
    options = ["--worker", kind, "--minutes", str(minutes), "--seed", str(seed)]
    return [sys.executable, __file__, *options, "--keep", str(keep)]


def work(kind: str, minutes: float, seed: int, keep: Path) -> int:
    """Tries inputs of one kind until the time is over; at least those of one seed."""
    import hypothesis
    from targets import TARGETS

    target, last = TARGETS[kind], keep / f".last-{kind}"
    keep.mkdir(parents=True, exist_ok=True)
    ends, tried, seen = time.monotonic() + 60 * minutes, 0, set()
    spoiled = target.spoiled()
    faulthandler.register(signal.SIGXCPU, file=sys.__stderr__, chain=True)

    def attempt(data: bytes) -> None:
        nonlocal tried
        tried += 1
        last.write_bytes(data)
        faulthandler.dump_traceback_later(10 * LIMIT_S, exit=True, file=sys.__stderr__)
        soft, hard = resource.getrlimit(resource.RLIMIT_CPU)
        resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time()) + LIMIT_S, hard))
        try:
            target.check(data)
        finally:
            resource.setrlimit(resource.RLIMIT_CPU, (soft, hard))
            faulthandler.cancel_dump_traceback_later()

    settings = hypothesis.settings(
        max_examples=EXAMPLES,
        database=None,
        deadline=None,
        suppress_health_check=list(hypothesis.HealthCheck),
        phases=[hypothesis.Phase.generate, hypothesis.Phase.shrink],
    )
    while True:
        test = hypothesis.seed(seed)(settings(hypothesis.given(spoiled)(attempt)))
        try:
            test()
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)
            ours = [frame for frame in frames if "footprints_edge" in frame.filename] or frames
            where = (type(error).__name__, ours[-1].filename, ours[-1].lineno)
            if where not in seen:
                seen.add(where)
                print(f"{kind}: {type(error).__name__}: {str(error)[:300]}")
                print(f"  at {ours[-1].filename}:{ours[-1].lineno}")
                print(f"  kept {kept(keep, kind, last.read_bytes())}", flush=True)
        seed += 1
        if time.monotonic() > ends:
            break
    print(f"{kind}: {tried} tried, {len(seen)} kinds of failures", flush=True)
    return _FAILED if seen else 0


def kept(keep: Path, kind: str, data: bytes) -> Path:
    """Saves an input under a name that depends on its content."""
    path = keep / kind / hashlib.sha256(data).hexdigest()[:12]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


if __name__ == "__main__":
    sys.exit(main())
