#!/usr/bin/env python3
"""Instructions a sample of small fixed renders, counted by callgrind: a figure that other work on the machine does not move.

    scripts/instructions.py            counts, and writes docs/instructions.txt
    scripts/instructions.py --check    counts, and compares with docs/instructions.txt
    scripts/instructions.py --twice    counts twice, and says how far apart the totals are; writes nothing

The program is built for x86-64-v3 (callgrind knows no AVX-512) in a target directory of its own (INSTRUCTIONS_TARGET, else
target/instructions). Each scene is rendered by one thread with few and with more passes; the difference, divided by the samples in
it, is free of starting, loading and building. Instructions belong to the source file that they were compiled from, also
where they were inlined into another's function, and files are put together by folder; without a source file to a library.
What threads do while they wait for work differs from run to run, and is left out; the rest repeats to one in 100,000. Needs
valgrind.
"""
import collections
import datetime
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TARGET = os.environ.get("INSTRUCTIONS_TARGET", os.path.join(ROOT, "target", "instructions"))
RECORD = os.path.join(ROOT, "docs", "instructions.txt")
SIDES = (48, 32)
PASSES = (2, 10)
SCENES = [("built-in", []), ("box", [os.path.join("scenes", "box", "scene.xml")])]
# Functions in which rayon's threads look for work and sleep, as far as their code is not Kaustika's.
WAITING = re.compile(r"rayon|crossbeam|std::sys::sync|std::thread|sched_yield|futex|pthread|syscall|Chain<A,B>")
# Below this share of a scene's total a group is shown among the others.
SMALL = 0.005


def build():
    env = dict(os.environ, CARGO_TARGET_DIR=TARGET, RUSTFLAGS="-C target-cpu=x86-64-v3")
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "kaustika"], cwd=ROOT, env=env, check=True)
    return os.path.join(TARGET, "release", "kaustika")


def group(path, function, library):
    """What an instruction belongs to, by its source file, or without one (`???`) by its library; None for waiting."""
    ours = None if "core_arch" in path else re.search(r"crates/(\w+)/src/(\w+)", path)
    if ours:
        crate, module = ours.groups()
        return crate if crate in ("math", "spectra") else "%s/%s" % (crate, module)
    if WAITING.search(function):
        return None
    if re.match(r"_*mem(cpy|move|set|cmp)", function):
        return "memcpy, memset, memcmp"
    if "core_arch" in path:
        return "SIMD intrinsics"
    if "/library/" in path:
        return "standard library"
    return "other crates" if "/registry/" in path else library


def costs(path):
    """Instructions of each group in a file of callgrind's (its manual, "Callgrind Format Specification")."""
    names, found = {}, collections.Counter()
    library, source, function, skip = "", "", "", False
    with open(path) as lines:
        for line in lines:
            spec = re.match(r"(ob|cob|fl|fi|fe|cfi|cfl|fn|cfn)=\((\d+)\)(?: (.*))?$", line)
            if spec:
                kind, number, name = spec.groups()
                key = (kind[-2:] if kind[-2:] in ("ob", "fn") else "file", number)
                if name:
                    names[key] = name
                if kind == "ob":
                    library = os.path.basename(names[key])
                elif kind == "fn":
                    function = names[key]
                elif kind in ("fl", "fi", "fe"):
                    source = names[key]
            elif line.startswith("calls="):
                skip = True  # the next line is the callee's
            elif re.match(r"[+\-*\d]", line):
                if not skip:
                    found[group(source, function, library)] += int(line.split()[-1])
                skip = False
    del found[None]
    return found


def count(program, scene, passes, folder):
    out = os.path.join(folder, "callgrind.out")
    width, height = SIDES
    subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=" + out, program, "render", *scene, "-q", "--rgb",
                    "--threads", "1", "--seed", "1", "--filter", "box", "--sampler", "independent", "--spp", str(passes),
                    "--resolution", "%dx%d" % (width, height), "-o", os.path.join(folder, "a.pfm")],
                   cwd=ROOT, check=True, capture_output=True)
    return costs(out)


def measure(program):
    """For each scene: instructions a sample of each group."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, scene in SCENES:
            few, more = (count(program, scene, passes, folder) for passes in PASSES)
            samples = SIDES[0] * SIDES[1] * (PASSES[1] - PASSES[0])
            found[name] = {g: (more[g] - few[g]) / samples for g in more}
    return found


def total(groups):
    return sum(groups.values())


def git(*args):
    return subprocess.run(["git", *args], cwd=ROOT, check=True, capture_output=True, text=True).stdout.strip()


def text(found):
    commit = git("rev-parse", "--short=12", "HEAD")
    changed = " and what was not committed" if git("status", "--porcelain", "--", "crates", "Cargo.lock", "Cargo.toml") else ""
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True).stdout.strip()
    lines = ["Instructions a sample, by scripts/instructions.py",
             "commit %s%s, %s, %s" % (commit, changed, datetime.date.today().isoformat(), rustc)]
    for name, groups in found.items():
        lines += ["", "%s: total %.1f" % (name, total(groups))]
        large = {g: v for g, v in groups.items() if v >= SMALL * total(groups)}
        rest = total(groups) - total(large)
        lines += ["  %-28s %8.1f" % (g, v) for g, v in sorted(large.items(), key=lambda e: -e[1])]
        lines.append("  %-28s %8.1f" % ("all others", rest))
    return "\n".join(lines) + "\n"


def recorded():
    found, scene = {}, None
    with open(RECORD) as lines:
        for line in lines:
            head = re.match(r"(.+): total ([\d.]+)$", line)
            entry = re.match(r"  (\S.*?) +([\d.]+)$", line)
            if head:
                scene = found[head[1]] = {}
                scene["total"] = float(head[2])
            elif entry and scene is not None:
                scene[entry[1]] = float(entry[2])
    return found


def check(found):
    before = recorded()
    for name, groups in found.items():
        old = before.get(name, {})
        now = dict(groups, total=total(groups))
        print("%s" % name)
        for g in ["total"] + sorted((g for g in now if g != "total" and g in old), key=lambda g: -now[g]):
            print("  %-28s %8.1f before, %8.1f now, ratio %.4f" % (g, old[g], now[g], now[g] / old[g] if old[g] else 0))


def main():
    program = build()
    found = measure(program)
    if "--twice" in sys.argv:
        again = measure(program)
        for name in found:
            a, b = total(found[name]), total(again[name])
            print("%s: %.3f and %.3f instructions a sample, relative difference %.1e" % (name, a, b, b / a - 1))
    elif "--check" in sys.argv:
        check(found)
    else:
        written = text(found)
        with open(RECORD, "w") as out:
            out.write(written)
        print(written, end="")


if __name__ == "__main__":
    main()
