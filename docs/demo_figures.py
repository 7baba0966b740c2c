# SPDX-License-Identifier: MIT
"""Figures and printed output of the demos: `python3 docs/demo_figures.py [FOLDER] [NAME...]`, default docs/figures.

Runs the demos and applications (all, or those named) and writes their PNG files, with fewer colours, as
demo_<name>_<file>.png, or demo_<file>.png where the file begins with the name, and what they print as demo_<name>.txt.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from dolfinx_impact import cli


def shrink(source, target, limit=190_000):
    """Copy a PNG with as many colours as keep it below `limit` bytes."""
    image = Image.open(source).convert("RGB")
    for colours in (256, 160, 96, 64):
        image.quantize(colours, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(target, optimize=True)
        if target.stat().st_size < limit:
            return
    raise RuntimeError(f"{source}: still {target.stat().st_size} bytes with 64 colours; draw it smaller")


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "docs/figures")
    folder.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[2:] or cli.demos():
        with tempfile.TemporaryDirectory() as results:
            command = [sys.executable, "-m", "dolfinx_impact.cli", "demo", name, "--output", results]
            done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
            if done.returncode:
                print(done.stdout)
                return done.returncode
            lines = done.stdout.replace(results, f"results/{name}").strip().splitlines()
            (folder / f"demo_{name}.txt").write_text("".join(f"{line.rstrip()}\n" for line in lines))
            for picture in sorted(Path(results).glob("*.png")):
                target = folder / f"demo_{picture.name if picture.stem.startswith(name) else f'{name}_{picture.name}'}"
                shrink(picture, target)
                print(f"{target}: {target.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
