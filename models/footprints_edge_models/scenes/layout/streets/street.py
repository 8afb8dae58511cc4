"""A street along y: road, kerbs, pavements, verges, and both roadsides."""

from footprints_edge_models.scenes.layout.scene import Standpoint
from footprints_edge_models.scenes.layout.streets.carriageway import drive_traffic, mark_lanes
from footprints_edge_models.scenes.layout.streets.roadside import (
    build_row,
    furnish_roadside,
    lay_yards,
    plant_edge,
)
from footprints_edge_models.scenes.layout.streets.site import REACH_M, Site, lay_side
from footprints_edge_models.scenes.layout.streets.surfaces import (
    pavement_surface,
    road_surface,
    verge_surface,
)


def lay_street(site: Site) -> tuple[list[Standpoint], list[float]]:
    """A street; returns where a camera may stand and which headings are likely, degrees."""
    palette = site.palette
    rng = palette.rng
    half = float(rng.uniform(1.8, 7.5))
    road = road_surface(palette)
    kerb_m = float(rng.uniform(0.08, 0.16)) if rng.random() < 0.85 else 0.0
    stone = palette.of("concrete", "paving", tile_m=1.0)
    has_verge = rng.random() < 0.25
    sides = []
    for side in (-1, 1):
        wide = float(rng.choice([0.0, rng.uniform(1.2, 4.5)], p=[0.15, 0.85]))
        yard = float(rng.choice([0.0, rng.uniform(2, 9)], p=[0.5, 0.5]))
        built = rng.random() < 0.8
        sides.append((side, wide, yard, built, rng.random() < 0.4))
    junction = rng.random() < 0.35
    crossing = (float(rng.uniform(4, 40)), float(rng.uniform(2.2, 4.0)))
    gap = (crossing[0] - crossing[1], crossing[0] + crossing[1]) if junction else (REACH_M, REACH_M)
    site.lay(-half, -REACH_M, half, REACH_M, 0.0, road)
    for side, wide, yard, built, low in sides:
        pavement, verge = pavement_surface(palette), verge_surface(palette)
        for start, end in ((-REACH_M, gap[0]), (gap[1], REACH_M)):
            if end - start < 0.1:
                continue
            inner = half
            if wide:
                lay_side(site, side, inner, inner + 0.15, start, end, kerb_m, stone)
                inner += 0.15
                if has_verge:
                    lay_side(site, side, inner, inner + 1.5, start, end, kerb_m, verge)
                    inner += 1.5
                lay_side(site, side, inner, inner + wide, start, end, kerb_m, pavement)
                inner += wide
            level = kerb_m if wide else 0.0
            lay_side(
                site,
                side,
                inner,
                REACH_M,
                start,
                end,
                level,
                verge if yard or not built else pavement,
            )
            line = inner + yard
            if built:
                build_row(site, side * line, side, max(start, -25), min(end, 80), low=low, z=level)
            else:
                plant_edge(site, side, line + 1.5, max(start, -20), min(end, 60), level)
            if yard:
                lay_yards(site, side, inner, line, max(start, -20), min(end, 50), level)
            furnish_roadside(site, side, half, wide, max(start, -20), min(end, 50), level)
        if junction:
            lay_side(site, side, half, REACH_M, gap[0], gap[1], 0.0, road)
    mark_lanes(site, half, gap, junction)
    drive_traffic(site, half)
    points = [Standpoint(-half, -12, half, 12, 2.0)]
    points += [
        Standpoint(
            side * (half + wide / 2) - wide / 2, -12, side * (half + wide / 2) + wide / 2, 12, 1.0
        )
        for side, wide, *_ in sides
        if wide > 1
    ]
    return points, [90.0, 90.0, 90.0, 90.0, 60.0, 120.0]
