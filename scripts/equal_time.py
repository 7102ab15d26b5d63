#!/usr/bin/env python3
"""Methods beside each other at equal time (run by hand).

    scripts/equal_time.py SCENE --reference [METHOD=]FILE.exr... [--cross] (--time 20 | --cpu 20) METHOD[:KEY=VALUE[,KEY=VALUE]...][@LAYER]...
        [--seeds 5] [--resolution WxH] [-p KEY=VALUE]... [--layer NAME=EXPRESSION]... [--below RADIANCE] [--rgb] [--kaustika PROGRAM]
        [--keep FOLDER]

Every method renders with seeds 1, 2, ..., by turns: with --time for the same seconds by the clock, with --cpu on one thread for the
passes that trial runs fit to so many seconds of processor time, which other work on the machine moves little. Seconds are then the
process's user time without that of loading, which is what a single path to one pixel takes. Its error is

    relMSE = mean (x - r)² / (r² + 0.01)

over pixels and channels, against the first reference that another method made (averaged to the picture's size; pixels that are not finite
there are left out, with --below also those that are brighter). With --cross two references b and c, independent and unbiased, stand in
for r: mean (x - b)(x - c) / (d² + 0.01), where d is the mean of all pictures made, is on average what it would be without their errors. trimmed: without the 0.1 % of largest error. Medians over the seeds;
gain: the first method's relMSE times seconds over this one's. reference: how many times the method's passes the reference has, if it is one of
Kaustika's. The mean ratio shows bias, the picture's and the reference's. METHOD@LAYER: the light of one class of paths, held against that
layer of the reference.
--keep: pictures of the first seed stay there. Runs in a Python that has numpy and OpenImageIO. Build first: cargo build --release.
"""
import argparse
import functools
import json
import os
import re
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


def errors(x, b, c, d, below):
    """relMSE, trimmed relMSE and ratio of means; b, c and d are the reference, or b and c two that are independent."""
    r = (b + c) / 2
    good = np.isfinite(r).all(-1) & (r.max(-1) < below)
    x, b, c, d, r = x[good], b[good], c[good], d[good], r[good]
    error = (x - b) * (x - c) / (d * d + 0.01)
    trimmed = np.sort(error.mean(-1))[:-max(1, len(error) // 1000)].mean()
    return error.mean(), trimmed, x.mean() / r.mean()


def reference_for(method, references):
    """The first reference that another method made."""
    return references_for(method, references, 1)[0]


def references_for(method, references, count):
    """The first references that other methods made."""
    by = [r.rpartition("=")[::2] for r in references]
    others = [file for maker, file in by if maker != method]
    return (others if len(others) >= count else [file for _, file in by])[:count]


def passes_of(reference):
    """Passes of a picture of Kaustika's; 0 if it does not say."""
    return int(oiio.ImageBuf(reference).spec().getattribute("samplesPerPixel") or 0)


def table(runs, work="passes"):
    """Markdown: medians over the runs (relMSE, trimmed, mean ratio, work, its share of the reference's, seconds) of each method."""
    print("| method | %s | s | reference | relMSE | gain | trimmed | gain | mean ratio |\n" % work + "|---" * 9 + "|")
    medians = {m: [statistics.median(v) for v in zip(*r)] for m, r in runs.items()}
    first, first_trimmed, *_, first_seconds = next(iter(medians.values()))
    for method, (relmse, trimmed, ratio, n, times, seconds) in medians.items():
        gains = (first * first_seconds / (relmse * seconds), first_trimmed * first_seconds / (trimmed * seconds))
        print("| `%s` | %d | %.2f | %s | %.3g | %.3g | %.3g | %.3g | %.4f |"
              % (method, n, seconds, "%d" % times if times else "", relmse, gains[0], trimmed, gains[1], ratio))


class Program:
    """Renders a scene, and says what that took."""

    def __init__(self, a, folder):
        self.a, self.image, self.stats = a, os.path.join(folder, "image.exr"), os.path.join(folder, "stats.json")

    def run(self, *extra):
        """User seconds of the process."""
        command = [self.a.kaustika, "render", self.a.scene, "-q", "-o", self.image, "--stats", self.stats, *["--rgb"] * self.a.rgb, *extra]
        process = subprocess.Popen(command)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, command)
        return used.ru_utime

    def of(self, method):
        """How a method is asked for."""
        spec, _, layer = method.partition("@")
        name, _, own = spec.partition(":")
        parameters = self.a.parameters + (own.split(",") if own else [])
        layers = [x for l in self.a.layer if layer and l.startswith(layer + "=") for x in ("--layer", l)]
        size = ["--resolution", self.a.resolution] if self.a.resolution else []
        return ["-m", name, *size, *layers, *(x for p in parameters for x in ("-p", p))]

    def fit(self, method):
        """The passes that a method makes in a.cpu seconds."""
        passes, used = 1, 0
        while True:
            used = self.cpu(method, passes, 0)
            if used >= self.a.cpu / 2:
                break
            passes *= 2
        # Where the first passes cost more than those after them, or less, more than one guess is needed.
        for _ in range(3):
            if abs(used / self.a.cpu - 1) < 0.1:
                break
            passes = max(1, round(passes * self.a.cpu / used))
            used = self.cpu(method, passes, 0)
        return passes

    def cpu(self, method, passes, seed):
        """Seconds of so many passes, without loading."""
        return self.run(*self.of(method), "--threads", "1", "--spp", str(passes), "--seed", str(seed)) - self.loading()

    @functools.cache
    def loading(self):
        return min(self.run("-m", "light", "--threads", "1", "--spp", "1", "--resolution", "1x1") for _ in range(3))


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("scene")
    ap.add_argument("methods", nargs="+")
    ap.add_argument("--reference", required=True, action="append")
    budget = ap.add_mutually_exclusive_group(required=True)
    budget.add_argument("--time", type=float)
    budget.add_argument("--cpu", type=float)
    ap.add_argument("--seeds", type=int, default=5)
    ap.add_argument("--resolution")
    ap.add_argument("-p", dest="parameters", action="append", default=[])
    ap.add_argument("--layer", action="append", default=[])
    ap.add_argument("--cross", action="store_true")
    ap.add_argument("--below", type=float, default=np.inf)
    ap.add_argument("--rgb", action="store_true")
    ap.add_argument("--kaustika", default=os.path.join(os.path.dirname(HERE), "target", "release", "kaustika"))
    ap.add_argument("--keep")
    a = ap.parse_args()
    runs = {m: [] for m in a.methods}
    with tempfile.TemporaryDirectory() as folder:
        program = Program(a, folder)
        passes = {m: program.fit(m) for m in a.methods} if a.cpu else {}
        for seed in range(1, a.seeds + 1):
            for method in a.methods:
                if a.cpu:
                    seconds = program.cpu(method, passes[method], seed)
                else:
                    program.run(*program.of(method), "--time", "%gs" % a.time, "--seed", str(seed))
                    seconds = a.time
                name, layer = re.split("[:@]", method)[0], method.partition("@")[2]
                x = read(program.image, layer)
                used = references_for(name, a.reference, 2 if a.cross else 1)
                b, c = (shrunk(read(r, layer), x.shape[0]) for r in (used[0], used[-1]))
                with open(program.stats) as f:
                    done = json.load(f)["passes"]
                runs[method].append((x, b, c, done, sum(map(passes_of, used)) / done, seconds))
                if a.keep and seed == 1:
                    os.makedirs(a.keep, exist_ok=True)
                    os.replace(program.image, os.path.join(a.keep, method + ".exr"))
    everything = [x for of_method in runs.values() for x, *_ in of_method]
    mean = np.mean(everything, 0) if a.cross else None
    told = lambda x, b, c, *rest: (*errors(x, b, c, b if mean is None else mean, a.below), *rest)
    table({method: [told(*run) for run in of_method] for method, of_method in runs.items()})


if __name__ == "__main__":
    main()
