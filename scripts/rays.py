#!/usr/bin/env python3
"""Ray throughput beside Embree's, on the same meshes and rays (run by hand).

    scripts/rays.py DIR... --embree PROGRAM [--kaustika PROGRAM] [--meshes 70k 1M 10M] [--threads 1 2]
        [--widths 1 8 16] [--flags none robust] [--rounds 3] [--repeat 3] [--json OUT]
        [--lock FILE]... [--under-1 COMMAND] [--under-2 COMMAND]

The folders hold NAME.ply and NAME_{primary,diffuse,shadow}.f32: a mesh, and float32 rays, seven numbers each (origin,
direction, tmax). Meshes that are in none are left out. The program for Embree is called as

    PROGRAM bench MESH.ply QUALITY BUILD_THREADS THREADS WIDTH REPEAT FLAGS KIND:RAYS.f32...

and prints a JSON line for its build (`build_s`, `bvh_bytes`), then one for each file of rays (`best_mrays`,
`median_mrays`, `hits`, `t_sum`), which are also the keys of `kaustika rays --json`. Primary and diffuse rays ask for the
closest hit, shadow rays for any.

In each round every program runs once, ours first in every other round; a run traces the rays once untimed, then REPEAT
times. What is shown is the median over the rounds of the runs' medians; Embree's is that of the width which is best for
these rays. --lock names files to hold (flock) during a round; between two rounds they are free for others. --under-T names
a command to start the runs with T threads by, for a core or a priority (`taskset -c 0`).
Needs nothing but Python. Build first: cargo build --release.
"""
import argparse
import contextlib
import fcntl
import json
import os
import shlex
import statistics
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RAYS = [("primary", "closest"), ("diffuse", "closest"), ("shadow", "any")]


def arguments():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    ap.add_argument("dirs", nargs="+")
    ap.add_argument("--embree", required=True)
    ap.add_argument("--kaustika", default=os.path.join(ROOT, "target", "release", "kaustika"))
    ap.add_argument("--meshes", nargs="+", default=["70k", "1M", "10M"])
    ap.add_argument("--threads", type=int, nargs="+", default=[1, 2])
    ap.add_argument("--widths", type=int, nargs="+", default=[1, 8, 16])
    ap.add_argument("--flags", nargs="+", default=["none", "robust"])
    ap.add_argument("--quality", default="medium")
    ap.add_argument("--rounds", type=int, default=3)
    ap.add_argument("--repeat", type=int, default=3)
    ap.add_argument("--json")
    ap.add_argument("--lock", action="append", default=[])
    ap.add_argument("--under-1", default="")
    ap.add_argument("--under-2", default="")
    return ap.parse_args()


@contextlib.contextmanager
def alone(a):
    with contextlib.ExitStack() as stack:
        for path in a.lock:
            fcntl.flock(stack.enter_context(open(path, "w")), fcntl.LOCK_EX)
        yield


def lines(command, under):
    """The JSON lines a command prints, and the most memory it held, in bytes."""
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(shlex.split(under) + command, stdout=out)
        _, status, usage = os.wait4(process.pid, 0)
        if status:
            raise SystemExit("failed: " + " ".join(command))
        out.seek(0)
        return [json.loads(line) for line in out if line.strip()], usage.ru_maxrss * 1024


def kaustika(a, mesh, threads, under):
    specs = ["%s:%s_%s.f32" % (query, mesh, rays) for rays, query in RAYS]
    found, peak = lines([a.kaustika, "rays", mesh + ".ply", *specs, "--json", "-t", str(threads), "--repeat", str(a.repeat)],
                        under)
    first = found[0]
    build = dict(seconds=first["build_seconds"], bytes=first["bytes_per_triangle"], load=first["load_seconds"],
                 triangles=first["triangles"], peak=peak / first["triangles"])
    return dict(build=build, rays=found)


def embree(a, mesh, threads, under, width, flags):
    specs = ["%s:%s_%s.f32" % (query, mesh, rays) for rays, query in RAYS]
    (build, *found), _ = lines([a.embree, "bench", mesh + ".ply", a.quality, str(threads), str(threads), str(width),
                                str(a.repeat), flags, *specs], under)
    build = dict(seconds=build["build_s"], bytes=build["bvh_bytes"] / build["triangles"], version=build["embree"])
    return dict(build=build, rays=found)


def measure(a, mesh, threads):
    """Lists of runs, one a round: {"kaustika": [...], (flags, width): [...]}."""
    under = {1: a.under_1, 2: a.under_2}.get(threads, "")
    programs = {"kaustika": lambda: kaustika(a, mesh, threads, under)}
    for flags in a.flags:
        for width in a.widths:
            programs[flags, width] = lambda w=width, f=flags: embree(a, mesh, threads, under, w, f)
    runs = {key: [] for key in programs}
    for r in range(a.rounds):
        with alone(a):
            for key in list(programs)[:: 1 if r % 2 == 0 else -1]:
                runs[key].append(programs[key]())
    return runs


def mrays(runs, i):
    return statistics.median(run["rays"][i]["median_mrays"] for run in runs)


def best_width(a, runs, flags, i):
    return max(a.widths, key=lambda w: mrays(runs[flags, w], i))


def of_build(runs, key):
    return statistics.median(run["build"][key] for run in runs)


def table(head, rows):
    print("\n| %s |\n|%s" % (" | ".join(head), "---|" * len(head)))
    for row in rows:
        print("| %s |" % " | ".join(row), flush=True)


def report(a, all_runs):
    head = ["mesh", "threads", "rays", "Kaustika"]
    for flags in a.flags:
        head += ["Embree `%s` (width)" % flags, "ratio"]
    rows = []
    for (mesh, threads), runs in all_runs.items():
        for i, (name, query) in enumerate(RAYS):
            ours = mrays(runs["kaustika"], i)
            row = [mesh, str(threads), "%s, %s" % (name, query), "%.2f" % ours]
            for flags in a.flags:
                width = best_width(a, runs, flags, i)
                theirs = mrays(runs[flags, width], i)
                row += ["%.2f (%d)" % (theirs, width), "**%.2f**" % (ours / theirs)]
            rows.append(row)
    print("\nMillions of rays a second; the ratio is ours over Embree's.")
    table(head, rows)

    head = ["mesh", "threads", "Kaustika: read, s", "build, s", "bytes a triangle", "peak, bytes a triangle"]
    for flags in a.flags:
        head += ["Embree `%s`: build, s" % flags, "bytes a triangle", "ratio of build times"]
    rows = []
    for (mesh, threads), runs in all_runs.items():
        ours = runs["kaustika"]
        row = [mesh, str(threads)] + ["%.3g" % of_build(ours, k) for k in ("load", "seconds", "bytes", "peak")]
        for flags in a.flags:
            theirs = [run for width in a.widths for run in runs[flags, width]]
            row += ["%.3g" % of_build(theirs, "seconds"), "%.3g" % of_build(theirs, "bytes"),
                    "**%.2f**" % (of_build(ours, "seconds") / of_build(theirs, "seconds"))]
        rows.append(row)
    print("\nBuilding; the ratio is our time over Embree's. The peak is of the whole process: mesh, tree, then rays.")
    table(head, rows)

    rows = []
    for (mesh, threads), runs in all_runs.items():
        for i, (name, query) in enumerate(RAYS):
            ours = runs["kaustika"][0]["rays"][i]
            row = [mesh, str(threads), name, "%d of %d" % (ours["hits"], ours["rays"])]
            for flags in a.flags:
                theirs = [run["rays"][i] for width in a.widths for run in runs[flags, width]]
                row.append("%+d" % max((ours["hits"] - t["hits"] for t in theirs), key=abs))
                apart = [ours["t_sum"] / t["t_sum"] - 1 for t in theirs if t["t_sum"]]
                row.append("%+.1e" % max(apart, key=abs) if apart else "")
            rows.append(row)
    head = ["mesh", "threads", "rays", "hits"]
    for flags in a.flags:
        head += ["more than Embree `%s`" % flags, "sum of distances, relative"]
    print("\nAgreement: ours less Embree's, the width that is farthest off.")
    table(head, rows)


def main():
    a = arguments()
    all_runs = {}
    for mesh in a.meshes:
        base = next((b for d in a.dirs if os.path.exists((b := os.path.join(d, mesh)) + ".ply")), None)
        for threads in a.threads if base else []:
            all_runs[mesh, threads] = measure(a, base, threads)
    if not all_runs:
        raise SystemExit("no mesh found")
    report(a, all_runs)
    if a.json:
        found = [dict(mesh=mesh, threads=threads, runs=[dict(program=" ".join(map(str, [key] if key == "kaustika" else key)),
                 rounds=runs[key]) for key in runs]) for (mesh, threads), runs in all_runs.items()]
        with open(a.json, "w") as out:
            json.dump(found, out, indent=1)


if __name__ == "__main__":
    main()
