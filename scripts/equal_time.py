#!/usr/bin/env python3
"""Methods beside each other at equal time (run by hand).

    scripts/equal_time.py SCENE --reference [METHOD=]FILE.exr... --time 20 METHOD[:KEY=VALUE[,KEY=VALUE]...][@LAYER]... [--seeds 5]
        [--resolution WxH] [-p KEY=VALUE]... [--layer NAME=EXPRESSION]... [--below RADIANCE] [--rgb] [--kaustika PROGRAM] [--keep FOLDER]

Every method renders for the same time with seeds 1, 2, ..., by turns. Its error is

    relMSE = mean (x - r)² / (r² + 0.01)

over pixels and channels, against the first reference that another method made (averaged to the picture's size; pixels that are not finite
there are left out, with --below also those that are brighter); trimmed: without the 0.1 % of largest error. Medians over the seeds;
gain: the first method's relMSE over this one's. The mean ratio shows bias, the picture's and the reference's. METHOD@LAYER: the light of one
class of paths, held against that layer of the reference.
--keep: pictures of the first seed stay there. Runs in a Python that has numpy and OpenImageIO. Build first: cargo build --release.
"""
import argparse
import json
import os
import statistics
import subprocess
import tempfile

import numpy as np
import OpenImageIO as oiio

HERE = os.path.dirname(os.path.abspath(__file__))


def read(path, layer=""):
    """Red, green and blue of a picture, or of one of its layers by path."""
    buffer = oiio.ImageBuf(path)
    names, pixels = buffer.spec().channelnames, buffer.get_pixels(oiio.FLOAT)
    prefix = layer + "." if layer else ""
    return pixels[..., [names.index(prefix + c) for c in "RGB"]].astype(np.float64)


def shrunk(reference, height):
    k = reference.shape[0] // height
    h, w = reference.shape[0] // k, reference.shape[1] // k
    return reference[:h * k, :w * k].reshape(h, k, w, k, 3).mean((1, 3))


def errors(x, r, below):
    """relMSE, trimmed relMSE and ratio of means."""
    good = np.isfinite(r).all(-1) & (r.max(-1) < below)
    x, r = x[good], r[good]
    error = (x - r) ** 2 / (r * r + 0.01)
    trimmed = np.sort(error.mean(-1))[:-max(1, len(error) // 1000)].mean()
    return error.mean(), trimmed, x.mean() / r.mean()


def reference_for(method, references):
    """The first reference that another method made."""
    by = [r.rpartition("=")[::2] for r in references]
    return next((file for maker, file in by if maker != method), by[0][1])


def table(runs, work="passes"):
    """Markdown: medians over the runs (relMSE, trimmed, mean ratio, work) of each method."""
    print("| method | %s | relMSE | gain | trimmed | gain | mean ratio |\n|---|---|---|---|---|---|---|" % work)
    medians = {m: [statistics.median(v) for v in zip(*r)] for m, r in runs.items()}
    first = next(iter(medians.values()))
    for method, (relmse, trimmed, ratio, n) in medians.items():
        print("| `%s` | %d | %.3g | %.3g | %.3g | %.3g | %.4f |" % (method, n, relmse, first[0] / relmse, trimmed, first[1] / trimmed, ratio))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scene")
    ap.add_argument("methods", nargs="+")
    ap.add_argument("--reference", required=True, action="append")
    ap.add_argument("--time", type=float, default=20)
    ap.add_argument("--seeds", type=int, default=5)
    ap.add_argument("--resolution")
    ap.add_argument("-p", dest="parameters", action="append", default=[])
    ap.add_argument("--layer", action="append", default=[])
    ap.add_argument("--below", type=float, default=np.inf)
    ap.add_argument("--rgb", action="store_true")
    ap.add_argument("--kaustika", default=os.path.join(os.path.dirname(HERE), "target", "release", "kaustika"))
    ap.add_argument("--keep")
    a = ap.parse_args()
    runs = {m: [] for m in a.methods}
    with tempfile.TemporaryDirectory() as folder:
        image, stats = os.path.join(folder, "image.exr"), os.path.join(folder, "stats.json")
        for seed in range(1, a.seeds + 1):
            for method in a.methods:
                spec, _, layer = method.partition("@")
                name, _, own = spec.partition(":")
                parameters = a.parameters + (own.split(",") if own else [])
                command = [a.kaustika, "render", a.scene, "-q", "-m", name, "--time", "%gs" % a.time, "--seed", str(seed),
                           "-o", image, "--stats", stats, *(["--resolution", a.resolution] if a.resolution else [])]
                command += ["--rgb"] * a.rgb + [x for p in parameters for x in ("-p", p)]
                command += [x for l in a.layer if layer and l.startswith(layer + "=") for x in ("--layer", l)]
                subprocess.run(command, check=True)
                x = read(image, layer)
                r = shrunk(read(reference_for(name, a.reference), layer), x.shape[0])
                with open(stats) as f:
                    passes = json.load(f)["passes"]
                runs[method].append((*errors(x, r, a.below), passes))
                if a.keep and seed == 1:
                    os.makedirs(a.keep, exist_ok=True)
                    os.replace(image, os.path.join(a.keep, name + ".exr"))
    table(runs)


if __name__ == "__main__":
    main()
