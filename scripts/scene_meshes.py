#!/usr/bin/env python3
"""Makes the few meshes of scenes/ that no analytic shape gives (they are kept there; run by hand to make them again).

    scripts/scene_meshes.py

Surfaces of revolution about the y axis and the water of the pool, as binary PLY with normals. Needs Python and NumPy.
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


def lathe(name, radius, height, normal, around):
    """Turns a profile about the y axis; `normal` are its (radial, vertical) normals. Seams and poles keep their points doubled."""
    phi = np.linspace(0, 2 * np.pi, around + 1)
    phi[-1] = 0
    turn = lambda r, y: np.stack([np.outer(r, np.cos(phi)), np.outer(y, np.ones_like(phi)), np.outer(r, np.sin(phi))], -1).reshape(-1, 3)
    triangles = quads(len(radius), around + 1)[:, [0, 2, 1]]  # anticlockwise seen from outside
    points = turn(radius, height)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    write(name, points, turn(*normal), triangles[area > 1e-9])


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


egg()
shade()
ring()
water()
