#!/usr/bin/env python3
"""Methods beside each other at equal time (run by hand).

    scripts/equal_time.py SCENE --reference FILE.exr --time 20 METHOD[:KEY=VALUE[,KEY=VALUE]...]... [--seeds 5] [--resolution WxH]
        [-p KEY=VALUE]... [--kaustika PROGRAM] [--keep FOLDER]

Every method renders for the same time with seeds 1, 2, ..., by turns. Its error is

    relMSE = mean (x - r)² / (r² + 0.01)

over pixels and channels, against the reference (averaged to the picture's size; pixels that are not finite there are left out);
trimmed: without the 0.1 % of largest error. Medians over the seeds. The mean ratio shows bias, the picture's and the reference's.
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


def read(path):
    pixels = oiio.ImageBuf(path).get_pixels(oiio.FLOAT)
    return pixels[..., :3].astype(np.float64)


def shrunk(reference, height):
    k = reference.shape[0] // height
    h, w = reference.shape[0] // k, reference.shape[1] // k
    return reference[:h * k, :w * k].reshape(h, k, w, k, 3).mean((1, 3))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scene")
    ap.add_argument("methods", nargs="+")
    ap.add_argument("--reference", required=True)
    ap.add_argument("--time", type=float, default=20)
    ap.add_argument("--seeds", type=int, default=5)
    ap.add_argument("--resolution")
    ap.add_argument("-p", dest="parameters", action="append", default=[])
    ap.add_argument("--kaustika", default=os.path.join(os.path.dirname(HERE), "target", "release", "kaustika"))
    ap.add_argument("--keep")
    a = ap.parse_args()
    runs = {m: [] for m in a.methods}
    with tempfile.TemporaryDirectory() as folder:
        image, stats = os.path.join(folder, "image.exr"), os.path.join(folder, "stats.json")
        for seed in range(1, a.seeds + 1):
            for method in a.methods:
                name, _, own = method.partition(":")
                parameters = a.parameters + (own.split(",") if own else [])
                command = [a.kaustika, "render", a.scene, "-q", "-m", name, "--time", "%gs" % a.time, "--seed", str(seed),
                           "-o", image, "--stats", stats, *(["--resolution", a.resolution] if a.resolution else [])]
                subprocess.run(command + [x for p in parameters for x in ("-p", p)], check=True)
                x = read(image)
                r = shrunk(read(a.reference), x.shape[0])
                good = np.isfinite(r).all(-1)
                error = ((x - r) ** 2 / (r * r + 0.01))[good]
                trimmed = np.sort(error.mean(-1))[:-max(1, len(error) // 1000)].mean()
                with open(stats) as f:
                    passes = json.load(f)["passes"]
                runs[method].append((error.mean(), trimmed, x[good].mean() / r[good].mean(), passes))
                if a.keep and seed == 1:
                    os.makedirs(a.keep, exist_ok=True)
                    os.replace(image, os.path.join(a.keep, name + ".exr"))
    print("| method | passes | relMSE | trimmed | mean ratio |\n|---|---|---|---|---|")
    for method, all_runs in runs.items():
        relmse, trimmed, ratio, passes = (statistics.median(v) for v in zip(*all_runs))
        print("| %s | %d | %.4g | %.4g | %.4f |" % (method, passes, relmse, trimmed, ratio))


if __name__ == "__main__":
    main()
