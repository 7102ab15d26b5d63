#!/usr/bin/env python3
"""Are the errors that Metropolis methods report true? (run by hand)

    scripts/chain_errors.py SCENE METHOD[:KEY=VALUE[,KEY=VALUE]...]... [--reference FILE.exr] [--seeds 10] [--spp 100]
        [--resolution 80x64] [-p KEY=VALUE]... [--rgb] [--kaustika PROGRAM]

Every method renders with seeds 1, 2, .... Over tiles of 16 x 16 pixels and seeds, of green:

    chi2 = Σ ((x - mean over seeds) / reported)² / ((seeds - 1) tiles)

`reported` is the layer TileError; of `erpt`, whose passes are independent, it comes from sixteen shares of them, and the warning from a render of them all. About 15/13 is right for errors from 16 groups, and 0.7 to 1.4 is accepted. bias: the same of the mean over
seeds against the reference, whose own error comes from its layer StdError (independent pixels), a degree of freedom, with the number of
tiles and the p-value. warned: how many renders warned that chains keep to parts of the picture, or that few candidates have most of its light. Runs in a Python with numpy and OpenImageIO.
"""
import argparse
import math
import os
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))
SIDE = 16
SHARES = 16


def layers(path):
    buffer = oiio.ImageBuf(path)
    pixels = buffer.get_pixels(oiio.FLOAT).astype(np.float64)
    return {name: pixels[..., i] for i, name in enumerate(buffer.spec().channelnames)}


def tiles(x):
    """Means over the tiles of a picture."""
    h, w = x.shape
    return np.array([x[y:y + SIDE, x0:x0 + SIDE].mean() for y in range(0, h, SIDE) for x0 in range(0, w, SIDE)])


def error_of_tiles(error):
    """Of means over tiles, from those of independent pixels."""
    h, w = error.shape
    part = lambda y, x0: error[y:y + SIDE, x0:x0 + SIDE]
    return np.array([math.sqrt((part(y, x0) ** 2).sum()) / part(y, x0).size
                     for y in range(0, h, SIDE) for x0 in range(0, w, SIDE)])


def chi_square_tail(x, n):
    """P(χ²ₙ > x) by Wilson & Hilferty (1931)."""
    z = ((x / n) ** (1 / 3) - (1 - 2 / (9 * n))) / math.sqrt(2 / (9 * n))
    return 0.5 * math.erfc(z / math.sqrt(2))


class Program:
    """Renders a scene by a method."""

    def __init__(self, args, method, folder):
        name, _, own = method.partition(":")
        self.out = os.path.join(folder, "x.exr")
        self.command = [args.kaustika, "render", args.scene, "-m", name, "--spp", str(args.spp), "--resolution", args.resolution,
                        "--threads", str(args.threads), "-o", self.out, *["--rgb"] * args.rgb]
        for p in args.parameters + [p for p in own.split(",") if p]:
            self.command += ["-p", p]

    def layers(self, *extra):
        """The picture's layers, and whether the render warned."""
        done = subprocess.run([*self.command, *extra], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(done.stderr)
        return layers(self.out), "warning: " in done.stderr

    def tiles(self, seed, spp):
        """Means and errors of tiles, and whether the render warned."""
        if "erpt" in self.command:
            edges = [spp * i // SHARES for i in range(SHARES + 1)]
            parts = [self.layers("--seed", str(seed), "--passes", f"{a}..{b}")[0] for a, b in zip(edges, edges[1:])]
            means = np.array([tiles(p["G"]) for p in parts])
            _, warned = self.layers("--seed", str(seed))
            return means.mean(0), means.std(0, ddof=1) / math.sqrt(SHARES), warned
        picture, warned = self.layers("--seed", str(seed))
        return tiles(picture["G"]), tiles(picture["TileError.G"]), warned


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("methods", nargs="+")
    parser.add_argument("--reference")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--spp", type=int, default=100)
    parser.add_argument("--resolution", default="80x64")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("-p", dest="parameters", action="append", default=[])
    parser.add_argument("--rgb", action="store_true")
    parser.add_argument("--kaustika", default=os.path.join(HERE, "../target/release/kaustika"))
    args = parser.parse_args()
    print(f"{'method':44s} {'chi2':>6s} {'bias':>6s} {'p':>8s} {'tiles':>6s} {'warned':>7s}")
    for method in args.methods:
        means, errors, warned = [], [], 0
        with tempfile.TemporaryDirectory() as folder:
            program = Program(args, method, folder)
            for seed in range(1, args.seeds + 1):
                mean, error, told = program.tiles(seed, args.spp)
                means.append(mean)
                errors.append(error)
                warned += told
        x, e = np.array(means), np.array(errors)
        lit = (e > 0).all(0)
        chi = (((x - x.mean(0)) / np.where(e > 0, e, 1)) ** 2)[:, lit].sum() / ((args.seeds - 1) * lit.sum())
        bias, p = float("nan"), float("nan")
        if args.reference:
            r = layers(args.reference)
            own = error_of_tiles(r["StdError.G"])
            mine = np.sqrt((e ** 2).sum(0)) / args.seeds
            total = (((x.mean(0) - tiles(r["G"])) ** 2) / (own ** 2 + mine ** 2))[lit].sum()
            bias, p = total / lit.sum(), chi_square_tail(total, lit.sum())
        print(f"{method:44s} {chi:6.2f} {bias:6.2f} {p:8.4f} {lit.sum():6d} {warned:4d}/{args.seeds}", flush=True)


if __name__ == "__main__":
    main()
