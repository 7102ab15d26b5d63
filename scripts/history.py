#!/usr/bin/env python3
"""The lecture's history in one figure: every method on one scene, a row a decade (run by hand).

    scripts/history.py [--kaustika PROGRAM] [--size 160] [--threads 1] [--only METHOD...] [--scale 1.0]

Renders scenes/history/scene.xml with every method of METHODS, each with its name and year below, into docs/images/history.png; and radiosity
shot by shot, without and with what is not shot yet as ambient light, into docs/images/southwell.png. --scale multiplies all samples. Runs in
a Python that has Pillow. Build first: cargo build --release.
"""
import argparse
import os
import subprocess
import sys
import tempfile

from PIL import Image, ImageDraw, ImageFont

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
SCENE = os.path.join(ROOT, "scenes", "history", "scene.xml")

# decade: (what the figure calls it, year, method, samples a pixel, parameters)
METHODS = {
    "1970s": [
        ("Bouknight: facets", 1970, "zbuffer", 16, ["model=bouknight", "shadows=false", "ambient=0.1"]),
        ("Gouraud", 1971, "zbuffer", 16, ["model=gouraud", "shadows=false", "ambient=0.1"]),
        ("Phong", 1975, "zbuffer", 16, ["model=phong", "shadows=false", "ambient=0.1"]),
        ("Blinn", 1977, "zbuffer", 16, ["model=blinn", "shadows=false", "ambient=0.1"]),
        ("shadow maps", 1978, "zbuffer", 16, ["ambient=0.1"]),
    ],
    "1980s": [
        ("Whitted: ray tracing", 1980, "whitted", 64, []),
        ("Cook: distributed", 1984, "distributed", 64, []),
        ("Goral: radiosity", 1984, "radiosity", 64, ["direct=mesh", "solver=gauss-seidel", "patches=4000", "display=constant"]),
        ("Arvo: backward", 1986, "backward", 64, []),
        ("Kajiya: path tracing", 1986, "path", 64, ["mis=light"]),
        ("Wallace: two passes", 1987, "hybrid", 64, ["terms=wallace", "of=L([S_M]D)*S_M*E"]),
        ("Cohen: 100 shots", 1988, "radiosity", 64, ["direct=mesh", "solver=southwell", "patches=8000", "shots=100", "ambient=true"]),
        ("Sillion & Puech: any", 1989, "hybrid", 64, ["terms=sillion-puech"]),
    ],
    "1990s": [
        ("Hanrahan: hierarchy", 1991, "radiosity", 64, ["patches=20000"]),
        ("Sillion et al.: gloss", 1991, "radiosity", 64, ["direct=mesh", "solver=jacobi", "patches=4000", "glossy=6"]),
        ("light tracing", 1991, "light", 256, []),
        ("Chen: multi-pass", 1991, "chen", 64, []),
        ("Veach & Guibas: MIS", 1995, "path", 64, []),
        ("Jensen: photon map", 1996, "photonmap", 64, []),
        ("Keller: virtual lights", 1997, "vpl", 64, []),
        ("Veach: bidirectional", 1997, "bdpt", 64, []),
        ("Veach: Metropolis", 1997, "mlt", 64, []),
    ],
    "2000s": [
        ("Kelemen: primary space", 2002, "pssmlt", 64, []),
        ("Cline: redistribution", 2005, "erpt", 64, []),
        ("Hachisuka: SPPM", 2009, "sppm", 64, []),
    ],
    "2010s": [
        ("Georgiev: VCM", 2012, "vcm", 64, []),
        ("Hachisuka: multiplexed", 2014, "mmlt", 64, []),
        ("Vorba, Mueller: guided", 2017, "guided", 64, []),
    ],
}
SHOTS = [1, 2, 5, 20, 100, 1000]
MARGIN, LINE, HEAD = 6, 16, 48
PAPER, INK, FAINT = (255, 255, 255), (20, 20, 20), (110, 110, 110)


def render(args, method, spp, parameters, image):
    command = [args.kaustika, "render", SCENE, "-q", "-m", method, "--spp", str(max(1, round(spp * args.scale))), "-o", image]
    command += ["--resolution", f"{args.size}x{args.size}", "--threads", str(args.threads), "--filter", "box"]
    command += [x for p in parameters for x in ("-p", p)]
    print(" ".join(command), file=sys.stderr)
    subprocess.run(command, check=True)
    return Image.open(image).convert("RGB")


def font(size):
    return ImageFont.load_default(size)


def sheet(args, rows):
    """Rows of (name, [(caption, second line, image)]) on one sheet."""
    columns = max(len(tiles) for _, tiles in rows)
    cell = (args.size + MARGIN, args.size + 2 * LINE + MARGIN)
    picture = Image.new("RGB", (HEAD + columns * cell[0] + MARGIN, len(rows) * cell[1] + MARGIN), PAPER)
    draw = ImageDraw.Draw(picture)
    for r, (name, tiles) in enumerate(rows):
        y = MARGIN + r * cell[1]
        draw.text((MARGIN, y + args.size // 2), name, fill=INK, font=font(13))
        for c, (caption, second, image) in enumerate(tiles):
            x = HEAD + c * cell[0]
            picture.paste(image, (x, y))
            draw.text((x, y + args.size + 1), caption, fill=INK, font=font(12))
            draw.text((x, y + args.size + LINE - 1), second, fill=FAINT, font=font(11))
    return picture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kaustika", default=os.path.join(ROOT, "target", "release", "kaustika"))
    parser.add_argument("--size", type=int, default=160)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--images", default=os.path.join(ROOT, "docs", "images"), help="folder for the figures")
    parser.add_argument("--only", nargs="*", help="methods; the figure of shots is left out")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        image = os.path.join(folder, "tile.png")
        rows = []
        for decade, methods in METHODS.items():
            chosen = [m for m in methods if not args.only or m[2] in args.only]
            tiles = [(what, f"{year}: {m}", render(args, m, spp, p, image)) for what, year, m, spp, p in chosen]
            if tiles:
                rows.append((decade, tiles))
        sheet(args, rows).save(os.path.join(args.images, "history.png"), optimize=True)
        if args.only:
            return
        rows = []
        for ambient in ("false", "true"):
            common = ["direct=mesh", "solver=southwell", "patches=8000", f"ambient={ambient}"]
            tiles = [(f"{n} shot" + "s" * (n > 1), "with ambient" if ambient == "true" else "",
                      render(args, "radiosity", 16, common + [f"shots={n}"], image)) for n in SHOTS]
            rows.append(("", tiles))
        sheet(args, rows).save(os.path.join(args.images, "southwell.png"), optimize=True)


if __name__ == "__main__":
    main()
