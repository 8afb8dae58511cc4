"""What pages and ports state of the bundled model: hash, size, gate, example output.

`make model-facts` runs this, which brings them up to date. A test says where it was forgotten.
"""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import footprints_edge as fp
from footprints_edge.maps.confidence import curves

CHECKOUT = Path(__file__).resolve().parents[2]

_HASH = r"\b[0-9a-f]{64}\b"
_BYTES = r"\b\d{1,3}(?:[, ]\d{3}){2,}(?= bytes)"


@dataclass(frozen=True)
class Stated:
    """A place of the checkout that states something of the model.

    Attributes:
        file: the page or source, from the checkout's root.
        pattern: regular expression of what is stated, found there exactly once.
        now: what must stand there.
    """

    file: str
    pattern: str
    now: str


def stated() -> list[Stated]:
    """All such places, with the facts of the model that is bundled now."""
    model = fp.load(threads=1)
    size = model.path.stat().st_size
    facts = {_HASH: model.sha256, _BYTES: f"{size:,}"}
    pages = ("docs/model-file.md", "docs/native.md", "docs/porting.md")
    places = [Stated(page, pattern, now) for page in pages for pattern, now in facts.items()]

    resize = r"(?<=bundled file's is `)\w+"
    places.append(Stated("docs/porting.md", resize, model.metadata.resize))
    megabytes = f"{size / 1e6:.0f} MB"
    places += [
        Stated("README.md", r"\d+ MB(?= model is included)", megabytes),
        Stated("README.md", r"(?<=million parameters, )\d+ MB", megabytes),
        Stated("docs/javascript.md", r"(?<=The model \()\d+ MB", megabytes),
        Stated("docs/web.md", r"\d+ MB(?= the model)", megabytes),
        Stated("runtime/js/README.md", r"\d+ MB(?=, inside the package)", megabytes),
    ]

    clear_top, least = gate()
    metres, minimal = "docs/porting-metres.md", "examples/embed_minimal.py"
    cpp, js = "runtime/cpp/src/prediction.cpp", "runtime/js/src/maps/ground-maps.ts"
    places += [
        Stated(metres, r"\S+(?= clear < )", clear_top),
        Stated(metres, r"(?<= clear < )[^:\s]+", least),
        Stated(minimal, r"\S+(?= \* \(1 - maps\[0, 1, : h // 4\])", clear_top),
        Stated(minimal, r"(?<=// 4\].mean\(\)\) >= )[^:\s]+", least),
        Stated(cpp, r"(?<=CLEAR_TOP = )[^,\s]+", clear_top),
        Stated(cpp, r"(?<=LEAST_EVIDENCE = )[^;\s]+", least),
        Stated(js, r"(?<=LEAST_EVIDENCE\] = \[)[^,\s]+", clear_top),
        Stated(js, r"(?<=\d, )[-.\d]+(?=\];)", least),
    ]
    return places


def said() -> list[Stated]:
    """What example programs say of the office, where pages show it.

    With exact sums, as most processors have; others round int8 to a per cent or two more or less,
    so no test holds these.
    """
    model = fp.load(threads=1, session_options={"session.x64quantprecision": "1"})
    office = model.predict(CHECKOUT / "examples" / "office.jpg")
    visible, hidden = f"{office.visible_ground.mean():.0%}", f"{office.hidden_ground.mean():.0%}"
    nearest = f"{office.ground_depth_m[office.ground].min():.1f} m"
    places = []
    for page in ("README.md", "docs/index.md"):
        places += [
            Stated(page, r"(?<=^visible ground: )\d+%", visible),
            Stated(page, r"(?<=^hidden ground:  )\d+%", hidden),
            Stated(page, r"(?<=^nearest ground: )[\d.]+ m", nearest),
        ]
    line = (
        f"floor on {office.ground.mean():.0%} of the picture ({hidden} hidden), "
        f"nearest {nearest}, camera {office.ground_plane().camera_height_m:.1f} m high"
    )
    return [*places, Stated("docs/getting-started.md", "^floor on .*$", line)]


def gate() -> tuple[str, str]:
    """The weight of a clear top beside the peak, and the least sum of both (`confidence.json`)."""
    found = curves()
    least = math.log(found.least_ground / (1 - found.least_ground)) - found.ground.offset
    peak, clear_top = (found.ground.weights[name] for name in ("peak", "clear_top"))
    return f"{clear_top / peak:.3f}", f"{least / peak:.3f}"


def states(place: Stated) -> str:
    """What the place states now.

    Raises:
        ValueError: its text was changed, so that the pattern is not found once.
    """
    found = re.findall(place.pattern, (CHECKOUT / place.file).read_text(), re.MULTILINE)
    if len(found) != 1:
        raise ValueError(f"{place.file} has {len(found)} places like {place.pattern}, not one")
    return str(found[0])


def main() -> None:
    """Corrects the files, and prints what it changed."""
    for place in [*stated(), *said()]:
        if (before := states(place)) != place.now:
            file = CHECKOUT / place.file
            file.write_text(re.sub(place.pattern, place.now, file.read_text(), flags=re.MULTILINE))
            print(f"{place.file}: {before} is now {place.now}")


if __name__ == "__main__":
    main()
