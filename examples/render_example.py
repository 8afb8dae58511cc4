"""Path-traces the example photo `room.jpg`: a furnished room of our own making, in plain NumPy.

Run `python examples/render_example.py -o examples/room.jpg`; the result is the same every time.
Axes: x right, y up, z away from the camera, in metres. `E` is always irradiance over pi.
"""

import argparse
import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

F = NDArray[np.float32]
BOX, CYLINDER, ELLIPSOID, SOFT = range(4)
PLAIN, FLOOR, RUG, CLOTH, WOOD, ART = range(6)
F35 = 30  # focal length in 35 mm terms: 64.3 degrees across
EYE, YAW, PITCH = (0.5, 1.5, 0.0), -6.0, 12.0
SUN = np.array([-0.75, 0.62, 0.27]) / np.linalg.norm([-0.75, 0.62, 0.27])
SUN_E = np.array([12.0, 9.5, 6.7], np.float32)
AMBIENT = np.array([0.17, 0.155, 0.14], np.float32)  # stands for the bounces not followed
WINDOWS = (  # x, y0, y1, z0, z1, the side it shines to, share of samples in and beyond the room
    (-2.8, 0.55, 2.2, 3.3, 5.1, 1, 0.6, 0.07),
    (-0.7, 0.3, 2.25, 7.0, 9.4, 1, 0.06, 0.86),
    (2.8, 0.5, 2.3, -1.0, 1.9, -1, 0.34, 0.07),
)
LOOKS: dict[str, tuple[float, ...]] = {  # red, green, blue, texture, gloss
    "wall": (0.77, 0.735, 0.67, PLAIN, 0), "trim": (0.88, 0.87, 0.85, PLAIN, 0.3),
    "floor": (0.40, 0.235, 0.115, FLOOR, 1), "oak": (0.40, 0.235, 0.115, WOOD, 0.8),
    "walnut": (0.115, 0.06, 0.034, WOOD, 0.4), "black": (0.03, 0.03, 0.03, PLAIN, 0.4),
    "sofa": (0.20, 0.27, 0.29, CLOTH, 0), "rug": (0.60, 0.55, 0.47, RUG, 0),
    "ochre": (0.56, 0.31, 0.07, CLOTH, 0), "linen": (0.74, 0.70, 0.62, CLOTH, 0),
    "rust": (0.36, 0.14, 0.08, CLOTH, 0), "clay": (0.56, 0.30, 0.19, CLOTH, 0),
    "cream": (0.73, 0.70, 0.65, PLAIN, 1), "slate": (0.12, 0.19, 0.24, PLAIN, 0.6),
    "orange": (0.75, 0.30, 0.03, PLAIN, 0.6), "stem": (0.12, 0.13, 0.05, PLAIN, 0),
    "print1": (-1.22, 0, 0, ART, 0.5), "print2": (-0.3, 0, 0, ART, 0.5),
    "print3": (-0.3, 0, 0, ART, 0.4),
}  # fmt: skip
CHAIR = """soft walnut -.21 .21 .44 .475 -.2 .22 .015; rodX walnut .21 0 .22 .17 .45 .17 .017
rodX walnut .21 0 -.24 .18 .45 -.17 .018; rodX walnut .18 .44 -.18 .19 .84 -.27 .016
slab walnut 0 .63 -.222 .19 .03 .011 .01 0 -12.5
slab walnut 0 .79 -.258 .19 .03 .011 .01 0 -12.5"""
# at: x, z, heading of what follows. box and soft: extents along x, y, z, rounding. ball, tube and
# slab: centre, half extents, rounding, yaw, pitch, roll. rod: ends, radius. X, Z: mirrored too.
ROOM = f"""
at 0 0; box floor -3 4 -.1 0 -2 11; box trim -3 4 2.6 2.7 -2 6.1; box trim -.9 4 2.6 2.7 6.1 11
box wall -3 2.8 0 2.6 -1.7 -1.6; box wall -2.9 .72 0 2.6 6 6.12; box wall 1.68 3.6 0 2.6 6 6.12
box wall .72 1.68 2.08 2.6 6 6.12; at 0 0; box trim -2.7 .64 0 .095 5.984 6
box trim 1.76 2.7 0 .095 5.984 6; box trim -.6 3.4 0 .095 10.384 10.4
box trim -2.7 -2.684 0 .095 -1.6 6; box trim 2.684 2.7 0 .095 -1.6 6
box trim 3.384 3.4 0 .095 6 10.4; at 0 0; box wall 3.4 3.6 0 2.6 6 11
box wall -1.5 3.6 0 2.6 10.4 10.6; at 1.2 6.06; boxXZ trim .465 .56 0 2.15 .06 .08
boxZ trim -.56 .56 2.065 2.16 .06 .08; box walnut -.465 .465 0 .008 -.07 .07
box trim .63 .71 1.06 1.14 -.072 -.06
at -.72 5.5; soft sofa -1 1 .12 .32 -.42 .42 .04; soft sofa -.95 .95 .25 .8 .24 .44 .07
softX sofa .86 1.07 .12 .6 -.44 .44 .07; softX sofa .005 .86 .28 .47 -.47 .28 .06
slabX sofa .43 .66 .2 .42 .23 .1 .09 0 12; rodXZ walnut .92 0 .36 .9 .14 .36 .02
slab ochre -.62 .645 .03 .2 .19 .07 .068 14 24 14; slab linen .6 .645 .03 .2 .19 .07 .068 -16 24 -9
slab rust .32 .645 -.07 .2 .19 .07 .068 -4 24 11
at -.62 4.1; box rug -1.15 1.15 0 .014 -.8 .85
at -.6 4.15 4; soft oak -.52 .52 .385 .42 -.3 .3 .015; rodXZ oak .47 0 .26 .43 .39 .22 .019
box slate -.35 -.08 .42 .445 -.15 .05; box cream -.33 -.11 .445 .462 -.13 .03
tube cream .22 .465 .03 .04 .045 .04
at 0 0; box walnut -1.55 -.89 1.17 2.03 5.97 6; box print1 -1.525 -.915 1.195 2.005 5.966 5.99
box black -.63 .03 1.17 2.03 5.97 6; box print2 -.605 .005 1.195 2.005 5.966 5.99
at .5 5.66; tube black 0 .012 0 .13 .012 .13; rod black 0 0 0 0 1.5 0 .011
tube linen 0 1.55 0 .17 .14 .17
at 1.72 3.95 -3; soft oak -.52 .52 .705 .74 -.42 .42 .012; box oak -.44 .44 .645 .705 -.34 .34
rodXZ oak .47 0 .37 .44 .71 .34 .024; ball cream 0 .775 .02 .15 .04 .15
ball orange -.05 .825 0 .038 .038 .038; ball orange .05 .825 -.02 .038 .038 .038
ball ochre 0 .825 .07 .038 .038 .038; ball orange .02 .855 .03 .038 .038 .038
at 1.5 3.2 14; {CHAIR}; at 1.6 4.72 172; {CHAIR}
at 1.9 10.15; box oak -.75 .7 .16 .82 -.2 .23; box black -.04 -.02 .2 .78 -.21 -.19
rodX black .62 0 0 .62 .2 0 .02; ball slate -.45 .95 0 .1 .15 .1
box black -.6 .2 1.25 1.85 .22 .25; box print3 -.57 .17 1.28 1.82 .215 .24
at 2.3 5.83; boxX walnut .34 .36 0 1.86 -.15 .15; box walnut -.34 .34 0 1.86 .14 .15
ball cream .22 1.26 0 .08 .11 .08
at -2.2 5.25; tube clay 0 .16 0 .15 .16 .15; tube black 0 .3 0 .135 .023 .135"""


def turn(yaw: float, pitch: float = 0.0, roll: float = 0.0) -> NDArray[np.float64]:
    """Rotation by yaw about y, then pitch about x, then roll about z, in degrees."""
    (a, b, c), (s, t, u) = np.cos(r := np.radians([yaw, pitch, roll])), np.sin(r)
    about_y = np.array([[a, 0, s], [0, 1, 0], [-s, 0, a]])
    about_x = np.array([[1, 0, 0], [0, b, -t], [0, t, b]])
    return about_y @ about_x @ np.array([[c, -u, 0], [u, c, 0], [0, 0, 1]])


def high(a: F) -> F:
    """Largest of the three rows."""
    return np.maximum(np.maximum(a[0], a[1]), a[2])


def low(a: F) -> F:
    """Smallest of the three rows."""
    return np.minimum(np.minimum(a[0], a[1]), a[2])


def dot(a: F, b: F) -> F:
    """Sum of products along the first axis."""
    return np.einsum("i...,i...->...", a, b)


class Scene:
    """Solids in groups; a group is skipped for the rays that miss its bounding box."""

    def __init__(self) -> None:
        solids: list[tuple[int, F, F, F, tuple[float, ...], float]] = []
        self.groups: list[list[int]] = []
        for entry in (ROOM + self.extras()).strip().replace("\n", ";").split(";"):
            word, *rest = entry.split()
            if word == "at":
                x, z, *yaw = map(float, rest)
                origin, frame = np.array([x, 0, z]), turn(*yaw or [0.0])
                self.groups.append([])
                continue
            v, name = np.array([float(a) for a in rest[1:]]), word.rstrip("XZ")
            mirror = [(1, -1) if axis in word else (1,) for axis in "XYZ"]
            for flip in itertools.product(*mirror):
                c, half, spin, r = v[:3] * flip, v[3:6], np.eye(3), 0.0
                if name == "rod":
                    along, c = (v[3:6] - v[:3]) * flip, (v[3:6] + v[:3]) / 2 * flip
                    y = along / (n := np.linalg.norm(along))
                    x = np.cross(y, [0, 0, 1] if abs(y[2]) < 0.9 else [1, 0, 0])
                    x = x / np.linalg.norm(x)
                    spin, half = np.stack([x, y, np.cross(x, y)], 1), np.array([v[6], n / 2, v[6]])
                elif name in ("box", "soft"):
                    c, half = (v[:6:2] + v[1:6:2]) / 2 * flip, (v[1:6:2] - v[:6:2]) / 2
                else:
                    spin = turn(*v[7:]) if v.size > 7 else spin
                if name in ("slab", "soft"):
                    r = float(v[6])
                self.groups[-1].append(len(solids))
                kind = {"box": BOX, "ball": ELLIPSOID, "tube": CYLINDER, "rod": CYLINDER}
                centre, spin = origin + frame @ c, frame @ spin
                solids.append((kind.get(name, SOFT), centre, half, spin, LOOKS[rest[0]], r))
        kinds, *tables = (list(column) for column in zip(*solids, strict=True))
        self.kinds = np.array(kinds)
        self.C, self.Hf, self.R, self.looks, self.round = (np.array(a, np.float32) for a in tables)
        ext = np.einsum("kij,kj->ki", np.abs(self.R), self.Hf) + 1e-4
        self.straight = [bool(np.allclose(r, np.eye(3))) for r in self.R]
        lo, hi = self.C - ext, self.C + ext
        self.bounds = [(lo[g].min(0)[:, None], hi[g].max(0)[:, None]) for g in self.groups]

    def extras(self) -> str:
        """The repetitive rest of the table: leaves, shelves of books, windows and curtains."""
        rng, out = np.random.default_rng(4), ""
        for j in range(30):
            high, reach = 0.48 + 0.03 * j, 0.34 - 0.0078 * j + rng.uniform(-0.04, 0.04)
            x, y, z = turn(j * 137.5) @ np.array([0, high, reach])
            if j % 3 == 0:
                out += f"\nrod stem 0 .3 0 {x * 0.7} {y - 0.03} {z * 0.7} .006"
            a, b, c = rng.uniform((-20, -45, -25), (20, 35, 25))
            tone = rng.uniform(0.8, 1.25)
            LOOKS[f"leaf{j}"] = (0.055 * tone, 0.135 * tone, 0.035, PLAIN, 0.8)
            out += f"\nball leaf{j} {x} {y} {z} .07 .008 .16 0 {a + j * 137.5} {b} {c}"
        for y in (0.06, 0.43, 0.79, 1.15, 1.51, 1.84):
            out += f"\nat 2.3 5.83; box walnut -.34 .34 {y - 0.02} {y} -.15 .14"
            x, stop = -0.335, rng.uniform(0.0, 0.28)
            while y < 1.6 and x < stop:
                w, h, d = rng.uniform((0.018, 0.19, -0.12), (0.05, 0.28, -0.08))
                cover = rng.choice(["rust", "slate", "linen", "leaf3", "ochre", "black", "wall"])
                out += f"\nbox {cover} {x} {x + w - 0.002} {y} {y + h} {d} .1"
                x += w
        ends = ((-1.7, 6.12), (6.1, 10.6), (-1.7, 6.0))
        for (x, y0, y1, z0, z1, side, *_), (a, b) in zip(WINDOWS, ends, strict=True):
            out += f"\nat {x} 0; box wall -.1 .1 0 2.6 {a} {z0}; box wall -.1 .1 0 2.6 {z1} {b}"
            out += (
                f"\nbox wall -.1 .1 0 {y0} {z0} {z1}; box wall -.1 .1 {y1} 2.6 {z0} {z1}\nat {x} 0"
            )
            out += f"\nbox trim -.1 {0.1 + 0.1 * side} {y0 - 0.03} {y0} {z0 - 0.06} {z1 + 0.06}"
            for z in (z0, (z0 + z1) / 2 - 0.03, z1 - 0.06):
                out += f"\nbox trim -.05 0 {y0} {y1} {z} {z + 0.06}"
            for y in (y0, y0 + 0.62 * (y1 - y0), y1 - 0.06):
                out += f"\nbox trim -.05 0 {y} {y + 0.06} {z0} {z1}"
        for j in range(16):
            z, r = 2.72 + 0.065 * j + 1.84 * (j > 7), 0.034 + 0.008 * (j * 7 % 3)
            out += "\nat 0 0" * (j % 8 == 0)
            out += f"\ntube linen {-2.61 + 0.022 * (j % 2)} 1.21 {z} {r} 1.19 {r}"
        return out

    def solve(self, k: int, o: F, d: F, m: F, am: F) -> F:
        """Distance along each ray to solid `k`, infinite where it is missed."""
        c, h = self.C[k][:, None], self.Hf[k][:, None]
        if not self.straight[k]:
            o, d, c = self.R[k].T @ (o - c), self.R[k].T @ d, np.zeros((3, 1), np.float32)
        if self.kinds[k] in (BOX, SOFT):
            if not self.straight[k]:
                m = 1 / np.where(np.abs(d) < 1e-7, np.float32(1e-7), d)
                am = np.abs(m)
            a, e = (c - o) * m, h * am
            near, far = high(a - e), low(a + e)
            hit = (near <= far) & (far > 0)
            if self.kinds[k] == BOX:
                return np.where(hit & (near > 0), near, np.inf)
            out, i = np.full(o.shape[1], np.inf, np.float32), np.flatnonzero(hit)
            p, v, t = (o - c)[:, i], d[:, i], np.maximum(near[i], 0)
            for _ in range(18):
                q = np.maximum(np.abs(p + t * v) - (h - self.round[k]), 0)
                t += (s := np.sqrt(dot(q, q)) - self.round[k])
            out[i] = np.where((s < 8e-4) & (t < far[i]), t, np.inf)
            return out
        o, d = (o - c) / h, d / h
        w = slice(0, 3, 2 if self.kinds[k] == CYLINDER else 1)
        a, b = dot(d[w], d[w]) + np.float32(1e-12), dot(o[w], d[w])
        disc = b * b - a * (dot(o[w], o[w]) - 1)
        t = np.where(disc > 0, (-b - np.sqrt(np.maximum(disc, 0))) / a, np.inf)
        if self.kinds[k] == CYLINDER:
            dy = np.where(np.abs(d[1]) < 1e-7, np.float32(1e-7), d[1])
            cap = (-np.sign(dy) - o[1]) / dy
            e = o[w] + cap * d[w]
            inside = dot(e, e) <= 1
            with np.errstate(invalid="ignore"):
                side = np.abs(o[1] + t * d[1]) <= 1
            t = np.where(side, t, np.where(inside, cap, np.inf))
        return t

    def trace(
        self, o: F, d: F, limit: F | float = np.inf, shadow: bool = False
    ) -> tuple[F, NDArray[np.intp]]:
        """Nearest (for a shadow any) hit before `limit`: its distance and solid, -1 for none."""
        t = np.broadcast_to(np.float32(limit), o.shape[1:]).copy()
        hit = np.full(o.shape[1], -1)
        m = 1 / np.where(np.abs(d) < 1e-7, np.float32(1e-7), d)
        am = np.abs(m)
        for members, (lo, hi) in zip(self.groups, self.bounds, strict=True):
            a, b = (lo - o) * m, (hi - o) * m
            near, far = high(np.minimum(a, b)), low(np.maximum(a, b))
            i = np.flatnonzero((near < t) & (far > np.maximum(near, 0)))
            og, dg, mg, ag, tg, hg = o[:, i], d[:, i], m[:, i], am[:, i], t[i], hit[i]
            for k in members if i.size else ():
                s = self.solve(k, og, dg, mg, ag)
                better = (s > 1e-4) & (s < tg)
                tg[better], hg[better] = 0 if shadow else s[better], k
            t[i], hit[i] = tg, hg
        return t, hit

    def normal(self, p: F, k: NDArray[np.intp]) -> F:
        """Outward unit normals at points `p` on solids `k`."""
        R, h, r = self.R[k], self.Hf[k].T, self.round[k]
        q = np.einsum("nij,in->jn", R, p - self.C[k].T)
        u, kind = q / h, self.kinds[k]
        box = np.where(np.abs(u) >= high(np.abs(u)), np.sign(u), 0)
        cap = np.abs(u[1]) > np.hypot(u[0], u[2])
        tube = np.where(cap, np.sign(u) * [[0], [1], [0]], u / h * [[1], [0], [1]])
        soft = np.sign(q) * np.maximum(np.abs(q) - (h - r), 0)
        n = np.choose(kind, [box, tube, u / h, soft])
        n = np.einsum("nij,jn->in", R, n)
        return (n / (np.sqrt(dot(n, n)) + 1e-9)).astype(np.float32)


def lattice(x: NDArray[np.int64], y: NDArray[np.int64]) -> F:
    """A fixed random number in 0..1 for each pair of integers."""
    h = (x * 374761393 + y * 668265263 + 1013904223) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return (((h ^ (h >> 16)) & 0xFFFFFF) / np.float32(1 << 24)).astype(np.float32)


def noise(x: F, y: F) -> F:
    """Smooth value noise in 0..1 over the plane."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    u, v = ((w := f - k) * w * (3 - 2 * w) for f, k in ((x, i), (y, j)))
    low = lattice(i, j) * (1 - u) + lattice(i + 1, j) * u
    return low * (1 - v) + (lattice(i, j + 1) * (1 - u) + lattice(i + 1, j + 1) * u) * v


def grain(x: F, y: F, foot: F) -> F:
    """Wood figure about 0, `y` running along the grain; fades where a pixel is too wide."""
    warp = noise(x * 7, y * 0.8)
    rings = np.sin(x * 130 + 22 * warp) / (1 + (foot * 40) ** 2)
    fibre = (noise(x * 260, y * 7) - 0.5) / (1 + (foot * 180) ** 2)
    pores = (noise(x * 600, y * 18) - 0.5) / (1 + (foot * 400) ** 2)
    return 0.07 * rings + 0.22 * fibre + 0.2 * pores + 0.35 * (noise(x * 24, y * 1.1) - 0.5)


def floor_look(p: F, c: F, foot: F) -> F:
    """Oak planks along z, each with its own tone and figure, and dark seams between them."""
    wide, length = 0.15, 1.7
    i = np.floor(p[0] / wide).astype(np.int64)
    z = p[2] / length + lattice(i, i * 0 + 7)
    j = np.floor(z).astype(np.int64)
    tone, other = lattice(i, j), lattice(i + 91, j - 37)
    figure = grain(p[0] + 9 * other, p[2] + 31 * tone, foot)
    side = np.minimum(p[0] - i * wide, (i + 1) * wide - p[0])
    end = np.minimum(z - j, j + 1 - z) * length
    seam = sum(
        np.clip((w + foot - e) / (2 * foot), 0, 1) * np.minimum(1, w / foot)
        for e, w in ((side, 0.0018), (end, 0.0015))
    )
    hue = np.stack([tone * 0 + 1, 0.96 + 0.1 * other, 0.88 + 0.26 * other])
    return c * hue * (0.76 + 0.44 * tone) * (1 + figure) * (1 - 0.72 * np.minimum(seam, 1))


def rug_look(p: F, c: F, foot: F) -> F:
    """Woven wool with a lattice of dark diamonds and a plain border."""
    x, z = p[0] + 0.62, p[2] - 4.125
    u, v = (x + 0.62 * z) / 0.34, (x - 0.62 * z) / 0.34
    line = np.minimum(np.abs(u - np.round(u)), np.abs(v - np.round(v))) * 0.25
    line += 0.006 * (noise(p[0] * 90, p[2] * 90) - 0.5)
    field = (np.abs(x) < 1.06) & (np.abs(z) < 0.74)
    dark = np.where(field, np.clip((0.011 - line) / 0.006, 0, 1), 0)
    pile = noise(p[0] * 170, p[2] * 110) / (1 + (foot * 90) ** 2) + 0.6 * noise(p[0] * 9, p[2] * 9)
    return c * (0.80 + 0.25 * pile) * (1 - dark * np.array([[0.72], [0.68], [0.62]]))


def cloth_look(p: F, c: F, foot: F) -> F:
    """Coarse weave."""
    u, v = p[0] + 0.6 * p[2], p[1] - 0.8 * p[2]
    weave = noise(u * 320, v * 320) / (1 + (foot * 160) ** 2)
    return c * (0.84 + 0.24 * weave + 0.1 * noise(u * 14, v * 14))


def wood_look(p: F, c: F, foot: F) -> F:
    """Furniture wood with its grain along x."""
    return c * (1 + 1.1 * grain(p[2] + p[1] * 0.7, p[0] + p[1], foot))


def art_look(p: F, c: F, _: F) -> F:
    """A print in a white mount: bands of hills under a low sun; `c` holds its centre."""
    x, y = p[0] - c[0] - np.where(p[2] > 9, 2.0, 0), p[1] - 1.6
    out = np.broadcast_to(np.array([[0.72], [0.62], [0.50]]), p.shape).copy()
    sun = np.hypot(x - 0.06 * np.sign(c[0] + 0.8), y - 0.1) < 0.075
    out[:, sun] = np.array([[0.62], [0.22], [0.08]])
    for k, tone in enumerate(((0.40, 0.42, 0.40), (0.20, 0.29, 0.31), (0.08, 0.15, 0.18))):
        ridge = 0.05 - 0.1 * k + 0.16 * (noise(x * 6 + 9 * k + 5 * c[0], x * 0 + k) - 0.5)
        out[:, y < ridge] = np.array(tone)[:, None]
    mount = np.maximum(np.abs(x) - 0.2, np.abs(y) - 0.3) > 0
    return np.where(mount & (p[2] < 9), np.array([[0.78], [0.77], [0.74]]), out)


TEXTURES: dict[int, Callable[[F, F, F], F]] = {
    FLOOR: floor_look, RUG: rug_look, CLOTH: cloth_look, WOOD: wood_look, ART: art_look
}  # fmt: skip


def sky(d: F) -> F:
    """Radiance from outside: bright haze over blurred greenery."""
    y = d[1] + 0.1 * (noise(d[2] * 9 + 3, d[1] * 9) - 0.5)
    up = np.clip((y - 0.02) / 0.1, 0, 1)
    blue = np.clip(d[1], 0, 1)
    haze = np.stack([7.6 - 2.4 * blue, 8.0 - 1.4 * blue, 8.4 + 0.4 * blue])
    leaf = 0.55 + 0.9 * noise(d[2] * 24, d[1] * 24)
    green = np.array([[1.5], [1.75], [1.05]]) * leaf
    return (green * (1 - up) + haze * up).astype(np.float32)


def window_light(s: Scene, p: F, n: F, u: F) -> F:
    """E from one random spot of one of the windows."""
    table = np.array(WINDOWS, np.float32)
    share = np.where(p[2] < 6.06, table[:, 6:7], table[:, 7:8])
    k = (u[2] > share[0]).astype(int) + (u[2] > share[0] + share[1])
    x, y0, y1, z0, z1, side = table[k, :6].T
    v = np.stack([x + 0.1 * side, y0 + u[0] * (y1 - y0), z0 + u[1] * (z1 - z0)]) - p
    dist = np.sqrt(dot(v, v))
    v /= dist
    cos = np.maximum(dot(v, n), 0) * np.maximum(-v[0] * side, 0)
    area = (y1 - y0) * (z1 - z0) / np.take_along_axis(share, k[None], 0)[0]
    g = np.minimum(cos * area / (np.pi * dist * dist), 2.0).astype(np.float32)
    out, i = np.zeros_like(p), np.flatnonzero(g > 1e-5)
    _, hit = s.trace(p[:, i], v[:, i], dist[i] + 0.35, True)
    out[:, i] = np.where(hit < 0, sky(v[:, i]) * g[i], 0)
    return out


def sun_light(s: Scene, p: F, n: F, u: F) -> F:
    """E from a random spot of the sun's slightly widened disc."""
    r, a = 0.008 * np.sqrt(u[0]), 2 * np.pi * u[1]
    d = SUN[:, None] + r * np.stack([np.cos(a) * 0.6, np.sin(a), np.cos(a)])
    d = (d / np.sqrt(dot(d, d))).astype(np.float32)
    cos, seen = dot(d, n), np.zeros(p.shape[1], bool)
    for x, y0, y1, z0, z1, *_ in WINDOWS[:2]:  # the two on the sunny side
        q = p + (x - p[0]) / d[0] * d
        seen |= (p[0] < x) | ((q[1] > y0) & (q[1] < y1) & (q[2] > z0) & (q[2] < z1))
    out, i = np.zeros_like(p), np.flatnonzero(seen & (cos > 0))
    _, hit = s.trace(p[:, i], d[:, i], shadow=True)
    out[:, i] = np.where(hit < 0, SUN_E[:, None] * cos[i] / np.pi, 0)
    return out


def surface(s: Scene, o: F, d: F) -> tuple[F, F, F, NDArray[np.intp], F]:
    """What rays meet: point off the surface, normal, mean colour, solid (-1: none), distance."""
    t, k = s.trace(o, d)
    p = o + np.where(k < 0, 0, t) * d
    n = s.normal(p, k)
    return p + 2e-3 * n, n, s.looks[k, :3].T * (s.looks[k, 3] != ART) * (k >= 0), k, t


def around(n: F, u: F) -> F:
    """Cosine-distributed directions about normals."""
    z, a = 1 - 2 * u[0] * 0.9999, 2 * np.pi * u[1]
    d = n + np.sqrt(1 - z * z) * np.stack([np.cos(a), np.sin(a), z * 0]) + [[0], [0], [1]] * z
    return (d / np.sqrt(dot(d, d))).astype(np.float32)


def samples(rng: np.random.Generator, count: int, wide: int) -> Callable[[int], F]:
    """Per-pixel shifted low-discrepancy triples: a function of the sample's number."""
    shift, g = rng.random((count, 3, wide), np.float32), 1.22074408
    step = np.array([1 / g, 1 / g**2, 1 / g**3])[None, :, None]
    return lambda i: ((shift + step * i) % 1).astype(np.float32)


def render_strip(s: Scene, d: F, foot: float, numbers: range, seed: int) -> tuple[F, ...]:
    """Albedo, normal, point, soft light E, sun E and gloss seen along the rays `d`."""
    o = np.repeat(np.array(EYE, np.float32)[:, None], d.shape[1], 1)
    p, n, albedo, k, t = surface(s, o, d)
    look, out = s.looks[k], k < 0
    foot_here = np.where(out, 1, t * foot / np.sqrt(np.maximum(-dot(n, d), 0.15))) * 0.7
    for tex, paint in TEXTURES.items():
        i = np.flatnonzero((look[:, 3] == tex) & ~out)
        albedo[:, i] = paint(p[:, i], look[i, :3].T, foot_here[i])
    soft, sun, gloss = np.zeros_like(p), np.zeros_like(p), np.zeros_like(p)
    shiny = np.flatnonzero((look[:, 4] > 0) & ~out)
    draw = samples(np.random.default_rng(seed), 8, d.shape[1])
    for number in numbers:
        u = draw(number)
        soft += window_light(s, p, n, u[0])
        sun += sun_light(s, p, n, u[1])
        q, m, through = p, n, np.ones_like(p)
        for bounce in range(1 + number % 2):
            q, m, c, _, _ = surface(s, q, around(m, u[2 + 2 * bounce]))
            through = through * c
            w = u[3 + 2 * bounce]
            light = window_light(s, q, m, w) + sun_light(s, q, m, w[[2, 0, 1]])
            soft += through * np.minimum(light + AMBIENT[:, None] * bounce, 6) * (1 + bounce)
        r, ns, us = d[:, shiny], n[:, shiny], u[6][:, shiny]
        rough = ns + 0.09 * (us - 0.5) / (0.4 + look[shiny, 4])
        rough /= np.sqrt(dot(rough, rough))
        r = r - 2 * dot(r, rough) * rough
        q, m, c, hit, _ = surface(s, p[:, shiny], r)
        w = u[7][:, shiny]
        light = c * (window_light(s, q, m, w) + sun_light(s, q, m, us) + 1.6 * AMBIENT[:, None])
        light = np.where(hit < 0, np.minimum(sky(r), 6), np.minimum(light, 6))
        fresnel = 0.035 + 0.6 * (1 - np.clip(dot(r, ns), 0, 1)) ** 5
        gloss[:, shiny] += light * fresnel * look[shiny, 4]
    albedo[:, out], n[:, out] = 1, 0
    scale = 1 / len(numbers)
    soft, sun, gloss = soft * scale, sun * scale, gloss * scale
    soft[:, out] = sky(d[:, out])
    return albedo, n, np.where(out, 50 * d, p), soft, sun * ~out, gloss


def smooth(e: F, n: F, p: F, foot: float, levels: int) -> F:
    """Edge-aware a-trous filter of light `e` (rows, columns, 3) along flat surfaces."""
    h, w = e.shape[:2]
    depth = np.linalg.norm(p - np.array(EYE), axis=2)
    taps = (0.375, 0.25, 0.0625)
    for level in range(levels):
        step = 2**level
        pad = [(2 * step, 2 * step)] * 2 + [(0, 0)]
        en, nn, pn = (np.pad(a, pad, "edge") for a in (e, n, p))
        bright = np.pad(smear(e[..., 0] + e[..., 1] + e[..., 2]), pad[:2], "edge")
        b0 = bright[2 * step : 2 * step + h, 2 * step : 2 * step + w]
        total, weight = np.zeros_like(e), np.zeros((h, w), np.float32)
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                y, x = (2 + dy) * step, (2 + dx) * step
                cut = np.s_[y : y + h, x : x + w]
                off = np.abs(inner(pn[cut] - p, n)) / (depth * foot * step * 1.5 + 2e-3)
                like = np.maximum(inner(nn[cut], n), 0) ** 32
                tone = np.abs(bright[cut] - b0) / (0.8 * 0.6**level * (b0 + 0.02))
                k = taps[abs(dx)] * taps[abs(dy)] * like * np.exp(-off - tone)
                total += en[cut] * k[..., None]
                weight += k
        e = np.where(weight[..., None] > 1e-6, total / np.maximum(weight, 1e-6)[..., None], e)
    return e


def inner(a: F, b: F) -> F:
    """Sum of products along the last axis."""
    return np.einsum("...i,...i->...", a, b)


def smear(a: F) -> F:
    """3 x 3 mean of a plane."""
    q = np.pad(a, 1, "edge")
    q = q[:-2] + q[1:-1] + q[2:]
    return (q[:, :-2] + q[:, 1:-1] + q[:, 2:]) / 9


def develop(image: F) -> NDArray[np.uint8]:
    """Film curve, vignette, grain and 8-bit coding."""
    h, w = image.shape[:2]
    yy, xx = np.mgrid[:h, :w]
    r2 = ((xx - w / 2) ** 2 + (yy - h / 2) ** 2) / (w * w / 4 + h * h / 4)
    fy, fx = np.fft.fftfreq(h)[:, None], np.fft.rfftfreq(w)[None]
    glow = np.exp(-2 * (np.pi * 0.018 * w) ** 2 * (fx**2 + fy**2))[..., None]
    veil = np.fft.irfft2(np.fft.rfft2(image, axes=(0, 1)) * glow, (h, w), axes=(0, 1))
    x = (0.955 * image + 0.045 * veil) * (1 - 0.24 * r2)[..., None] * np.array([1.0, 1.0, 1.02])
    x = np.clip(x, 0, None)
    code = 1.0 - np.exp(-1.35 * x**1.08)
    code = np.where(code < 0.0031308, 12.92 * code, 1.055 * code ** (1 / 2.4) - 0.055)
    code = code + 0.15 * (code - 0.5) * (1 - (2 * code - 1) ** 2)
    rng = np.random.default_rng(5)
    speck = rng.normal(0, 1, (h, w, 1)) + 0.5 * rng.normal(0, 1, (h, w, 3))
    code += speck * 0.0055 * (1.2 - code)
    return (np.clip(code, 0, 1) * 255 + 0.5).astype(np.uint8)


def render(height: int, width: int, count: int) -> NDArray[np.uint8]:
    """The photo, `count` light samples a pixel over four shifted frames."""
    s = Scene()
    f = F35 * np.hypot(width, height) / np.hypot(36, 24)
    view, each = turn(YAW, PITCH), max(2, count // 4)
    frames, rows = [], max(1, 120000 // width)
    for frame, (sx, sy) in enumerate(((0.37, 0.13), (0.87, 0.37), (0.13, 0.63), (0.63, 0.87))):
        parts = []
        for top in range(0, height, rows):
            yy, xx = np.mgrid[top : min(top + rows, height), :width].astype(np.float32)
            d = np.stack([xx + sx - width / 2, height / 2 - yy - sy, np.full_like(xx, f)])
            d = (view @ d.reshape(3, -1)).astype(np.float32)
            d /= np.sqrt(dot(d, d))
            parts.append(render_strip(s, d, 1 / f, range(frame * each, (frame + 1) * each), top))
        planes = [np.concatenate(a, 1).T for a in zip(*parts, strict=True)]
        frames.append([a.reshape(height, width, 3).astype(np.float32) for a in planes])
    result = np.zeros((height, width, 3), np.float32)
    for albedo, n, p, _, sharp, _ in frames:
        near = 2 / f * np.linalg.norm(p - np.array(EYE, np.float32), axis=2) + 2e-3
        same = [(inner(o[1], n) > 0.9) & (np.abs(inner(o[2] - p, n)) < near) for o in frames]
        same = [np.where(inner(n, n) > 0.5, w, 0.25)[..., None] for w in same]
        soft, gloss = (
            sum(w * o[i] for w, o in zip(same, frames, strict=True)) / sum(same) for i in (3, 5)
        )
        soft = smooth(soft, n, p, 1 / f, 4)
        gloss = smooth(gloss, n, p, 1 / f, 2)
        sun = smooth(sharp, n, p, 1 / f, 1)
        result += np.minimum(albedo * (soft + sun) + gloss, 5) / 4
    bright = inner(result, np.ones(3, np.float32)) + 1e-6
    beside = (9 * smear(bright) - bright) / 8  # no single pixel may outshine its neighbours
    result *= np.minimum(1, 2 * beside / bright)[..., None]
    return develop(result * 1.25)


def main() -> None:
    """Renders and saves the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path(__file__).with_name("room.jpg"))
    parser.add_argument("--size", default="720x1280", help="HEIGHTxWIDTH")
    parser.add_argument("--samples", type=int, default=24, help="light samples a pixel")
    args = parser.parse_args()
    height, width = (int(v) for v in args.size.split("x"))
    photo = Image.fromarray(render(height, width, args.samples))
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA405] = F35
    photo.save(args.output, quality=88, exif=exif)


if __name__ == "__main__":
    main()
