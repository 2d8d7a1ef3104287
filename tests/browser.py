"""A headless browser for tests that look at pages; without one they are skipped, with a sentence."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.tools import program

MACOS = "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", MACOS)


def browser() -> str:
    """The program; see ``tests.tools``."""
    return program(BROWSERS, "that shows pages", "chromium")


def screenshot(page: Path, folder: Path, fragment: str = "", size: tuple[int, int] = (900, 600)) -> NDArray[np.uint8]:
    """Open a page without a network and return what it looks like, (height, width, 3).

    Args:
        page: the HTML file.
        folder: where the browser keeps its profile and the picture.
        fragment: what follows the "#" of the address.
        size: width and height of the window, pixels.
    """
    import matplotlib.image

    picture = folder / "page.png"
    picture.unlink(missing_ok=True)
    done = _run(page, folder, fragment, f"--window-size={size[0]},{size[1]}", f"--screenshot={picture}")
    assert picture.is_file(), done.stderr
    pixels = np.asarray(matplotlib.image.imread(picture))[:, :, :3]
    return np.asarray(np.rint(255.0 * pixels), dtype=np.uint8)


def document(page: Path, folder: Path) -> str:
    """Open a page without a network and return its document as the programs of the page left it."""
    return _run(page, folder, "", "--dump-dom").stdout


def _run(page: Path, folder: Path, fragment: str, *options: str) -> subprocess.CompletedProcess[str]:
    common = (
        *("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage"),
        *("--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=3000"),
        f"--user-data-dir={folder / 'profile'}",
    )
    address = page.resolve().as_uri() + (f"#{fragment}" if fragment else "")
    command = (browser(), *common, *options, address)
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=90)


def share_of_ink(pixels: NDArray[np.uint8]) -> float:
    """Share of the pixels that differ from the most frequent colour, which is the background."""
    flat = pixels.reshape(-1, 3).astype(np.int64) @ np.array([65536, 256, 1])
    _, counts = np.unique(flat, return_counts=True)
    return 1.0 - float(counts.max()) / flat.size
