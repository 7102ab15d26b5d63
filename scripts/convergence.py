#!/usr/bin/env python3
"""Do methods that merge converge as their radius says? On the caustic of scenes/glass-sphere (run by hand).

    scripts/convergence.py [METHOD]... [--seeds 32] [--kaustika PROGRAM]

The radius of pass i is r_i = r_1 i^((alpha - 1) / 2). A pass's bias grows as its r^2, the part of its variance that comes from few
photons as 1 / r^2. So the mean of N passes has (Knaus & Zwicker 2011)

    bias      B(N) ~ 1/N   sum i^(alpha - 1)                  (1)
    variance  V(N) ~ 1/N^2 sum (a i^(1 - alpha) + b)          (2)

First table: 1, 4 and 16 times the passes. The variance is that between seeds, the bias that of their mean against the reference, in tiles
of 4 x 4 pixels; beside the measured ratios those of (1) and, as bounds, those of (2) for b = 0 and a = 0.

Second table: fixed radii (alpha = 1). The bias falls as r^2: a straight line through the tiles' means over r^2 is read at r = 0 and held against the
reference: chi^2 per tile, and the largest normal score beside its bound at a significance of 1 % over all tiles.

The reference is `bdpt`'s, which knows no radius. Tiles in which anything is seen in the ball or through it are left out: caustics that are
seen so (LS+DS+E) are found by `bdpt` by chance alone, so seldom that the variance between its seeds does not show what it misses. Runs in a Python that has numpy and OpenImageIO. Build first: cargo build --release.
"""
import argparse
import math
import os
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENE = os.path.join(ROOT, "scenes", "glass-sphere", "scene.xml")
CROP, TILE = (72, 60, 104, 84), 4  # of 128 x 128 pixels: the bright spot and the shadow around it
FIRST, ALPHA, SHRINKING = 16, 0.75, 0.02  # passes, and the first radius, of the first table
RADII, FIXED = (0.003, 0.004, 0.005, 0.006, 0.007), 128  # of the second, and its passes
# Few photons a pass, all those within the radius; that of the global map, which only gathers read, is wider.
PHOTON_MAP = "photons=5000 caustic_photons=5000 nearest=1000000 caustic_nearest=1000000 filter=box caustic_radius=%g radius=%g"
REFERENCE = 256  # passes of each of the reference's seeds


def render(kaustika, method, seed, passes, image, *extra):
    command = [kaustika, "render", SCENE, "-q", "-m", method, "--spp", str(passes), "--seed", str(seed), "-o", image, "--resolution", "128x128",
               "--crop", ",".join(map(str, CROP)), "--sampler", "independent", *extra]
    subprocess.run(command, check=True)
    return oiio.ImageBuf(image)


def means(pixels):
    """Of the tiles, in grey."""
    grey = pixels.astype(np.float64).mean(-1)
    h, w = grey.shape
    return grey.reshape(h // TILE, TILE, w // TILE, TILE).mean((1, 3)).ravel()


def directly_seen(kaustika, image):
    """The tiles in which no light comes by way of the ball."""
    picture = render(kaustika, "path", 1, 64, image, "--layer", "ball=CS.*L")
    names = picture.spec().channelnames
    return means(picture.get_pixels(oiio.FLOAT)[..., [names.index("ball." + c) for c in "RGB"]]) == 0


def tiles(kaustika, method, seed, passes, parameters, image):
    """Means of the tiles."""
    picture = render(kaustika, method, seed, passes, image, *(x for p in parameters for x in ("-p", p)))
    return means(picture.get_pixels(oiio.FLOAT)[..., :3])


def with_radius(method, radius, alpha):
    """What gives a method this radius."""
    own = PHOTON_MAP % (radius, 4 * radius) if method == "photonmap" else "radius=%g" % radius
    return ["alpha=%g" % alpha, *own.split()]


def over_seeds(kaustika, method, first, seeds, passes, parameters, image, wanted):
    """Means over the seeds and the variances of one, of the tiles that are wanted."""
    runs = np.array([tiles(kaustika, method, first + s, passes, parameters, image)[wanted] for s in range(seeds)])
    return runs.mean(0), runs.var(0, ddof=1)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("methods", nargs="*", default=["sppm", "vcm", "photonmap"])
    ap.add_argument("--seeds", type=int, default=32)
    ap.add_argument("--kaustika", default=os.path.join(ROOT, "target", "release", "kaustika"))
    a = ap.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "image.exr")
        wanted = directly_seen(a.kaustika, image)
        run = lambda method, first, passes, *p: over_seeds(a.kaustika, method, first, a.seeds, passes, p, image, wanted)
        truth, spread = run("bdpt", 1, REFERENCE)
        weight = 1 / (truth ** 2 + 0.01)

        print("| method | passes | variance | ratio | between | bias^2 | ratio of biases | expected |\n" + "|---" * 8 + "|")
        for method in a.methods:
            before = None
            for k, passes in enumerate((FIRST, 4 * FIRST, 16 * FIRST)):
                mean, variance = run(method, 1000 * (k + 1), passes, *with_radius(method, SHRINKING, ALPHA))
                error = (variance + spread) / a.seeds
                bias2 = ((mean - truth) ** 2 - error) * weight  # what noise adds to the square is taken off
                now = ((variance * weight).mean(), bias2.mean())
                i = np.arange(1, passes + 1)
                law = (sum(i ** (ALPHA - 1)) / passes, sum(i ** (1 - ALPHA)) / passes ** 2, 1 / passes)
                ratio = ["", "", "", ""]
                if before:
                    old, was = before
                    ratio = ["%.3f" % (now[0] / old[0]), "%.3f, %.3f" % (law[2] / was[2], law[1] / was[1]),
                             "%.3f" % math.sqrt(max(0, now[1]) / old[1]), "%.3f" % (law[0] / was[0])]
                print("| `%s` | %d | %.3g | %s | %s | %.3g | %s | %s |" % (method, passes, now[0], *ratio[:2], now[1], *ratio[2:]), flush=True)
                before = now, law

        print("\n| method | relative bias at r = %s | at 0 | chi^2 per tile | largest z | its bound |\n" % ", ".join("%g" % r for r in RADII) + "|---" * 6 + "|")
        for method in a.methods:
            means, variances = zip(*(run(method, 10000 + 1000 * k, FIXED, *with_radius(method, r, 1)) for k, r in enumerate(RADII)))
            y, x = np.array(means), np.square(RADII)
            w = 1 / np.mean(variances, 1)  # the same for all tiles: a weight must not know its tile's noise
            s, sx, sxx = w.sum(), (w * x).sum(), (w * x * x).sum()
            share = w * (sxx - sx * x) / (s * sxx - sx ** 2)  # of each radius in the value at 0
            at_zero, error = share @ y, (share ** 2 @ np.array(variances) + spread) / a.seeds
            z = (at_zero - truth) / np.sqrt(error)
            biases = [math.sqrt(max(0, (((m - truth) ** 2 - (v + spread) / a.seeds) * weight).mean())) for m, v in zip(means, variances)]
            zero = (((at_zero - truth) ** 2 - error) * weight).mean()
            alone = -math.expm1(math.log1p(-0.01) / z.size)
            bound = next(v for v in np.arange(0, 10, 0.01) if math.erfc(v / math.sqrt(2)) < alone)
            print("| `%s` | %s | %.4f | %.2f | %.2f | %.2f |" % (method, ", ".join("%.4f" % b for b in biases), math.copysign(math.sqrt(abs(zero)), zero),
                                                              (z ** 2).mean(), np.abs(z).max(), bound), flush=True)


if __name__ == "__main__":
    main()
