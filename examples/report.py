"""A fit to look at: its page, which any browser opens offline, and its deviation as a picture.

Writes out/report.html and out/deviation.png (or into the folder given), and out/report.png, the page as a browser shows
it, where there is a Chromium.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt

import cadfit

DATA = Path(__file__).parent / "data"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")


def photographed(page, picture):
    """Take a picture of a page, and return whether a browser was there to do so."""
    browser = os.environ.get("CADFIT_CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        return False
    with tempfile.TemporaryDirectory() as folder:
        options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"]
        options += ["--window-size=1280,800", f"--user-data-dir={folder}", f"--screenshot={picture.resolve()}"]
        subprocess.run([browser, *options, page.resolve().as_uri()], check=True, capture_output=True, timeout=120)
    return True


def main(folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    fit = cadfit.fit(200.0 * cadfit.read(DATA / "rae2822.dat"), 0.02)
    fit.report(folder / "report.html", title="RAE 2822, chord 200 mm", unit="mm")
    fit.plot_deviation(plt.subplots(figsize=(8.0, 3.0), layout="constrained")[1], unit="mm").figure.savefig(
        folder / "deviation.png", dpi=130
    )
    plt.close("all")
    shown = photographed(folder / "report.html", folder / "report.png")
    print(f"report.html: {(folder / 'report.html').stat().st_size / 1e3:.0f} kB, {fit}")
    return {"fit": fit, "shown": shown}


if __name__ == "__main__":
    main(*sys.argv[1:] or ["out"])
