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
