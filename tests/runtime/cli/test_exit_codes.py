from importlib.machinery import EXTENSION_SUFFIXES

import pytest

from footprints_edge.cli.exit_codes import INTERRUPTED, MODEL_PROBLEM, SOME_FAILED, USAGE, explained
from footprints_edge.errors import ImageError, ModelError


@pytest.mark.parametrize(
    ("error", "code", "says"),
    [
        (ModelError("no such model"), MODEL_PROBLEM, "Error: no such model\n"),
        (ImageError("no such picture"), USAGE, "Error: no such picture\n"),
        (OSError("disk full"), USAGE, "Error: disk full\n"),
        (KeyboardInterrupt(), INTERRUPTED, ""),
        (
            ImportError("failed to map segment", path=f"/lib/x{EXTENSION_SUFFIXES[0]}"),
            SOME_FAILED,
            "Error: a library cannot be loaded: failed to map segment\n",
        ),
    ],
)
def test_errors_become_a_message_and_an_exit_code(error, code, says, capsys):
    with pytest.raises(SystemExit) as caught, explained():
        raise error
    assert caught.value.code == code
    assert capsys.readouterr().err == says


def test_a_missing_package_names_the_extra(capsys):
    with pytest.raises(SystemExit) as caught, explained("export"):
        import no_such_package  # noqa: F401
    assert caught.value.code == USAGE
    message = capsys.readouterr().err
    assert "no_such_package" in message
    assert "pip install '.[export]' in a checkout" in message


def test_a_missing_package_without_an_extra_is_a_bug():
    with pytest.raises(ModuleNotFoundError), explained():
        import no_such_package  # noqa: F401
