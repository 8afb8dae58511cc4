import pytest

from footprints_edge.foundation.size_text import parse_size


@pytest.mark.parametrize("text", ["256x448", " 256X448 "])
def test_height_comes_first(text):
    assert parse_size(text) == (256, 448)


@pytest.mark.parametrize("text", ["", "256", "256x", "0x448", "-1x4", "256x448x3", "1e3x4"])
def test_anything_else_is_refused_with_an_example(text):
    with pytest.raises(ValueError, match="256x448"):
        parse_size(text)
