"""What a picture of a result says about itself, in a line below."""

from PIL import Image, ImageDraw, ImageFont

from footprints_edge.drawing.style import FAINT, PAPER
from footprints_edge.geometry.camera import ASSUMED_FOV_DEG, IntrinsicsSource


def lens_note(source: IntrinsicsSource) -> str:
    """What a picture says about its camera: nothing if it is known."""
    if source == "assumed":
        return f"lens assumed: {ASSUMED_FOV_DEG:g} degrees; all metres depend on it"
    return "rectified picture" if source == "rectified" else ""


def picture_note(source: IntrinsicsSource, *, shows_ground: bool) -> str:
    """What the legend says: `lens_note`, or that there is no ground."""
    return lens_note(source) if shows_ground else "no ground found"


def with_note(picture: Image.Image, note: str) -> Image.Image:
    """The picture with a line of text below; the picture itself if there is none."""
    if not note:
        return picture
    letter = max(10, round(min(picture.width / 48, picture.height / 30)))
    noted = Image.new("RGB", (picture.width, picture.height + round(1.9 * letter)), PAPER)
    noted.paste(picture, (0, 0))
    ImageDraw.Draw(noted).text(
        (letter, picture.height + 0.9 * letter),
        note,
        FAINT,
        ImageFont.load_default(letter),
        anchor="lm",
    )
    return noted
