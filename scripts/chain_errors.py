#!/usr/bin/env python3
"""Are the errors that Metropolis methods report true? (run by hand)

    scripts/chain_errors.py SCENE METHOD[:KEY=VALUE[,KEY=VALUE]...]... [--reference FILE.exr] [--seeds 10] [--spp 100]
        [--resolution 80x64] [-p KEY=VALUE]... [--rgb] [--keep FOLDER] [--kaustika PROGRAM]

Every method renders with seeds 1, 2, .... Over tiles of 16 x 16 pixels and seeds, of green:

    chi2 = Σ ((x - mean over seeds) / reported)² / ((seeds - 1) tiles)

`reported` is the layer TileError; of `erpt`, whose passes are independent, it comes from sixteen shares of them, and the warning from
renders of them all with the first two seeds. About 63/61 is right for errors from 64 groups (15/13 from 16), and 0.7 to 1.4 is accepted. others: the same without the tile
that has the largest: where one pixel has light that a render finds or misses, that tile tells of nothing else. bias: the
same of the mean over seeds against the reference, whose own error comes from its layer StdError (independent pixels), a degree of
freedom, with the number of tiles and the p-value. seconds: of processor time, a render. warned: how many renders warned that chains keep
to parts of the picture, or that few candidates have most of its light. With --keep a run that was stopped goes on where it was, and
what was rendered is not rendered again; --spp may be given of each method: mlt:spp=400. Runs in a Python with numpy and OpenImageIO.
"""
import argparse
import contextlib
import math
import os
import re
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
        own = dict(p.split("=", 1) for p in args.parameters + [p for p in own.split(",") if p])
        self.spp = int(own.pop("spp", args.spp))
        self.erpt = name == "erpt"
        self.folder = folder
        # What was rendered is known by how it was rendered.
        self.name = re.sub(r"[^A-Za-z0-9.=+-]", "_", ",".join([name, *(f"{k}={v}" for k, v in own.items()), args.resolution, str(self.spp)]))
        self.command = [args.kaustika, "render", args.scene, "-m", name, "--spp", str(self.spp), "--resolution", args.resolution,
                        "--threads", str(args.threads), *["--rgb"] * args.rgb]
        for k, v in own.items():
            self.command += ["-p", f"{k}={v}"]

    def layers(self, *extra):
        """The picture's layers, and whether the render warned."""
        out = os.path.join(self.folder, f"{self.name}.exr")
        done = subprocess.run([*self.command, "-o", out, *extra], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(done.stderr)
        return layers(out), "warning: " in done.stderr

    def render(self, seed):
        """Means and errors of tiles, whether the render warned (-1: not asked), and its seconds."""
        before = os.times()
        if self.erpt:
            edges = [self.spp * i // SHARES for i in range(SHARES + 1)]
            parts = [self.layers("--seed", str(seed), "--passes", f"{a}..{b}")[0] for a, b in zip(edges, edges[1:])]
            means = np.array([tiles(p["G"]) for p in parts])
            mean, error = means.mean(0), means.std(0, ddof=1) / math.sqrt(SHARES)
        else:
            picture, warned = self.layers("--seed", str(seed))
            mean, error = tiles(picture["G"]), tiles(picture["TileError.G"])
        after = os.times()
        if self.erpt:
            warned = self.layers("--seed", str(seed))[1] if seed <= 2 else -1
        return mean, error, int(warned), after.children_user - before.children_user

    def tiles(self, seed):
        """What `render` tells, or told before."""
        kept = os.path.join(self.folder, f"{self.name}-{seed}.npz")
        if not os.path.exists(kept):
            told = dict(zip(["mean", "error", "warned", "seconds"], self.render(seed)))
            np.savez(kept + ".part.npz", **told)
            os.replace(kept + ".part.npz", kept)
        with np.load(kept) as told:
            return told["mean"], told["error"], int(told["warned"]), float(told["seconds"])


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
    parser.add_argument("--keep", help="folder for what was rendered")
    parser.add_argument("--kaustika", default=os.path.join(HERE, "../target/release/kaustika"))
    args = parser.parse_args()
    print(f"{'method':44s} {'chi2':>6s} {'others':>7s} {'bias':>6s} {'p':>8s} {'tiles':>6s} {'seconds':>8s} {'warned':>7s}")
    with contextlib.ExitStack() as stack:
        folder = args.keep or stack.enter_context(tempfile.TemporaryDirectory())
        os.makedirs(folder, exist_ok=True)
        for method in args.methods:
            program = Program(args, method, folder)
            row(method, [program.tiles(seed) for seed in range(1, args.seeds + 1)], args)


def row(method, told, args):
    """Prints a method's row."""
    means, errors, warned, seconds = (list(x) for x in zip(*told))
    x, e = np.array(means), np.array(errors)
    lit = (e > 0).all(0)
    of_tiles = (((x - x.mean(0)) / np.where(e > 0, e, 1)) ** 2)[:, lit].sum(0) / (args.seeds - 1)
    chi, others = of_tiles.mean(), np.sort(of_tiles)[:-1].mean()
    bias, p = float("nan"), float("nan")
    if args.reference:
        r = layers(args.reference)
        own = error_of_tiles(r["StdError.G"])
        mine = np.sqrt((e ** 2).sum(0)) / args.seeds
        total = (((x.mean(0) - tiles(r["G"])) ** 2) / (own ** 2 + mine ** 2))[lit].sum()
        bias, p = total / lit.sum(), chi_square_tail(total, lit.sum())
    print(f"{method:44s} {chi:6.2f} {others:7.2f} {bias:6.2f} {p:8.4f} {lit.sum():6d} {np.mean(seconds):8.1f} "
          f"{sum(w > 0 for w in warned):4d}/{sum(w >= 0 for w in warned)}", flush=True)


if __name__ == "__main__":
    main()
