import pytest

from footprints_edge.foundation.addresses import is_address, without_password


@pytest.mark.parametrize(
    ("named", "shown"),
    [
        (
            "rtsp://viewer:hun@ter22@127.0.0.1:9/live?token=abc&x=1",
            "rtsp://***@127.0.0.1:9/live?token=***&x=1",
        ),
        ("http:/me:hunter22@host/a.jpg", "http://***@host/a.jpg"),  # as a path spells it
        ("rtsp://127.0.0.1/live", "rtsp://127.0.0.1/live"),
        (
            "https://host/a.onnx?X-Amz-Signature=ab&x=1",
            "https://host/a.onnx?X-Amz-Signature=***&x=1",
        ),
        ("https://host/img@2x.png", "https://***@2x.png"),  # a password may hold a slash
        ("a@b.mp4", "a@b.mp4"),
        ("12:30:05@b.mp4", "12:30:05@b.mp4"),
    ],
)
def test_a_password_is_not_shown(named, shown):
    assert without_password(named) == shown


def test_a_drive_and_a_time_are_no_addresses():
    assert not any(map(is_address, ["C:/a.jpg", "12:30:05.mp4", "a/b:c.jpg", "-"]))
    assert is_address("https://host/a.jpg")
