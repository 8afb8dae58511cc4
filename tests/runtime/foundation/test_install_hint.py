import re
import tomllib
from pathlib import Path

import footprints_edge
from footprints_edge.foundation.install_hint import install_hint

PYPROJECT = Path(__file__).parents[3] / "pyproject.toml"


def test_the_hint_works_with_a_package_index_and_in_a_checkout():
    hint = install_hint("video")
    assert "pip install 'footprints-edge[video]'" in hint
    assert "pip install '.[video]'" in hint


def test_every_hint_names_an_extra_that_exists():
    sources = Path(footprints_edge.__file__).parent.rglob("*.py")
    named = {
        extra
        for path in sources
        for extra in re.findall(r"install_hint\(['\"](\w+)", path.read_text(encoding="utf-8"))
    }
    assert named == {"openvino", "plan", "ray", "ros", "video"}
    assert named <= set(tomllib.loads(PYPROJECT.read_text())["project"]["optional-dependencies"])
