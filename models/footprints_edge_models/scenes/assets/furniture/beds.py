"""Beds."""

from footprints_edge_models.scenes.assets.furniture.legs import four_legs
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.models import or_model
from footprints_edge_models.scenes.assets.things import Thing, box, cushion, joined


@or_model(" bed ", " futon ", "day bed", "hospital bed", "iron bed", "child bed")
def bed(palette: Palette) -> Thing:
    """A bed; its head at +y."""
    rng = palette.rng
    wide, long_ = float(rng.choice([0.9, 1.0, 1.4, 1.6, 1.8])), float(rng.uniform(1.95, 2.1))
    frame = palette.main_wood()
    cover, sheet = palette.cloth(), palette.of("plaster", "fabric", "stripes", tile_m=0.5)
    lift = float(rng.choice([0.0, 0.1, 0.2]))
    z = lift + 0.22
    parts = [box(frame, (wide + 0.06, long_ + 0.04, 0.22), (0, 0, lift))]
    parts += four_legs(frame, wide, long_, lift + 0.01, 0.07, 0.0)
    parts.append(cushion(sheet, (wide, long_, 0.24), (0, 0, z), squareness=0.12))
    share = float(rng.uniform(0.6, 0.9))
    parts.append(
        cushion(
            cover,
            (wide + 0.1, long_ * share, 0.3),
            (0, -long_ * (1 - share) / 2, z - 0.03),
            squareness=0.15,
        )
    )
    for index in range(1 if wide < 1.2 else 2):
        x = 0.0 if wide < 1.2 else (index - 0.5) * wide * 0.5
        parts.append(
            cushion(
                sheet,
                (min(wide * 0.45, 0.7), 0.42, 0.15),
                (x, long_ * 0.37, z + 0.2),
                squareness=0.4,
            )
        )
        if rng.random() < 0.5:
            parts.append(
                cushion(
                    palette.cloth(),
                    (0.45, 0.2, 0.4),
                    (x, long_ * 0.27, z + 0.22),
                    lean=-0.5,
                    squareness=0.4,
                )
            )
    if rng.random() < 0.85:
        head = palette.cloth() if rng.random() < 0.3 else frame
        parts.append(
            box(head, (wide + 0.1, 0.06, rng.uniform(0.8, 1.25)), (0, long_ / 2 + 0.04, 0))
        )
    if rng.random() < 0.3:
        parts.append(
            box(frame, (wide + 0.1, 0.05, rng.uniform(0.4, 0.65)), (0, -long_ / 2 - 0.04, 0))
        )
    return joined("bed", parts)


def covered_bed(palette: Palette) -> Thing:
    """A bed that is closed down to the floor, its cover hanging over the sides; its head at +y."""
    rng = palette.rng
    wide, long_ = (
        float(rng.choice([0.95, 1.2, 1.45, 1.65, 1.85, 2.0])),
        float(rng.uniform(1.95, 2.1)),
    )
    top = float(rng.uniform(0.48, 0.66))
    cover, sheet = palette.cloth(), palette.of("plaster", "fabric", "plain", tile_m=0.5)
    base = palette.cloth() if rng.random() < 0.6 else palette.main_wood()
    share = float(rng.uniform(0.62, 0.97))
    hang = float(rng.uniform(0.08, top - 0.08))
    length, middle = long_ * share, -long_ * (1 - share) / 2
    parts = [
        box(base, (wide, long_, top - 0.18), (0, 0, 0)),
        cushion(sheet, (wide, long_, 0.22), (0, 0, top - 0.2), squareness=0.1),
        cushion(cover, (wide + 0.09, length + 0.05, 0.16), (0, middle, top - 0.1), squareness=0.12),
        box(cover, (wide + 0.08, 0.03, hang), (0, -long_ / 2 - 0.02, top - hang), 0, -0.05),
    ]
    pieces = int(rng.integers(3, 9))
    for sx in (-1, 1):
        for index in range(pieces):  # each fold hangs a little differently
            y = middle + ((index + 0.5) / pieces - 0.5) * length
            out, low = wide / 2 + rng.uniform(0.02, 0.05), top - hang + rng.uniform(-0.03, 0.03)
            parts.append(box(cover, (0.03, length / pieces + 0.01, top - low), (sx * out, y, low)))
    across = 1 if wide < 1.3 else 2
    for row in range(int(rng.integers(1, 3))):
        for index in range(across):
            x = (index - (across - 1) / 2) * wide * 0.5
            pillow = (min(wide * 0.48, 0.75), 0.2, 0.42) if row == 0 else (0.5, 0.18, 0.36)
            cloth = sheet if row == 0 else palette.cloth()
            at = (x, long_ / 2 - 0.17 - 0.22 * row, top - 0.02)
            parts.append(cushion(cloth, pillow, at, lean=-0.5, squareness=0.4))
    if rng.random() < 0.85:
        head = palette.cloth() if rng.random() < 0.3 else palette.main_wood()
        board = (wide + rng.uniform(0, 0.5), rng.uniform(0.04, 0.12), rng.uniform(0.8, 1.4))
        parts.append(box(head, board, (0, long_ / 2 + 0.06, 0)))
    return joined("bed", parts)
