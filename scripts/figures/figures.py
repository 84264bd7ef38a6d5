"""Draw the figures of the documents into docs/figures/, with their numbers (numbers.json), and fill in the tables of docs/*.md.

    python -m scripts.figures.figures [--only NAME]... [--grid N] [--output DIR]
"""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
import time

from scripts.figures import (
    figures_article,
    figures_borders,
    figures_creep_table,
    figures_documents,
    figures_frame,
    figures_measured,
    figures_numerics,
    figures_peers,
    figures_pictures,
    figures_polymers,
    figures_recirculation,
    figures_verification,
)
from scripts.figures.figures_drawing import ROOT
from thermoroll_cli.plots.style import applied

MODULES = (figures_frame, figures_pictures, figures_article, figures_numerics, figures_borders, figures_peers, figures_measured,
           figures_verification, figures_recirculation, figures_creep_table, figures_polymers)
FIGURES = {name: draw for module in MODULES for name, draw in module.FIGURES.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", choices=FIGURES, help="draw this one (repeatable); default: all")
    parser.add_argument("--grid", type=int, default=128, help="elements per side (default 128)")
    parser.add_argument("--output", type=pathlib.Path, default=ROOT / "docs" / "figures")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    record = options.output / "numbers.json"
    numbers = json.loads(record.read_text()) if record.exists() else {}
    drawn = options.only or list(FIGURES)
    with applied():
        for name in drawn:
            start = time.perf_counter()
            numbers[name] = FIGURES[name](options.output, options.grid)
            text = json.dumps({name: numbers[name] for name in FIGURES if name in numbers}, indent=1, ensure_ascii=False)
            record.write_text(text + "\n", encoding="utf-8")
            print(f"{name}: {time.perf_counter() - start:.1f} s", file=sys.stderr, flush=True)
    if options.output == ROOT / "docs" / "figures":
        # Tables of figures that were not drawn now stay as they are in the documents.
        measured = {name: numbers[name] for name in drawn}
        figures_documents.fill(ROOT / "docs", {
            **measured, "declared": figures_documents.declared(), "measured": {"claims": figures_documents.claims()}})
        if not options.only:
            figures_documents.run_commands(ROOT / "docs" / "tutorial.md")


if __name__ == "__main__":
    main()
