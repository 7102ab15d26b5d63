#!/usr/bin/env python3
"""Makes the few meshes of scenes/ that no analytic shape gives (they are kept there; run by hand to make them again).

    scripts/scene_meshes.py

Surfaces of revolution about the y axis, a teapot and the water of the pool, as binary PLY with normals. Needs Python and NumPy.
"""
import os

import numpy as np

SCENES = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "scenes")


def write(name, points, normals, triangles):
    normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(points)
    header += "".join("property float %s\n" % c for c in ("x", "y", "z", "nx", "ny", "nz"))
    header += "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % len(triangles)
    faces = np.zeros(len(triangles), np.dtype([("n", "u1"), ("i", "<i4", 3)]))
    faces["n"], faces["i"] = 3, triangles
    with open(os.path.join(SCENES, name), "wb") as f:
        f.write(header.encode())
        f.write(np.concatenate([points, normals], 1).astype("<f4").tobytes())
        f.write(faces.tobytes())


def quads(rows, columns):
    """Two triangles for each cell of a grid of points, whose rows lie one after the other."""
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    return np.concatenate([np.stack([a, a + columns, a + 1], 1), np.stack([a + 1, a + columns, a + columns + 1], 1)])


def turned(radius, height, normal, around):
    """Turns a profile about the y axis; `normal` are its (radial, vertical) normals. Seams and poles keep their points doubled."""
    phi = np.linspace(0, 2 * np.pi, around + 1)
    phi[-1] = 0
    turn = lambda r, y: np.stack([np.outer(r, np.cos(phi)), np.outer(y, np.ones_like(phi)), np.outer(r, np.sin(phi))], -1).reshape(-1, 3)
    triangles = quads(len(radius), around + 1)[:, [0, 2, 1]]  # anticlockwise seen from outside
    points = turn(radius, height)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return points, turn(*normal), triangles[area > 1e-9]


def lathe(name, radius, height, normal, around):
    write(name, *turned(radius, height, normal, around))


def profile(*pieces):
    """One profile of pieces (radii, heights) with an edge between each two, and its normals: outward where the piece goes down."""
    normals = [(-np.gradient(y), np.gradient(r)) for r, y in pieces]
    join = lambda pairs: tuple(np.concatenate(side) for side in zip(*pairs))
    return *join(pieces), join(normals)


def line(r0, y0, r1, y1):
    return np.array([r0, r1]), np.array([y0, y1])


def hose(x, y, radius, around):
    """A tube about a curve in the plane z = 0, open at both ends."""
    dx, dy = np.gradient(x), np.gradient(y)
    length = np.hypot(dx, dy)
    phi = np.linspace(0, 2 * np.pi, around + 1)
    phi[-1] = 0
    side, out = np.cos(phi), np.sin(phi)
    normals = np.stack([np.outer(-dy / length, side), np.outer(dx / length, side), np.outer(np.ones_like(x), out)], -1)
    points = np.stack([x, y, np.zeros_like(x)], -1)[:, None] + radius[:, None, None] * normals
    return points.reshape(-1, 3), normals.reshape(-1, 3), quads(len(x), around + 1)[:, [0, 2, 1]]


def together(name, *parts):
    """Writes several (points, normals, triangles) as one mesh."""
    starts = np.cumsum([0] + [len(points) for points, _, _ in parts])
    points, normals, triangles = zip(*parts)
    write(name, np.concatenate(points), np.concatenate(normals), np.concatenate([t + s for t, s in zip(triangles, starts)]))


def egg():
    """An egg 0.3 high: a sphere whose upper half is stretched. Profile from the top to the bottom, normals outward."""
    t = np.linspace(0, np.pi, 49)
    a, b = 0.105, np.where(t < np.pi / 2, 0.18, 0.12)
    sine, cosine = np.where((t == 0) | (t == np.pi), 0, np.sin(t)), np.cos(t)
    lathe("lamp-room/egg.ply", a * sine, 0.12 + b * cosine, (sine / a, cosine / b), 72)


def shade():
    """A lamp's bowl, open above: a thin wall between radius 0.12 at y = 0 and 0.26 at y = 0.3."""
    t = np.linspace(0, 1, 9)
    r, y = 0.12 + 0.14 * t ** 0.6, 0.3 * t
    slope = np.gradient(r, y)
    lathe("lamp-room/shade.ply", r[::-1], y[::-1], (np.ones_like(t), -slope[::-1]), 64)


def ring():
    """A finger ring: an ellipse 0.09 thick and 0.3 high, turned at a radius of 0.6, standing on y = 0; from the top outward and around."""
    t = np.linspace(0, 2 * np.pi, 25)
    t[-1] = 0
    a, b = 0.045, 0.15
    lathe("ring/ring.ply", 0.6 + a * np.sin(t), b + b * np.cos(t), (np.sin(t) / a, np.cos(t) / b), 112)


def water():
    """Waves on [-1.02, 1.02]^2 about y = 0: a sum of sines, with the normals of that sum."""
    waves = [(0.018, 5.0, 1.7, 0.3), (0.013, -3.1, 6.3, 1.1), (0.009, 8.9, 4.2, 2.0), (0.005, -9.7, 10.1, 4.0), (0.004, 3.0, -14.0, 5.2)]
    x, z = np.meshgrid(*[np.linspace(-1.02, 1.02, 60)] * 2, indexing="ij")
    y, dx, dz = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for height, kx, kz, phase in waves:
        y += height * np.sin(kx * x + kz * z + phase)
        slope = height * np.cos(kx * x + kz * z + phase)
        dx, dz = dx + kx * slope, dz + kz * slope
    flat = lambda *grids: np.stack(grids, -1).reshape(-1, 3)
    triangles = quads(*x.shape)[:, [0, 2, 1]]  # anticlockwise seen from above
    write("pool/water.ply", flat(x, y, z), flat(-dx, np.ones_like(x), -dz), triangles)


def teapot():
    """A pot 0.19 high and 0.23 wide with a knobbed lid, its spout towards +x, its handle towards -x, standing on y = 0."""
    t = np.linspace(0, 1, 9)
    knob = 0.016 * np.sin(2.5 * t), 0.016 * np.cos(2.5 * t)
    slope = np.linspace(np.arcsin(knob[0][-1] / 0.062), np.pi / 2, 9)
    lid = 0.062 * np.sin(slope), 0.142 + 0.0215 * np.cos(slope)
    knob = knob[0], knob[1] + (lid[1][0] - knob[1][-1])
    y = np.linspace(0.14, 0.004, 19)
    body = 0.115 * np.sqrt(1 - ((y - 0.068) / 0.085) ** 2), y
    rim = line(0.062, 0.142, body[0][0], 0.14)
    foot = line(body[0][-1], 0.004, body[0][-1], 0)
    pot = turned(*profile(knob, lid, rim, body, foot), 40)
    t = np.linspace(0, 1, 13)
    spout = hose(0.095 + 0.095 * t, 0.05 + 0.09 * t ** 1.7, 0.024 - 0.013 * t ** 0.7, 20)
    bow = np.pi * (0.08 + 0.88 * t)
    handle = hose(-0.09 - 0.075 * np.sin(bow), 0.075 + 0.05 * np.cos(bow), np.full(13, 0.009), 14)
    together("ajar/teapot.ply", pot, spout, handle)


def tumbler():
    """A drinking glass 0.13 high, wall 0.003 thick: from the axis over the inner floor, up, over the rim, down and back."""
    inside, outside = (0.033, 0.012, 0.039, 0.13), (0.042, 0.13, 0.036, 0)
    floor, rim, foot = line(0, 0.012, 0.033, 0.012), line(0.039, 0.13, 0.042, 0.13), line(0.036, 0, 0, 0)
    for folder in ("ajar", "kitchen"):
        lathe(folder + "/tumbler.ply", *profile(floor, line(*inside), rim, line(*outside), foot), 48)


def bowl():
    """A bowl 0.09 high and 0.28 wide, wall 0.006 thick, from the axis over the inside and down the outside."""
    t = np.linspace(0, 1, 15)
    curve = lambda r, low: (r * np.sin(np.pi / 2 * t), 0.09 - (0.09 - low) * np.cos(np.pi / 2 * t))
    inside, outside = curve(0.134, 0.006), curve(0.14, 0)
    lip = line(inside[0][-1], 0.09, 0.14, 0.09)
    lathe("kitchen/bowl.ply", *profile(inside, lip, (outside[0][::-1], outside[1][::-1])), 48)


def pan():
    """A cooking pot without lid, 0.13 high and 0.22 wide, wall 0.004 thick with rounded lower edges."""
    t = np.pi / 2 * np.linspace(0, 1, 7)
    bend = lambda r, low, round: (r - round + round * np.sin(t), low + round - round * np.cos(t))
    inner, outer = bend(0.106, 0.006, 0.02), bend(0.11, 0, 0.024)
    inside = np.concatenate([[0], inner[0], [0.106]]), np.concatenate([[0.006], inner[1], [0.13]])
    outside = np.concatenate([[0.11], outer[0][::-1], [0]]), np.concatenate([[0.13], outer[1][::-1], [0]])
    lathe("kitchen/pan.ply", *profile(inside, line(0.106, 0.13, 0.11, 0.13), outside), 56)


egg()
shade()
ring()
water()
teapot()
tumbler()
bowl()
pan()
