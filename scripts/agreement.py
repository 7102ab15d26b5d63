#!/usr/bin/env python3
"""Holds the methods against each other on the project's own scenes (run by hand).

    scripts/agreement.py [SCENE | FILE]... [--seeds 24] [--kaustika PROGRAM] [--resolution WxH] [--of METHOD...] [--pixels] [--fault METHOD=FACTOR]

Every method renders every scene with as many seeds as asked for; two methods are compared on the light of one class of paths
(`--layer`), which both must be able to sample: the mean of the picture and of each of its tiles of 16 x 16 pixels, in red, green and blue,
by Welch's test over the seeds; with --pixels each pixel, too, that at least half of the renders tell of, (sum x)^2 / sum x^2 >= seeds / 2, by
both methods: where few renders found light the test's normal distribution is none. All tests together have one significance of 1 % (Sidak). One table in Markdown; exit code 1 if
a test rejects. A FILE is any other scene, by its path, on which all comparisons are made that `--of` leaves. --fault makes one method's pictures brighter by a factor, to see the tests fail. Runs in a Python that has numpy and
OpenImageIO. Build first: cargo build --release.
"""
import argparse
import math
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SIGNIFICANCE, TILE = 0.01, 16

CLASSES = {
    # everything
    "all": "C.*L",
    # what light tracing can show the camera: the last thing that the light meets is no mirror and no clear glass
    "shown": "C[^S].*L",
    # what is seen on matte surfaces
    "matte": "CD.*L",
    # what next event estimation from the eye finds, and lamps seen in mirrors: no caustics
    "asked": "C(S*|.*[^S])L",
    # direct light, by way of mirrors and clear glass; by way of all that is glossy
    "whitted": "L[D|S]S_M*E",
    "cook": "L[D]S*E",
}

# Chains of a small picture: b of few candidates, which independent renders average.
CHAINS = ["bootstrap=16384", "brightness_error=1", "chains=1024", "renew=0"]

# method (and what of it): passes a seed, parameters
METHODS = {
    "path": (64, []),
    "light": (64, []),
    "bdpt": (16, []),
    "vcm": (16, ["radius=0.0005", "alpha=1"]),
    "sppm": (64, ["radius=0.001", "alpha=1"]),
    "whitted": (64, []),
    "distributed": (64, []),
    "bdpt guided": (128, ["guiding=true"]),
    "pssmlt": (32, [*CHAINS, "steps=4"]),
    "mmlt": (64, [*CHAINS, "steps=4"]),
    "mlt": (64, CHAINS),
    "erpt": (256, []),
}
# methods that find one class alone: their picture is that class
WHOLE = {"whitted": "whitted", "distributed": "cook"}

# scene: its file, comparisons (one method, another, class)
USUAL = [("path", "bdpt", "asked"), ("light", "bdpt", "shown"), ("vcm", "bdpt", "all")]
# Paths in media are not among the states of `mlt` and `erpt`.
CHANGED = [(m, "bdpt guided", "all") for m in ("pssmlt", "mmlt", "mlt", "erpt")]
TREES = [("whitted", "path", "whitted"), ("distributed", "path", "cook")]
SCENES = {
    "cornell-box": ("scene.pbrt", [("path", "bdpt", "all"), *USUAL[1:], ("sppm", "bdpt", "all"), *TREES, *CHANGED]),
    "plates": ("scene.pbrt", [("path", "bdpt", "all"), ("light", "bdpt", "matte"), USUAL[2], *TREES, *CHANGED]),
    "sky": ("scene.xml", USUAL + TREES + CHANGED),
    "lamp-room": ("scene.xml", USUAL + TREES + CHANGED),
    "door": ("scene.xml", USUAL + TREES + CHANGED),
    "glass-sphere": ("scene.xml", USUAL + [("sppm", "bdpt", "shown"), *TREES, *CHANGED]),
    "ring": ("scene.xml", USUAL + [("sppm", "bdpt", "shown"), *TREES, *CHANGED]),
    "pool-large": ("large.xml", [("path", "bdpt", "all"), *USUAL[1:], ("sppm", "bdpt", "all"), *CHANGED]),
    "pool-small": ("small.xml", [USUAL[0], USUAL[1], ("vcm", "bdpt", "asked"), ("vcm", "sppm", "all"), *CHANGED]),
    "fog": ("scene.pbrt", USUAL + CHANGED[:2]),
    "gloss": ("scene.xml", TREES),
    "history": ("scene.xml", TREES),
}


def render(kaustika, scene, method, seed, resolution, classes, image):
    passes, parameters = METHODS[method]
    command = [kaustika, "render", scene, "-q", "-m", method.split()[0], "--spp", str(passes), "--seed", str(seed), "-o", image,
               "--sampler", "independent", "--filter", "box", *(["--resolution", resolution] if resolution else [])]
    command += [x for p in parameters for x in ("-p", p)]
    if method not in WHOLE:
        command += [x for c in classes for x in ("--layer", c + "=" + CLASSES[c])]
    subprocess.run(command, check=True)
    buffer = oiio.ImageBuf(image)
    names, pixels = buffer.spec().channelnames, buffer.get_pixels(oiio.FLOAT)
    prefix = (lambda c: "") if method in WHOLE else (lambda c: c + ".")
    return {c: pixels[..., [names.index(prefix(c) + k) for k in "RGB"]].astype(np.float64) for c in classes}


def parts(pixels, each):
    """Means of the picture and of its tiles, and perhaps each pixel, in each channel."""
    h, w, _ = pixels.shape
    tiles = [pixels[y:y + TILE, x:x + TILE].mean((0, 1)) for y in range(0, h, TILE) for x in range(0, w, TILE)]
    return np.concatenate([[pixels.mean((0, 1))], tiles, *[pixels.reshape(-1, 3)] * each])


def welch(a, b):
    """Normal scores of the differences of means over the first axis, and these means' variances.

    Welch's t with its degrees of freedom n becomes normal by Wallace 1959:
    z = (8n + 1) / (8n + 3) sqrt(n ln(1 + t^2 / n)).
    """
    va, vb = a.var(0, ddof=1) / len(a), b.var(0, ddof=1) / len(b)
    with np.errstate(divide="ignore", invalid="ignore"):
        n = (va + vb) ** 2 / (va ** 2 / (len(a) - 1) + vb ** 2 / (len(b) - 1))
        t = (a.mean(0) - b.mean(0)) / np.sqrt(va + vb)
        z = (8 * n + 1) / (8 * n + 3) * np.sqrt(n * np.log1p(t * t / n)) * np.sign(t)
    z[(va + vb == 0) & (a.mean(0) == b.mean(0))] = 0  # black in both
    return z


def told(x):
    """Where at least half of the renders tell of the mean."""
    with np.errstate(invalid="ignore"):
        return x.sum(0) ** 2 / (x ** 2).sum(0) >= len(x) / 2


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(SCENES))
    ap.add_argument("--seeds", type=int, default=24)
    ap.add_argument("--resolution", default="64x48")
    ap.add_argument("--kaustika", default=os.path.join(ROOT, "target", "release", "kaustika"))
    ap.add_argument("--fault", default="none=1")
    ap.add_argument("--pixels", action="store_true", help="compare each pixel, too")
    ap.add_argument("--of", nargs="*", help="only comparisons of these methods with others")
    a = ap.parse_args()
    files = {os.path.basename(os.path.dirname(os.path.abspath(f))): f for f in a.scenes if os.path.isfile(f)}
    a.scenes = [next((name for name, file in files.items() if file == s), s) for s in a.scenes]
    scenes = {**SCENES, **{name: (file, USUAL + TREES + CHANGED) for name, file in files.items()}}
    unknown = [s for s in a.scenes if s not in scenes]
    if unknown:
        ap.error("no scene %s; there are %s" % (", ".join(unknown), ", ".join(SCENES)))
    fault, factor = a.fault.split("=")

    rows, tests, compared = [], 0, []
    with tempfile.TemporaryDirectory() as folder:
        for name in a.scenes or SCENES:
            file, comparisons = scenes[name]
            comparisons = [c for c in comparisons if not a.of or c[0] in a.of]
            folder_of = name.split("-")[0] if name.startswith("pool") else name
            scene = files.get(name) or os.path.join(ROOT, "scenes", folder_of, file)
            seen = {}
            for method in dict.fromkeys(m for c in comparisons for m in c[:2]):
                classes = list(dict.fromkeys(c for one, other, c in comparisons if method in (one, other)))
                first = 1 + 1000 * list(METHODS).index(method)
                for seed in range(first, first + a.seeds):
                    layers = render(a.kaustika, scene, method, seed, a.resolution, classes, os.path.join(folder, "image.exr"))
                    for c, pixels in layers.items():
                        tiles = math.prod(-(-n // TILE) for n in pixels.shape[:2])
                        seen.setdefault((method, c), []).append(parts(pixels, a.pixels) * (float(factor) if method == fault else 1))
            for one, other, c in comparisons:
                x, y = np.array(seen[one, c]), np.array(seen[other, c])
                z = welch(x, y)
                pixels = z[1 + tiles:]
                pixels[~(told(x) & told(y))[1 + tiles:]] = np.nan
                compared.append(np.isfinite(pixels).mean() if a.pixels else 0)
                tests += np.isfinite(z).sum()
                grey = [v[:, 0].mean(1) for v in (x, y)]
                error = math.sqrt(sum(g.var(ddof=1) / len(g) / g.mean() ** 2 for g in grey))
                rows.append((name, one, other, c, grey[0].mean() / grey[1].mean(), error, z, tiles))
            print("%s: done" % name, file=sys.stderr)

    alone = -math.expm1(math.log1p(-SIGNIFICANCE) / tests)
    columns = ["scene", "methods", "class", "ratio of means", "its error", "largest z of the means", "of the tiles", *["of the pixels"] * a.pixels, "agree"]
    print("| %s |\n" % " | ".join(columns) + "|---" * len(columns) + "|")
    rejected = False
    for name, one, other, c, ratio, error, z, tiles in rows:
        worst = [np.nanmax(np.abs(part)) for part in np.split(z, [1, 1 + tiles]) if part.size]
        ok = math.erfc(max(worst) / math.sqrt(2)) > alone
        rejected |= not ok
        cells = [name, "`%s`, `%s`" % (one, other), c, "%.4f" % ratio, "%.4f" % error, *["%.2f" % w for w in worst], "yes" if ok else "**no**"]
        print("| %s |" % " | ".join(cells))
    bound = next(x for x in np.arange(0, 10, 0.01) if math.erfc(x / math.sqrt(2)) < alone)
    print("\n%d tests together, significance %g: each z may reach %.2f." % (tests, SIGNIFICANCE, bound))
    if a.pixels:
        print("Pixels that are compared: " + ", ".join("%s %s %.0f %%" % (*row[:2], 100 * c) for row, c in zip(rows, compared)))
    sys.exit(rejected)


if __name__ == "__main__":
    main()
