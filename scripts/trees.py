#!/usr/bin/env python3
"""What roulette and splitting do, as a picture (run by hand).

    scripts/trees.py OUT.png SCENE... [--roulette efficiency] [--spp 127] [--resolution 120x90] [--kaustika PROGRAM]

A row a scene: `guided` with that rule, and of its trees the factor q at the first surface (blue ends paths, red splits them, white is 1;
a factor of 4 is full colour), the copies that splits added and the paths that roulette ended (per sample, white is 8), and the rays traced
(white is 32). Runs in a Python that has numpy, OpenImageIO and Pillow. Build first: cargo build --release.
"""
import argparse
import os
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio
from PIL import Image

HERE = os.path.dirname(os.path.abspath(__file__))


def encoded(linear):
    """sRGB values, 0 to 255."""
    x = np.clip(linear, 0, 1)
    return (255 * np.where(x < 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)).round().astype(np.uint8)


def diverging(q):
    """Blue below 1, white at 1, red above."""
    t = np.clip(np.log(np.maximum(q, 1e-6)) / np.log(4), -1, 1)
    return (255 * np.stack([1 + np.minimum(t, 0), 1 - abs(t), 1 - np.maximum(t, 0)], -1)).astype(np.uint8)


def grey(x, most):
    return np.repeat((255 * np.clip(x / most, 0, 1)).astype(np.uint8)[..., None], 3, -1)


def row(a, scene, image):
    command = [a.kaustika, "render", scene, "-q", "-m", "guided", "-p", "roulette=" + a.roulette, "-p", "fallback=false",
               "--spp", str(a.spp), "--resolution", a.resolution, "--aov", "trees", "-o", image]
    subprocess.run(command, check=True)
    buffer = oiio.ImageBuf(image)
    names, pixels = buffer.spec().channelnames, buffer.get_pixels(oiio.FLOAT)
    of = lambda name: pixels[..., names.index("Trees." + name)]
    rgb = pixels[..., [names.index(c) for c in "RGB"]]
    return np.concatenate([encoded(rgb), diverging(of("Factor")), grey(of("Added"), 8), grey(of("Ended"), 8), grey(of("Rays"), 32)], 1)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("out")
    ap.add_argument("scenes", nargs="+")
    ap.add_argument("--roulette", default="efficiency")
    ap.add_argument("--spp", type=int, default=127)
    ap.add_argument("--resolution", default="120x90")
    ap.add_argument("--kaustika", default=os.path.join(os.path.dirname(HERE), "target", "release", "kaustika"))
    a = ap.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        rows = [row(a, scene, os.path.join(folder, "image.exr")) for scene in a.scenes]
    Image.fromarray(np.concatenate(rows, 0)).save(a.out)


if __name__ == "__main__":
    main()
