"""Writes an environment map as the spectral variants of Mitsuba 3 show it (evidence for docs/references.md).

    mitsuba_sky.py MAP.exr OUT.exr

Between texels Mitsuba interpolates the shapes s of their spectra and their scales m each for itself, (sum w s)(sum w m) in
place of sum w s m. Here its own `envmap` is asked for its spectra at FINER times as many places along each side, and their
colours (CIE 1931, 5 nm) are written as linear sRGB: a picture of what it shows, which others can use. Needs the package
mitsuba, and LLVM (DRJIT_LIBLLVM_PATH).
"""
import sys

import drjit as dr
import mitsuba as mi
import numpy as np

FINER = 4

mi.set_variant("llvm_ad_spectral")
width, height = mi.Bitmap(sys.argv[1]).size()
light = mi.load_dict({"type": "envmap", "filename": sys.argv[1]})
columns, rows = FINER * width, FINER * (height - 1) + 1
index = dr.arange(mi.UInt32, columns * rows)
phi = dr.two_pi * (mi.Float(index % columns) + 0.5) / columns
theta = dr.pi * mi.Float(index // columns) / (rows - 1)
at = dr.zeros(mi.SurfaceInteraction3f, columns * rows)
at.wi = -mi.Vector3f(dr.sin(phi) * dr.sin(theta), dr.cos(theta), -dr.cos(phi) * dr.sin(theta))

nodes = np.linspace(360, 830, 95)
xyz = np.zeros((3, columns * rows))
for lambdas in np.concatenate([nodes, nodes[-1:]]).reshape(-1, 4):
    at.wavelengths = mi.Spectrum(*map(float, lambdas))
    values = np.array(light.eval(at))
    seen = np.array(mi.cie1931_xyz(mi.Float(lambdas)))
    for k in range(4):
        xyz += np.outer(seen[:, k], values[k])
# The last node stands twice: nothing is seen there. The film divides by this integral of y.
step, of_film = 5.0, 106.7502593994140625
to_xyz = [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]]
rgb = np.linalg.inv(to_xyz) @ (step / of_film * xyz)
mi.Bitmap(rgb.T.reshape(rows, columns, 3).astype(np.float32).copy()).write(sys.argv[2])
